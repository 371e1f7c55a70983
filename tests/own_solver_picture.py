"""Draw reports/handbook/own-solver.svg from runs of the README's solver: `python tests/own_solver_picture.py`, half a minute."""

import re

import numpy as np
from handbook import FOLDER, file

from mpmverify import studies
from mpmverify.criteria import Order
from mpmverify.execution.verify import verify
from mpmverify.study import Refinement

PICTURE = FOLDER / "own-solver.svg"
LEVELS = studies.get("generalised-vortex").cases[0].ladder.levels
"""Those on which the case has a solver of any origin judged."""
COLUMNS = (
    ("the solver below", "", ""),
    ("with PIC instead of FLIP", "v += N @ dv", "v = N @ (N.T @ (m * v) / M + dv)"),
    ("with its load one step late", "[n * dt]", "[(n + 1) * dt]"),
)
"""What is drawn: a title, and the text that is replaced in the solver by another."""
SIDE, PLOT, GAP = 210, 120, 70
STYLE = """
svg{font:15px system-ui,-apple-system,'Segoe UI',Helvetica,Arial,sans-serif}
.card{fill:#fff;stroke:#d0d7de}.ink{fill:#1f2328}.mute{fill:#59636e;font-size:13px}.axis{stroke:#8c959f;fill:none}
.a{stroke:#0b63b5}.b{stroke:#e08a1e}.dots{stroke-width:2.9;stroke-linecap:round}.band{fill:#8c959f;opacity:.28}
.line{stroke:#1f2328;stroke-width:2.2;fill:none}.point{fill:#1f2328}
.PASS{fill:#1a7f37}.FAIL{fill:#cf222e}.INCONCLUSIVE{fill:#8a5a00}.chip{fill:#fff;font-weight:600;font-size:14px}
@media(prefers-color-scheme:dark){
.card{fill:#0d1117;stroke:#3d444d}.ink{fill:#f0f6fc}.mute{fill:#9198a1}.axis{stroke:#656c76}
.a{stroke:#58a6ff}.b{stroke:#f2b25c}.line{stroke:#f0f6fc}.point{fill:#f0f6fc}
.PASS{fill:#238636}.FAIL{fill:#da3633}.INCONCLUSIVE{fill:#9e6a03}}
"""


def solver(right: str = "", wrong: str = ""):
    """The solver of the README, with a text in it replaced by another."""
    text = file("test_own_mpm.py")
    assert not right or text.count(right) == 1, right
    names: dict = {}
    exec(text.replace(right, wrong) if right else text, names)
    return names["OwnMPM"]()


def judged(chosen, levels=LEVELS):
    """Verdict and reason of a solver on the vortex."""
    second = Order("displacement", "L2-max", 1.8, 2.2, "second order")
    (finding,) = verify(
        chosen,
        studies.get("generalised-vortex"),
        "1 rad",
        refinement=Refinement("levels", levels, len(levels)),
        criteria=[second],
    )
    return str(finding.verdict), finding.reason


def caption(verdict: str, reason: str) -> str:
    """Verdict and order, as the picture has them."""
    order, low, high = re.search(r"order (\S+), interval \[(\S+), (\S+)\]", reason).groups()
    return f"{verdict}  order {float(order):.2f} [{float(low):.2f}, {float(high):.2f}]"


def errors(chosen) -> np.ndarray:
    """Largest L2 error in time of the displacement, by level; and the particles at the greatest angle on the coarsest one."""
    vortex = studies.get("generalised-vortex").cases[0].problem
    found, seen = [], None
    for level in LEVELS:
        solution = chosen.solve(vortex.problem, level)
        away = solution.fields["displacement"] - vortex.exact.fields["displacement"](solution.reference, solution.time)
        found.append(np.sqrt((solution.weight[..., None] * away**2).sum(axis=(1, 2)).max()))
        seen = seen or (solution.reference, solution.position[np.abs(solution.time - 0.5).argmin()])
    return np.array(found), *seen


def dots(reference, position) -> str:
    """Every other particle where it is at 0.5 s, in two colours by the sector that it started from."""
    spacing = LEVELS[0].h / LEVELS[0].ppc
    kept = np.floor((reference + 1.5) / spacing).sum(axis=1) % 2 == 0
    sector = np.floor(np.arctan2(*reference[kept].T) / (np.pi / 3)) % 2
    x, y = np.rint((position[kept] + 1.3) * SIDE / 2.6).astype(int).T
    lines = []
    for kind, name in enumerate("ab"):
        path = "".join(f"M{i} {SIDE - j}h0" for i, j in zip(x[sector == kind], y[sector == kind], strict=True))
        lines.append(f'<path class="dots {name}" d="{path}"/>')
    return "".join(lines)


def plot(error) -> str:
    """Error against h, both by logarithm and relative to the coarsest level, over the band of orders that pass."""
    h = np.array([level.h for level in LEVELS])

    def at(h, error):
        return 20 + (SIDE - 40) * np.log(h / LEVELS[-1].h) / np.log(1.5), 10 - (PLOT - 20) * np.log(error) / np.log(2.5)

    points = [at(size, value) for size, value in zip(h, error / error[0], strict=True)]
    right, (x, low), (_, high) = at(h[0], 1), at(h[-1], 1.5**-1.8), at(h[-1], 1.5**-2.2)
    band = f"{right[0]:.1f},{right[1]:.1f} {x:.1f},{low:.1f} {x:.1f},{high:.1f}"
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    circles = "".join(f'<circle class="point" cx="{x:.1f}" cy="{y:.1f}" r="3.6"/>' for x, y in points)
    axes = f'<path class="axis" d="M.5 0V{PLOT}.5H{SIDE}"/>'
    return f'{axes}<polygon class="band" points="{band}"/><polyline class="line" points="{line}"/>{circles}'


def draw() -> str:
    """The picture."""
    width, height = 3 * (SIDE + GAP) + 20, SIDE + PLOT + 150
    parts = [f'<rect class="card" x=".5" y=".5" width="{width - 1}" height="{height - 1}" rx="10"/>']
    told = []
    for column, (title, right, wrong) in enumerate(COLUMNS):
        chosen = solver(right, wrong)
        error, reference, position = errors(chosen)
        verdict, reason = judged(chosen)
        told.append(f"{title}: {caption(verdict, reason)}")
        label, middle = caption(verdict, reason).split("  "), SIDE / 2
        parts.append(
            f'<g transform="translate({column * (SIDE + GAP) + 45},0)">'
            f'<text class="ink" x="{middle}" y="32" text-anchor="middle">{title}</text>'
            f'<g transform="translate(0,46)">{dots(reference, position)}</g>'
            f'<g transform="translate(0,{SIDE + 62})">{plot(error)}</g>'
            f'<text class="mute" x="{SIDE}" y="{SIDE + PLOT + 79}" text-anchor="end">h</text>'
            f'<text class="mute" transform="translate(-9,{SIDE + 62}) rotate(-90)" text-anchor="end">error</text>'
            f'<rect class="{verdict}" x="{middle - 66}" y="{SIDE + PLOT + 77}" width="132" height="27" rx="13.5"/>'
            f'<text class="chip" x="{middle}" y="{SIDE + PLOT + 96}" text-anchor="middle">{label[0]}</text>'
            f'<text class="mute" x="{middle}" y="{SIDE + PLOT + 127}" text-anchor="middle">{label[1]}</text></g>'
        )
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img">'
    )
    return f"{head}<title>{'; '.join(told)}</title><style>{STYLE.strip()}</style>{''.join(parts)}</svg>\n"


if __name__ == "__main__":
    PICTURE.write_text(draw(), encoding="utf-8")
    print(f"{PICTURE}: {PICTURE.stat().st_size} bytes")

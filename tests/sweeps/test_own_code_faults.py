"""Faults that authors of plane material point codes make, one at a time in one that the bench does not ship: each FAILs.

The code passes every case here by what it declares. A fault is text of its source that is replaced. What no plane case sees, since
linear elastic bodies are strained by 1e-5 there, is the spin in the rate of their stress.
"""

import sys
import types
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from mpmverify import studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import ExactTotal
from mpmverify.criteria.criterion import Criterion
from mpmverify.execution.verify import verify
from mpmverify.judgement.findings import Finding

SOURCE = Path(__file__).with_name("own_plane_code.py")
Replaced = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Bench:
    """A case, with the options of the code that suit it; what the code declares is judged unless there are criteria."""

    study: str
    case: str
    options: dict[str, Any] = field(default_factory=dict)
    tier: str = "quick"
    criteria: tuple[Criterion, ...] | None = None

    def found(self, replaced: Replaced = ()) -> tuple[Finding, ...]:
        solver = code(replaced).OwnPlane(**self.options)
        return verify(solver, studies.get(self.study), self.case, tier=self.tier, criteria=self.criteria)


LINEAR = {"basis": "linear"}
BENCHES = {
    "waves between clamped faces": Bench("plane-waves", "clamped"),
    "waves between slip walls": Bench("plane-waves", "neo-hookean-updated"),
    "large waves between slip walls": Bench("plane-waves", "neo-hookean-affine"),
    "large shear": Bench("loads-and-supports", "layer, splines"),
    "load": Bench("loads-and-supports", "block, plane", LINEAR),
    "drift": Bench("moving-bodies", "square", {"musl": True}, "full"),
    "rotation": Bench("patch-tests", "rotation, 2D", {"musl": True, "judged": ("displacement",)}),
    "energy": Bench("moving-bodies", "square", {"musl": True, "conserves": frozenset({"energy"})}, "full"),
    "rigid bodies": Bench(
        "moving-bodies", "blocks, plane", LINEAR, criteria=(ExactTotal("angular_momentum", "bodies at constant velocity"),)
    ),
}

A = "a = grid.sign * (grid.gather(f, grid.sign) / mass)[grid.to]"
V_NODE = "v_node = grid.sign * (grid.gather(N.T @ (m[:, None] * v), grid.sign) / mass)[grid.to]"
MIRROR = "sign[beyond, held], sign[wall, held] = -1, 0"
LAME = "law.lame_lambda, law.shear_modulus"
UPDATE = "F = F + dt * L @ F"
MOVE = "x = x + dt * (N @ v_node)"
KICK = "kick = dt if n else dt / 2"
CAUCHY = "stress.reshape(-1, 4)[:, [0, 3, 1]]"

FAULTS: dict[str, tuple[str, Replaced]] = {
    # stress and strain
    "Kirchhoff stress for Cauchy stress": (
        "large waves between slip walls",
        (("(b - I)) / J[:, None, None]", "(b - I))"),),
    ),
    "volume not updated": ("large waves between slip walls", (("V, t = V0 * J", "V, t = V0"),)),
    "spin left out": ("large shear", ((UPDATE, "F = F + dt / 2 * (L + L.swapaxes(1, 2)) @ F"),)),
    "gradient transposed": ("large shear", (("N_y @ v_node], 2)", "N_y @ v_node], 1)"),)),
    "strain of the undeformed body": ("drift", ((UPDATE, "F = F + dt * L"),)),
    "engineering shear strain": (
        "waves between clamped faces",
        (("rate = 2 * mu * D", "rate = 2 * mu * D * (2 - I)"),),
    ),
    "lambda of plane stress": (
        "waves between clamped faces",
        ((LAME, "2 * law.lame_lambda * law.shear_modulus / (law.lame_lambda + 2 * law.shear_modulus), law.shear_modulus"),),
    ),
    "lambda by 1 %": ("waves between slip walls", ((LAME, "1.01 * law.lame_lambda, law.shear_modulus"),)),
    "shear modulus by 1 %": ("large shear", ((LAME, "law.lame_lambda, 1.01 * law.shear_modulus"),)),
    "Young's modulus for twice the shear modulus": (
        "waves between clamped faces",
        ((LAME, "law.lame_lambda, law.youngs_modulus / 2"),),
    ),
    "shear force of the other sign": (
        "waves between clamped faces",
        (("(V[:, None] * stress[:, 1])", "(V[:, None] * stress[:, 1] * [-1, 1])"),),
    ),
    "initial stress in another order": ("waves between clamped faces", (("[:, [0, 2, 2, 1]]", "[:, [0, 1, 1, 2]]"),)),
    "stress one step late": (
        "large shear",
        (
            ("J = np.linalg.det(F)\n", "F_now, F = F, F_old if n else F\n            J = np.linalg.det(F)\n"),
            ("            # the step\n", "            F_old, F = F_now, F_now\n"),
        ),
    ),
    # time
    "velocity starts with a full step": ("waves between clamped faces", ((KICK, "kick = dt"),)),
    "body force one step late": ("drift", (("problem.force(X, x, t)", "problem.force(X, x, t + dt)"),)),
    "body force half a step late": ("drift", (("problem.force(X, x, t)", "problem.force(X, x, t + dt / 2)"),)),
    "load half a step late": ("load", (("(np.array([t]))[0]", "(np.array([t + dt / 2]))[0]"),)),
    "dt of the strain by 1 %": ("large shear", ((UPDATE, "F = F + 1.01 * dt * L @ F"),)),
    "dt of the positions by 1 %": ("large shear", ((MOVE, "x = x + 1.01 * dt * (N @ v_node)"),)),
    "dt of the velocities by 1 %": ("waves between clamped faces", ((KICK, "kick = 1.01 * (dt if n else dt / 2)"),)),
    # faces
    "wall holds the velocity and not the force": (
        "waves between clamped faces",
        ((A, "a = (grid.gather(f, grid.sign**0) / mass)[grid.to]"),),
    ),
    "mirror image of the force of the same sign": ("large shear", ((A, "a = (grid.gather(f, grid.sign**2) / mass)[grid.to]"),)),
    "wall holds the force and not the velocity": (
        "waves between clamped faces",
        ((V_NODE, "v_node = (grid.gather(N.T @ (m[:, None] * v), grid.sign**0) / mass)[grid.to]"),),
    ),
    "wall held at one end alone": (
        "waves between clamped faces",
        (("(ends[1], n + 2, n + 1, n - 1)", "(ends[1], n + 2, n + 2, n + 1)"),),
    ),
    "clamped face holds its normal alone": (
        "waves between clamped faces",
        (("[0, 1] if end == Fixed() else [axis]", "[axis]"),),
    ),
    "slip wall clamps": ("large waves between slip walls", (("[0, 1] if end == Fixed() else [axis]", "[0, 1]"),)),
    "mirror image of the same sign": ("large waves between slip walls", ((MIRROR, "sign[wall, held] = 0"),)),
    "no mirror image": ("large waves between slip walls", ((MIRROR, "sign[beyond, held], sign[wall, held] = 0, 0"),)),
    "mirror image without its mass": (
        "waves between clamped faces",
        (("mass = grid.gather(M[:, None], np.ones((grid.count, 1)))", "mass = M[grid.to][:, None]"),),
    ),
    "traction with twice the area": ("load", (("width if face[1]", "2 * width if face[1]"),)),
    "traction of the other sign on lower faces": ("load", (('width if face[1] == "+" else -width', "width"),)),
    "traction on the whole face": (
        "load",
        (
            (
                "count = round((block.upper[along] - block.lower[along]) / width)",
                "count = round(problem.lengths[along] / width)",
            ),
            ("points[:, along] = block.lower[along] +", "points[:, along] = problem.lower[along] +"),
        ),
    ),
    # particles and nodes
    "mass by the particles of a row": (
        "large shear",
        (("m, lame, mu = law.density * V0,", "m, lame, mu = law.density * V0 * discretisation.ppc,"),),
    ),
    "density by 1 %": ("waves between clamped faces", (("m, lame, mu = law.density", "m, lame, mu = 1.01 * law.density"),)),
    "PIC for FLIP": ("waves between clamped faces", (("v = v + kick * (N @ a)", "v = N @ (v_node + kick * a)"),)),
    "particles moved by their own velocity": ("rotation", ((MOVE, "x = x + dt * v"),)),
    "particles moved by the velocity before the step": (
        "waves between clamped faces",
        ((MOVE, "x = x + dt * (N @ (v_node - kick * a))"),),
    ),
    "first node one cell off": ("large shear", (("np.floor(s - (size - 2) / 2)", "np.floor(s)"),)),
    # what is returned
    "velocity half a step old": ("waves between clamped faces", (("x - X, v_now,", "x - X, v,"),)),
    "shear stress of the other sign": ("waves between clamped faces", ((CAUCHY, f"{CAUCHY} * [1, 1, -1]"),)),
    "normal stresses exchanged": ("waves between clamped faces", ((CAUCHY, "stress.reshape(-1, 4)[:, [3, 0, 1]]"),)),
    "displacement gradient transposed": (
        "waves between clamped faces",
        (("(F - I).reshape(-1, 4)", "(F - I).swapaxes(1, 2).reshape(-1, 4)"),),
    ),
    "momentum half a step old": ("waves between clamped faces", (("(*(m @ v_now), *impulse)", "(*(m @ v), *impulse)"),)),
    "impulse without the walls": ("waves between clamped faces", ((" + (M[:, None] * a - f).sum(0)", ""),)),
    "impulse half a step short": ("waves between clamped faces", (("impulse + half * force", "impulse"),)),
    "mass by the current volume": ("large waves between slip walls", (('"mass": m.sum()', '"mass": law.density * V.sum()'),)),
    "kinetic energy twice": ("energy", (("(m @ v_now**2).sum() / 2", "(m @ v_now**2).sum()"),)),
    "kinetic energy half a step old": ("energy", (("(m @ v_now**2).sum() / 2", "(m @ v**2).sum() / 2"),)),
    "strain energy by the current volume": ("energy", (("V0 @ stored", "V @ stored"),)),
    "external work twice": ("energy", (('"external_work": work', '"external_work": 2 * work'),)),
    "angular momentum of the other sign": ("rigid bodies", (("v_now[:, 1] - x[:, 1]", "v_now[:, 1] + x[:, 1]"),)),
}


def code(replaced: Replaced = ()) -> types.ModuleType:
    """The code as a module, with text of its source replaced."""
    source = SOURCE.read_text(encoding="utf-8")
    for old, new in replaced:
        assert old in source, f"the source no longer has {old!r}"
        source = source.replace(old, new)
    module = types.ModuleType(f"{SOURCE.stem}_{abs(hash(replaced))}")
    sys.modules[module.__name__] = module  # where a dataclass looks its module up
    try:
        exec(compile(source, SOURCE.name, "exec"), module.__dict__)
    finally:
        del sys.modules[module.__name__]
    return module


@pytest.mark.parametrize("bench", BENCHES)
def test_the_right_code_passes(bench: str) -> None:
    found = BENCHES[bench].found()
    assert {finding.verdict for finding in found} == {Verdict.PASS}, found


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_fails(fault: str) -> None:
    bench, replaced = FAULTS[fault]
    found = BENCHES[bench].found(replaced)
    assert Verdict.FAIL in {finding.verdict for finding in found}, found
    assert {finding.gate for finding in found} == {"verification"}

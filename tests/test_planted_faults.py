"""A wrong solver fails: a fault planted in a copy of a shipped solver turns a verdict of a study to FAIL or ERROR.

Each copy is compiled from its own files and replaces the original in a study, with the same name and choices. The study is reduced
to the series of that solver and judged with its own criteria.
"""

import dataclasses
import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mpmverify.solvers
from mpmverify import studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import norms
from mpmverify.dataset.files import Results
from mpmverify.execution import evaluation
from mpmverify.execution.runner import Plan, run
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.selftest import faults as selftest
from mpmverify.selftest.faults import Edit
from mpmverify.selftest.planting import copied, planted
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Study

SOURCES = Path(mpmverify.solvers.__file__).parent
FAMILIES: dict[type, str] = {MaterialPoint: "mpm", FiniteElement: "fem", TaylorGalerkin: "taylor_galerkin"}
"""Folder of each solver class."""
LOOPS = {"mpm": ("loop", "march"), "fem": ("kernel", "advance"), "taylor_galerkin": ("kernel", "march")}
"""Module and name of each family's compiled time loop."""


@dataclasses.dataclass(frozen=True)
class Trial:
    """The series of one solver in one case of a study."""

    study: str
    case: str
    solver: Solver

    @property
    def family(self) -> str:
        return FAMILIES[type(self.solver)]

    def with_solver(self, replacement: Solver) -> Study:
        """Return the study reduced to this trial, with its criteria and its quick ladder, and with another solver."""
        study = studies.get(self.study)
        (case,) = (case for case in study.cases if case.name == self.case)
        series = tuple(dataclasses.replace(s, solver=replacement) for s in case.series if s.solver == self.solver)
        assert series, f"{self.study}/{self.case} does not run {self.solver.name}"
        return dataclasses.replace(study, cases=(dataclasses.replace(case, series=series),))


@dataclasses.dataclass(frozen=True)
class Kill:
    """A trial, the verdict that a fault must get in it, and the start of the title of the criterion that gives this verdict."""

    trial: Trial
    verdict: Verdict
    criterion: str


@dataclasses.dataclass(frozen=True)
class Fault:
    """A fault of one solver family and the trials that must detect it; with `keeps_orders`, every order criterion still passes."""

    name: str
    edits: tuple[Edit, ...]
    kills: tuple[Kill, ...]
    keeps_orders: bool = False

    @property
    def id(self) -> str:
        criteria = "-and-".join(f"{kill.verdict} {kill.criterion}" for kill in self.kills)
        return f"{self.kills[0].trial.family}-{self.name}-by-{criteria}".replace(" ", "-")


MPM_VIBRATION = Trial("axial-vibration", "small-strain", MaterialPoint("MUSL"))
MPM_PULSE = Trial("elastic-bar", "pulse", MaterialPoint("MUSL"))
MPM_FINITE_STRAIN = Trial("manufactured-1d", "crossing", MaterialPoint("MUSL", formulation="total"))
TG_VIBRATION = Trial("axial-vibration", "literature", TaylorGalerkin(passes=1))
TG_CONSISTENT_VIBRATION = Trial("axial-vibration", "literature", TaylorGalerkin(passes=3))
TG_PULSE = Trial("elastic-bar", "pulse", TaylorGalerkin(passes=1))
TG_STEP = Trial("advection", "step", TaylorGalerkin(passes=1))
TG_SPECTRUM = Trial("advection", "spectrum", TaylorGalerkin(passes=3))
TG_GAUSSIAN = Trial("advection", "gaussian", TaylorGalerkin(passes=3))
TG_LUMPED_GAUSSIAN = Trial("advection", "gaussian", TaylorGalerkin(passes=1))
TG_BEYOND = Trial("dispersion", "beyond-the-limit", TaylorGalerkin(passes=1))
TG_DISPERSION = Trial("dispersion", "ring", TaylorGalerkin(passes=3))
FEM_DISPERSION = Trial("dispersion", "fixed-fixed", FiniteElement(1, "consistent", "newmark"))
FEM_NEWMARK_PULSE = Trial("elastic-bar", "pulse", FiniteElement(1, "consistent", "newmark"))
MPM_DISPERSION = Trial("dispersion", "fixed-fixed", MaterialPoint("USL", formulation="total"))
TG_DECK = Trial("gehojerez-deck", "deck", TaylorGalerkin(passes=1))
FEM_VIBRATION = Trial("axial-vibration", "literature", FiniteElement(1, "consistent", "newmark"))
FEM_PULSE = Trial("elastic-bar", "pulse", FiniteElement(1, "lumped", "central-differences"))
FEM_NEO_HOOKEAN = Trial("manufactured-1d", "no-crossing", FiniteElement(2, "consistent", "central-differences"))
FEM_POISSON = Trial("manufactured-1d", "poisson", FiniteElement(2, "consistent", "central-differences"))

FAIL, ERROR = Verdict.FAIL, Verdict.ERROR
MPM_LAW, MPM_PASSES, MPM_GRID, MPM_FACES = "mpm/small_strain.py", "mpm/passes.py", "mpm/grid.py", "mpm/faces.py"
MPM_SOLVER, MPM_DEFORMATION = "mpm/solver.py", "mpm/deformation.py"
MPM_HOOKE = "return shifted(lame * trace(eps), 2 * shear, eps)"
MPM_STRAINED = "strained = strain(scheme, particles, some, scale(step.dt, gradient)"
MPM_NO_DT = MPM_STRAINED.replace("scale(step.dt, gradient)", "gradient")
MPM_STORED = "F, sigma = strain_and_stress(particles, some.numbers, zero)\n    J"
MPM_NEIGHBOURS = "tuple(q - where(q > 0, 1, 0) for q in some.numbers)"
TG_LOOP, TG_SOLVER = "taylor_galerkin/kernel.py", "taylor_galerkin/solver.py"
TG_MODULUS = "-(material.lame_lambda + 2 * material.shear_modulus)"
TG_FLUX = "                    R[i, k] -= dt * contour\n"
TG_GAIN = "                    gain[n + 1, k] -= dt * contour\n"
FEM_LOOP, FEM_SOLVER = "fem/kernel.py", "fem/solver.py"
FEM_NEO_HOOKEAN_STRESS = "return lame * ln_F / F + shear * e * (2 + e) / F,"
FEM_GAMMA = "        u += moved\n        v += {} * a\n", "        u += beta * dt * dt * a\n        v += {} * a\n"

FAULTS = (
    # Constitutive laws
    Fault(
        "linear-modulus-halved",
        (Edit(MPM_LAW, MPM_HOOKE, "return shifted(0.5 * lame * trace(eps), shear, eps)"),),
        (Kill(MPM_VIBRATION, FAIL, "energy drift"), Kill(MPM_PULSE, FAIL, "order of displacement")),
    ),
    Fault(
        "neo-hookean-lambda-dropped",
        (Edit(FEM_LOOP, FEM_NEO_HOOKEAN_STRESS, "return shear * e * (2 + e) / F,"),),
        (Kill(FEM_POISSON, FAIL, "order of displacement"),),
    ),
    Fault(
        "beta-of-one-sixth",
        (Edit(FEM_SOLVER, '"newmark": 0.25', '"newmark": 1 / 6'),),
        (Kill(FEM_VIBRATION, FAIL, "energy conserved"),),
    ),
    Fault(
        "modulus-in-flux-matrix-halved",
        (Edit(TG_SOLVER, TG_MODULUS, TG_MODULUS.replace("-(", "-0.5 * (")),),
        (Kill(TG_VIBRATION, FAIL, "order of stress"), Kill(TG_DECK, FAIL, "stress exact")),
    ),
    Fault(
        "linear-modulus-halved",
        (Edit(FEM_LOOP, "return (lame + 2 * shear) * e,", "return 0.5 * (lame + 2 * shear) * e,"),),
        (Kill(FEM_PULSE, FAIL, "order of displacement"), Kill(FEM_VIBRATION, FAIL, "energy conserved")),
    ),
    Fault(
        "neo-hookean-mu-halved",
        (Edit(FEM_LOOP, FEM_NEO_HOOKEAN_STRESS, FEM_NEO_HOOKEAN_STRESS.replace("shear", "0.5 * shear")),),
        (Kill(FEM_NEO_HOOKEAN, FAIL, "order of displacement"),),
    ),
    # Material points
    Fault(
        "dt-dropped-from-strain-increment",
        (
            Edit(MPM_PASSES, f"USL)):\n{20 * ' '}{MPM_STRAINED}", f"USL)):\n{20 * ' '}{MPM_NO_DT}"),
            Edit(MPM_PASSES, f"limits))\n{8 * ' '}{MPM_STRAINED}", f"limits))\n{8 * ' '}{MPM_NO_DT}"),
        ),
        (Kill(MPM_VIBRATION, ERROR, "order of displacement"),),
    ),
    Fault(
        "traction-sign-flipped",
        (Edit(MPM_FACES, "force.append(sign * values)", "force.append(-sign * values)"),),
        (Kill(MPM_PULSE, FAIL, "order of velocity"),),
    ),
    Fault(
        "body-force-dropped",
        (Edit(MPM_PASSES, "scale(m, b)", "scale(0.0, b)"),),
        (Kill(MPM_FINITE_STRAIN, FAIL, "order of displacement"),),
    ),
    Fault(
        "flip-and-pic-swapped",
        (
            Edit(MPM_PASSES, "v = axpy(scheme.flip, ", "v = axpy(1 - scheme.flip, "),
            Edit(MPM_PASSES, "scale(1 - scheme.flip, moved)", "scale(scheme.flip, moved)"),
        ),
        (Kill(MPM_VIBRATION, FAIL, "momentum less impulse"),),
    ),
    # Taylor-Galerkin
    Fault(
        "boundary-flux-dropped",
        (Edit(TG_LOOP, TG_FLUX, ""),),
        (Kill(TG_VIBRATION, ERROR, "momentum less impulse"), Kill(TG_STEP, FAIL, "mass less inflow")),
    ),
    Fault(
        "boundary-flux-dropped-from-update-and-balance",
        (Edit(TG_LOOP, TG_FLUX + TG_GAIN, "                    pass\n"),),
        (Kill(TG_PULSE, FAIL, "order of stress"),),
    ),
    Fault(
        "contour-normal-flipped",
        (Edit(TG_LOOP, "contour = normal * dot(A[k], trace)", "contour = -normal * dot(A[k], trace)"),),
        (Kill(TG_PULSE, ERROR, "order of velocity"),),
    ),
    Fault(
        "dt-instead-of-half-dt-in-predictor",
        (Edit(TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - dt * ("),),
        (Kill(TG_VIBRATION, FAIL, "order of velocity"), Kill(TG_SPECTRUM, FAIL, "amplification factor")),
    ),
    Fault(
        "full-mass-at-the-end-nodes",
        (Edit(TG_SOLVER, "mass[[0, -1]] = 0.5 * h", "pass"),),
        (Kill(TG_DECK, FAIL, "velocity exact"),),
    ),
    # Finite elements
    Fault(
        "traction-sign-flipped",
        (Edit(FEM_SOLVER, "normal * condition.value(t)", "-normal * condition.value(t)"),),
        (Kill(FEM_PULSE, FAIL, "order of velocity"),),
    ),
    Fault(
        "sign-of-beta-flipped-in-predictor",
        (Edit(FEM_LOOP, "dt * dt * (0.5 - beta) * a", "dt * dt * (0.5 + beta) * a"),),
        (Kill(FEM_VIBRATION, FAIL, "order of displacement"),),
    ),
    Fault(
        "gamma-of-0.6",
        tuple(
            Edit(FEM_LOOP, text.format("dt / 2"), text.format(share))
            for text, share in zip(FEM_GAMMA, ("0.4 * dt", "0.6 * dt"), strict=True)
        ),
        (Kill(FEM_VIBRATION, FAIL, "energy conserved"), Kill(FEM_PULSE, FAIL, "order of velocity")),
    ),
    Fault(
        "body-force-dropped",
        (Edit(FEM_SOLVER, "(law.density * weight) @ values", "(0.0 * weight) @ values"),),
        (Kill(FEM_NEO_HOOKEAN, FAIL, "order of stress"),),
    ),
    # Faults that keep every order
    Fault(
        "mass-between-lumped-and-consistent",
        (
            Edit(TG_LOOP, "h / 6 * (2 * dU[i, k] + dU[j, k])", "h / 8 * (3 * dU[i, k] + dU[j, k])"),
            Edit(TG_LOOP, "h / 6 * (dU[i, k] + 2 * dU[j, k])", "h / 8 * (dU[i, k] + 3 * dU[j, k])"),
        ),
        (
            Kill(TG_DISPERSION, FAIL, "dispersion of stress"),
            Kill(TG_GAUSSIAN, FAIL, "phase error of u"),
        ),
        keeps_orders=True,
    ),
    Fault(
        "viscosity-of-order-dt-squared",
        (Edit(TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - (0.5 + 0.2 * dt) * dt * ("),),
        (Kill(TG_LUMPED_GAUSSIAN, FAIL, "amplitude decay of u"),),
        keeps_orders=True,
    ),
    Fault(
        "viscosity-of-order-dt",
        (Edit(TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - 0.6 * dt * ("),),
        (Kill(TG_STEP, FAIL, "front of u"),),
        keeps_orders=True,
    ),
    Fault(
        "prescribed-unknown-not-held-in-later-passes",
        (Edit(TG_LOOP, "if bounded and sweep > 0:", "if bounded and sweep > passes:"),),
        (Kill(TG_CONSISTENT_VIBRATION, FAIL, "energy never rises"),),
        keeps_orders=True,
    ),
    Fault(
        "momentum-and-impulse-of-zero",
        (
            Edit(TG_SOLVER, '"momentum": rho * total[:, 1]', '"momentum": 0 * total[:, 1]'),
            Edit(TG_SOLVER, '"impulse": rho * gain[:, 1]', '"impulse": 0 * gain[:, 1]'),
        ),
        (Kill(TG_PULSE, FAIL, "mass, momentum summed from the fields"),),
        keeps_orders=True,
    ),
    Fault(
        "strain-energy-of-the-neighbouring-volume",
        (Edit(MPM_DEFORMATION, MPM_STORED, MPM_STORED.replace("some.numbers", MPM_NEIGHBOURS)),),
        (Kill(MPM_PULSE, FAIL, "mass, momentum, kinetic_energy, strain_energy summed"),),
        keeps_orders=True,
    ),
    Fault(
        "usf-and-usl-swapped",
        (Edit(MPM_SOLVER, '"USF": passes.USF, "USL": passes.USL', '"USF": passes.USL, "USL": passes.USF'),),
        (Kill(MPM_DISPERSION, FAIL, "dispersion of stress"),),
    ),
    Fault(
        "instability-not-reported",
        (Edit(TG_LOOP, "if not amplitude <= limit[n + 1]:", "if not amplitude <= 1e300 * limit[n + 1]:"),),
        (Kill(TG_BEYOND, FAIL, "unstable above nu_C = 1"),),
    ),
    Fault(
        "beta-of-0.3",
        (Edit(FEM_SOLVER, '"newmark": 0.25', '"newmark": 0.3'),),
        (Kill(FEM_DISPERSION, FAIL, "dispersion of stress"), Kill(FEM_NEWMARK_PULSE, FAIL, "phase error of velocity")),
        keeps_orders=True,
    ),
    Fault(
        "modulus-off-by-a-billionth",
        (Edit(MPM_LAW, MPM_HOOKE, "return shifted((1 + 1e-9) * lame * trace(eps), (1 + 1e-9) * 2 * shear, eps)"),),
        (Kill(MPM_DISPERSION, FAIL, "dispersion of stress"),),
    ),
)
TRIALS = tuple(dict.fromkeys(kill.trial for fault in FAULTS for kill in fault.kills))


def verification(study: Study, folder: Path) -> list[Finding]:
    """Run a study in this process, without a baseline, and return its verification findings."""
    (judged,) = run([study], Plan(Results(folder / "results"), Baseline(folder / "baseline.json"), jobs=0))
    assert judged.solved > 0
    assert judged.reused == 0
    return [finding for finding in judged.findings if finding.gate == "verification"]


def assert_killed(findings: list[Finding], verdict: Verdict, criterion: str) -> None:
    killers = [finding for finding in findings if finding.verdict in (FAIL, ERROR)]
    found = "\n".join(map(str, findings))
    assert any(killer.verdict is verdict and killer.criterion.startswith(criterion) for killer in killers), found


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.id)
def test_a_wrong_solver_fails(fault: Fault, tmp_path: Path) -> None:
    family = fault.kills[0].trial.family
    with planted(selftest.Fault(family, "named", fault.name, fault.edits), SOURCES, tmp_path) as package:
        for k, kill in enumerate(fault.kills):
            findings = verification(kill.trial.with_solver(copied(package, kill.trial.solver)), tmp_path / str(k))
            assert_killed(findings, kill.verdict, kill.criterion)
            if fault.keeps_orders:
                orders = [finding for finding in findings if finding.criterion.startswith("order of")]
                assert {finding.verdict for finding in orders} <= {Verdict.PASS}, "\n".join(map(str, orders))


@pytest.mark.parametrize("family", LOOPS)
def test_an_unmodified_copy_passes_and_is_compiled_from_its_own_files(family: str, tmp_path: Path) -> None:
    with planted(selftest.Fault(family, "named", "none", ()), SOURCES, tmp_path) as package:
        for k, trial in enumerate(trial for trial in TRIALS if trial.family == family):
            copy = copied(package, trial.solver)
            assert type(copy) is not type(trial.solver)
            assert copy.name == trial.solver.name
            findings = verification(trial.with_solver(copy), tmp_path / str(k))
            assert findings
            assert {finding.verdict for finding in findings} == {Verdict.PASS}, "\n".join(map(str, findings))
        module, loop = LOOPS[family]
        compiled: Any = getattr(importlib.import_module(f"{package}.{family}.{module}"), loop)
        if family == "mpm":
            assert (compiled.made > 0, compiled.from_disk) == (True, 0)
            assert list((tmp_path / package / family / "__pycache__").glob("march-*.code"))
        else:
            assert tmp_path in Path(compiled.stats.cache_path).parents
            assert compiled.stats.cache_misses
            assert not compiled.stats.cache_hits
    assert not any(name.startswith(package) for name in sys.modules)


def test_every_fault_of_a_solver_has_its_own_name() -> None:
    assert len({fault.id for fault in FAULTS}) == len(FAULTS)


# Faults of the comparison with the exact solution; the shipped solvers are unmodified.

NORM_FAULTS = {
    "exact-solution-one-step-late": (
        Edit(
            "",
            "closed_form(solution.reference, solution.time[some])",
            "closed_form(solution.reference, solution.time[some] - solution.dt)",
        ),
        TG_VIBRATION,
        "order of stress",
    ),
    "exact-solution-one-step-early": (
        Edit(
            "",
            "closed_form(solution.reference, solution.time[some])",
            "closed_form(solution.reference, solution.time[some] + solution.dt)",
        ),
        MPM_VIBRATION,
        "order of displacement",
    ),
    "weight-squared-in-L2": (
        Edit("", "np.sum(weight * size**2", "np.sum(weight**2 * size**2"),
        Trial("manufactured-1d", "published", MaterialPoint("MUSL", formulation="total", body_force_at="nodes")),
        "published displacement errors",
    ),
}


@pytest.mark.parametrize(("edit", "trial", "criterion"), NORM_FAULTS.values(), ids=NORM_FAULTS)
def test_a_wrong_comparison_fails(
    edit: Edit,
    trial: Trial,
    criterion: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    name = f"norms_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(edit.applied(Path(norms.__file__).read_text(encoding="utf-8")), encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.invalidate_caches()
    monkeypatch.setattr(evaluation, "compare", importlib.import_module(name).compare)
    findings = verification(trial.with_solver(trial.solver), tmp_path)
    assert_killed(findings, FAIL, criterion)


@dataclasses.dataclass(frozen=True)
class Late:
    """A closed form that is delayed by `delay` [s]."""

    field: Callable[..., Any]
    delay: float

    def __call__(self, X: Any, t: Any) -> Any:
        return self.field(X, t - self.delay)


@pytest.mark.parametrize("trial", [TG_PULSE, MPM_PULSE, FEM_PULSE, FEM_NEO_HOOKEAN], ids=lambda t: f"{t.family}-{t.study}")
def test_a_closed_form_delayed_by_the_finest_time_step_fails(trial: Trial, tmp_path: Path) -> None:
    study = trial.with_solver(trial.solver)
    (case,) = study.cases
    (series,) = case.series
    _, delay = series.refinement.tier("quick")[-1].time_steps(case.problem.problem)
    fields = {quantity: Late(field, delay) for quantity, field in case.problem.exact.fields.items()}
    problem = dataclasses.replace(case.problem, exact=dataclasses.replace(case.problem.exact, fields=fields))
    study = dataclasses.replace(study, cases=(dataclasses.replace(case, problem=problem),))
    assert_killed(verification(study, tmp_path), FAIL, "order of")

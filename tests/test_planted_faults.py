"""A wrong solver fails: a fault planted in a copy of a shipped solver turns a verdict of a study to FAIL or ERROR.

The named faults of the self-test are in `sweeps/test_named_faults.py`.

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
from planted import (
    ERROR,
    FAIL,
    FEM_DISPERSION,
    FEM_NEO_HOOKEAN,
    FEM_NEWMARK_PULSE,
    FEM_PULSE,
    MPM_DISPERSION,
    MPM_PULSE,
    MPM_VIBRATION,
    SOURCES,
    TG_BEYOND,
    TG_CONSISTENT_VIBRATION,
    TG_DISPERSION,
    TG_GAUSSIAN,
    TG_LUMPED_GAUSSIAN,
    TG_PULSE,
    TG_STEP,
    TG_VIBRATION,
    TRIALS,
    Kill,
    Trial,
    assert_killed,
    verification,
)

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import norms
from mpmverify.execution import evaluation
from mpmverify.selftest import faults as selftest
from mpmverify.selftest.faults import Edit
from mpmverify.selftest.planting import copied, planted
from mpmverify.solvers.mpm import MaterialPoint

LOOPS = {"mpm": ("loop", "march"), "fem": ("kernel", "advance"), "taylor_galerkin": ("kernel", "march")}
"""Module and name of each family's compiled time loop."""


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


MPM_LAW, MPM_DEFORMATION = "mpm/small_strain.py", "mpm/deformation.py"
MPM_HOOKE = "return shifted(lame * trace(eps), 2 * shear, eps)"
MPM_STORED = "F, sigma = strain_and_stress(particles, some.numbers, zero)\n    J"
MPM_NEIGHBOURS = "tuple(q - where(q > 0, 1, 0) for q in some.numbers)"
TG_LOOP, TG_SOLVER = "taylor_galerkin/kernel.py", "taylor_galerkin/solver.py"
FEM_SOLVER = "fem/solver.py"

FAULTS = (
    Fault(
        "contour-normal-flipped",
        (Edit(TG_LOOP, "contour = normal * dot(A[k], trace)", "contour = -normal * dot(A[k], trace)"),),
        (Kill(TG_PULSE, ERROR, "order of velocity"),),
    ),
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

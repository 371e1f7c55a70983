"""Trials of planted faults: the series of one solver in one case of a study, and the criterion that must see the fault."""

import dataclasses
from pathlib import Path

import mpmverify.solvers
from mpmverify import studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.dataset.files import Results
from mpmverify.execution.runner import Plan, run
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Study

SOURCES = Path(mpmverify.solvers.__file__).parent
FAMILIES: dict[type, str] = {MaterialPoint: "mpm", FiniteElement: "fem", TaylorGalerkin: "taylor_galerkin"}
"""Folder of each solver class."""


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


FAIL, ERROR = Verdict.FAIL, Verdict.ERROR
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
TRIALS = tuple(value for value in list(vars().values()) if isinstance(value, Trial))


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

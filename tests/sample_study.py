"""A study of stand-in solvers, whose texts would break a page that does not escape them, stored as a run stores it."""

import dataclasses
import math
from pathlib import Path

import numpy as np

from mpmverify.criteria import Balance, Order
from mpmverify.criteria.evidence import Evidence, Level, SeriesId, evidence_by_series
from mpmverify.dataset.files import Results
from mpmverify.dataset.selftest import write_selftest
from mpmverify.dataset.snapshots import Snapshots
from mpmverify.dataset.study import write_study
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.judging import judge
from mpmverify.judgement.kill_table import Fate, PlantedFault, Rate, Rates, SelfTest, UnmodifiedRun
from mpmverify.problem import Discretisation, Periodic, Problem, Transport
from mpmverify.reports import render
from mpmverify.study import Case, Refinement, Series, Study

HOSTILE = "<script>alert('x')</script> \"quoted\" & 'single'"
SIZES = (1 / 16, 1 / 32, 1 / 64, 1 / 128)


@dataclasses.dataclass(frozen=True)
class Scheme:
    """Stand-in for a solver: the report uses only its name, choices and orders."""

    name: str
    text: str = HOSTILE

    @property
    def orders(self) -> dict[str, float]:
        return {"u": 2.0}


def study(name: str = "sample", solvers: tuple[str, ...] = ("good", "bad", "crashed")) -> Study:
    faces = {"x-": Periodic(), "x+": Periodic()}
    problem = Problem("hill", (0.0,), (1.0,), Transport(1.0), faces, end_time=1.0)
    exact = ExactSolution({}, f"Someone (1999) {HOSTILE}, doi:10.1000/some.thing_1")
    hill = VerificationProblem(
        problem, exact, f"Phase errors. {HOSTILE}", (r"u_t + a u_x = 0", rf"\text{{{HOSTILE}}}", r"\frac{")
    )
    ladder = Refinement(f"nu_C=0.5 {HOSTILE}", tuple(Discretisation(h, 0.5) for h in SIZES), quick=4)
    criteria = (Order("u", "L2", 1.8, 2.2, f"theory, {HOSTILE}"), Balance("mass", "inflow", "conservation form"))
    series = tuple(Series(Scheme(solver), ladder, criteria) for solver in solvers)
    return Study(name, f"Sample {HOSTILE}", f"A summary. {HOSTILE}", (Case("hill & dale", hill, series, "u"),))


def level(case: str, solver: str, label: str, h: float) -> Level:
    identity = (case, solver, label, h, 0.5, 1, f"{solver}-{round(1 / h)}")
    if solver == "crashed":
        return Level(*identity, outcome=f"crashed; {HOSTILE}")
    error = (math.nan if h < 1 / 100 else h) if solver == "bad" else h**2
    norms = np.full(4, error), np.ones(4)
    mode = {"phase_angle_u": 2 * h, "relative_frequency_u": 1 - error, "theoretical_frequency_u": 1 - h**2}
    metrics = {"mass_defect": 1e-16} | (mode if solver == "good" else {})
    return Level(*identity, dt=h / 2, steps=9, point_steps=99, seconds=0.1, errors={"u": norms}, metrics=metrics)


def shot(case: str, solver: str, label: str) -> Snapshots:
    time, points = np.linspace(0, 1, 40), np.linspace(0, 1, 300)
    exact = np.sin(2 * np.pi * (points - time[:, None]))
    fields = exact + (1e-9 if solver == "good" else np.where(time[:, None] > 0.5, np.nan, 0.1))
    histories = {"time": time, "mass": 1 + 1e-16 * time, "momentum": time, "impulse": time}
    histories |= {"kinetic_energy": 1 - time, "strain_energy": time, "external_work": 0 * time}
    return Snapshots(case, label, 1 / 64, time, points[:, None], {"u": fields[..., None]}, {"u": exact[..., None]}, histories)


EVIDENCE = Evidence(
    *(np.array([value]) for value in (0.5, 0.25, 0.5, 1)), ("completed",), {"u": np.ones((1, 4))}, {"u": np.ones((1, 4))}
)
NONE = Baseline(Path("none"))


def store(results: Results, declared: Study, known: Baseline = NONE, run: str = "") -> list:
    """Write a study file as a run does, and return the findings."""
    table, shots = [], {}
    for case, series in declared.series():
        where = SeriesId(case.name, series.solver.name, series.refinement.label)
        table += [level(*where, h) for h in SIZES]
        if series.solver.name != "crashed":
            shots[where] = shot(*where)
    evidence = evidence_by_series(table)
    judged = judge(declared.name, declared.criteria(), evidence, known, declared.restricted_to)
    results.create()
    write_study(results.study(declared.name), declared, table, shots, judged, tier="quick", inputs="inputs", run=run)
    return list(judged.findings)


FAULTS = tuple(
    PlantedFault(
        f"mpm/{rule}/{k}",
        "mpm",
        rule,
        f"fault {k} {HOSTILE}",
        "mpm/constitution.py",
        k,
        f"before {k} {HOSTILE}",
        f"after {k}",
        fate,
        reason=f"reason {k} {HOSTILE}",
    )
    for k, (rule, fate) in enumerate((rule, fate) for rule in ("named", "term") for fate in Fate)
)
RATE = Rate(f"kind {HOSTILE}", "inside", 200, 150, 49, 0, 1)
ALARM = UnmodifiedRun(2, 4, 1e-4, 7, "FAIL", 63, f"alarm {HOSTILE}")
SELF_TEST = SelfTest("full", 999, FAULTS, (ALARM,), Rates((RATE,), (RATE, dataclasses.replace(RATE, series=0)), ()))


def rendered(folder: Path) -> tuple[Results, list]:
    """Two studies, one existing run and a self-test, with their report; and the findings."""
    results = Results(folder)
    table = store(results, study()) + store(results, study("second", ("good",)))
    results.run("good-64").write_bytes(b"")
    write_selftest(results.selftest, SELF_TEST)
    render(results)
    return results, table


def one_solver(folder: Path) -> Results:
    """A study of one solver, without a report."""
    results = Results(folder)
    store(results, study(solvers=("good",)))
    return results

"""Fast solvers with a prescribed behaviour. Worker processes unpickle them by name, so they are in a module of their own."""

import os
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mpmverify.criteria import Balance, Order
from mpmverify.criteria.criterion import Criterion
from mpmverify.dataset.files import Results
from mpmverify.exact.advection import Gaussian, advection
from mpmverify.execution.runner import Plan
from mpmverify.judgement.baseline import Baseline
from mpmverify.problem import Array, Discretisation, Problem
from mpmverify.solution import Outcome, Solution, Status, Work
from mpmverify.study import Case, Refinement, Series, Study, halving

HILL = Gaussian(width=0.2)
"""Sums over eight cells or more integrate it to round-off, so its norms are the same on every level."""
SECOND_ORDER = (Order("u", "L2", 1.9, 2.1, "made so"), Balance("mass", "", "made so"))


@dataclass(frozen=True)
class Scripted:
    """Transports the initial profile exactly and adds an error of h^order.

    Parameters
    ----------
    behaviour : str
        Key of `BEHAVIOURS`, applied on the levels with h <= `below`.
    order : float
        Order of the error.
    below : float
        Largest h with that behaviour [m].
    journal : str
        File to which every run appends one line; "" for none.
    """

    behaviour: str = "good"
    order: float = 2.0
    below: float = 1.0
    journal: str = ""

    @property
    def name(self) -> str:
        return f"scripted-{self.behaviour}"

    @property
    def orders(self) -> Mapping[str, float]:
        return {"u": self.order}

    @property
    def conserves(self) -> frozenset[str]:
        return frozenset({"mass"})

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        if self.journal:
            with Path(self.journal).open("a") as journal:
                journal.write(f"{self.name} {discretisation.h:g}\n")
        good = transported(problem, discretisation, discretisation.h**self.order)
        return good if discretisation.h > self.below else BEHAVIOURS[self.behaviour](good)


def transported(problem: Problem, discretisation: Discretisation, error: float) -> Solution:
    """Return periodic advection sampled at the cell centres, plus a constant error."""
    (cells,), (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
    h, time = discretisation.h, np.linspace(0, problem.end_time, 5)
    centres = (np.arange(cells)[:, None] + 0.5) * h
    # These solvers run on advection problems only, whose material has a velocity.
    carried = [problem.initial_field("u", centres - problem.material.velocity * t) for t in time]
    return Solution(
        time=time,
        dt=dt,
        reference=centres,
        position=np.repeat(centres[None], len(time), axis=0),
        weight=np.full((len(time), cells), h),
        fields={"u": np.array(carried) + error},
        histories={"time": np.linspace(0, problem.end_time, steps + 1), "mass": np.ones(steps + 1)},
        work=Work(steps, steps * cells, 0.25),
    )


def _with_u(solution: Solution, values: Array) -> Solution:
    return replace(solution, fields={"u": values})


def _with_history(solution: Solution, name: str, values: Array) -> Solution:
    return replace(solution, histories=dict(solution.histories) | {name: values})


def _hang(_: Solution) -> Solution:
    time.sleep(600)
    raise AssertionError("the time limit did not end this run")


def _raise(_: Solution) -> Solution:
    raise ZeroDivisionError("a mass of [/zero]\nat node 3 \0\x1b \udc80")


def _solve_singular(solution: Solution) -> Solution:
    np.linalg.inv(np.zeros((2, 2)))
    return solution


def _delay(solution: Solution) -> Solution:
    time.sleep(0.3)
    return solution


BEHAVIOURS: Mapping[str, Any] = {
    "good": lambda s: s,
    "raises": _raise,
    "leaves": lambda s: sys.exit(7),
    "dies": lambda s: os._exit(3),
    "hangs": _hang,
    "dawdles": _delay,
    "returns-nothing": lambda s: None,
    "nan": lambda s: _with_u(s, np.where(s.time[:, None, None] > 0, np.nan, s.fields["u"])),
    "nan-weight": lambda s: replace(s, weight=s.weight * np.nan),
    "nan-history": lambda s: replace(s, histories=dict(s.histories) | {"mass": s.histories["mass"] * np.nan}),
    "unstable": lambda s: replace(s, outcome=Outcome(Status.UNSTABLE, "at step 3")),
    "unstable-at-once": lambda s: replace(
        s, time=s.time[:1], position=s.position[:1], weight=s.weight[:1], fields={"u": s.fields["u"][:1]},
        histories={name: values[:1] for name, values in s.histories.items()}, outcome=Outcome(Status.UNSTABLE, "at step 0"),
    ),
    "flat-fields": lambda s: _with_u(s, s.fields["u"][:, :, 0]),
    "too-few-points": lambda s: _with_u(s, s.fields["u"][:, 1:]),
    "scalar-weight": lambda s: replace(s, weight=np.array(0.1)),
    "ragged-histories": lambda s: replace(s, histories=dict(s.histories) | {"mass": np.ones(2)}),
    "no-history": lambda s: replace(s, histories={name: values[:0] for name, values in s.histories.items()}),
    "scalar-histories": lambda s: replace(s, histories={"time": np.array(1.0)}),
    "no-time": lambda s: replace(s, histories={"mass": s.histories["mass"]}),
    "no-output": lambda s: replace(s, time=s.time[:0], position=s.position[:0], weight=s.weight[:0], fields={}),
    "unknown-field": lambda s: replace(s, fields=dict(s.fields) | {"temperature": s.fields["u"]}),
    "unknown-history": lambda s: replace(s, histories=dict(s.histories) | {"entropy": s.histories["mass"]}),
    "stops-early": lambda s: replace(
        s, time=s.time[:-1], position=s.position[:-1], weight=s.weight[:-1], fields={"u": s.fields["u"][:-1]}
    ),
    "text-fields": lambda s: _with_u(s, np.full(s.fields["u"].shape, "one")),
    "complex-fields": lambda s: _with_u(s, s.fields["u"] + 0j),
    "masked-fields": lambda s: _with_u(s, np.ma.masked_less(s.fields["u"], 0.5)),
    "masked-weight": lambda s: replace(s, weight=np.ma.masked_less(s.weight, 0.0)),
    "listed-fields": lambda s: _with_u(s, s.fields["u"].tolist()),
    "tuple-of-fields": lambda s: replace(s, fields=(s.fields["u"],)),
    "no-work": lambda s: replace(s, work=None),
    "plane-points": lambda s: replace(s, reference=np.hstack([s.reference] * 2), position=np.dstack([s.position] * 2)),
    "no-step": lambda s: replace(s, dt=0.0),
    "nan-step": lambda s: replace(s, dt=np.nan),
    "text-step": lambda s: replace(s, dt="short"),
    "long-step": lambda s: replace(s, dt=s.dt * 1.001),
    "nan-work": lambda s: replace(s, work=replace(s.work, seconds=np.nan)),
    "negative-work": lambda s: replace(s, work=replace(s.work, steps=-1)),
    "late-outputs": lambda s: replace(s, time=s.time + 0.1 * (1 - s.time)),
    "repeated-outputs": lambda s: replace(s, time=s.time[[0, 1, 1, 3, 4]]),
    "late-histories": lambda s: _with_history(s, "time", 0.1 + 0.9 * s.histories["time"]),
    "falling-histories": lambda s: _with_history(s, "time", s.histories["time"] * (3 - 2 * s.histories["time"] ** 4)),
    "short-histories": lambda s: _with_history(s, "time", s.histories["time"] * (1 - 1e-8)),
    "negative-weight": lambda s: replace(s, weight=s.weight * np.where(np.arange(len(s.reference)) % 2, 3.0, -1.0)),
    "half-weight": lambda s: replace(s, weight=s.weight / 2),
    "singular": _solve_singular,
}  # fmt: skip
"""Change of a correct solution, by behaviour."""


@dataclass(frozen=True)
class Unreadable(Scripted):
    """Solver that a worker process cannot unpickle."""

    def __reduce__(self) -> Any:
        return _refuse, ()


def _refuse() -> None:
    raise ModuleNotFoundError("no module named 'nowhere'")


def ladder(levels: int = 3) -> Refinement:
    return halving(1.0, 8, quick=levels, full=levels + 1, courant=0.5)


def study(*solvers: Scripted, name: str = "scripted", levels: int = 3, criteria: tuple[Criterion, ...] = SECOND_ORDER) -> Study:
    """Return a study of scripted solvers on one ladder of the Gaussian hill."""
    series = tuple(Series(solver, ladder(levels), criteria) for solver in solvers or (Scripted(),))
    return Study(name, "Scripted", "Solvers with a prescribed behaviour.", (Case("hill", advection(HILL), series, "u"),))


def plan(path: Path, **choices: Any) -> Plan:
    """Return a plan that solves in this process, without a baseline."""
    return Plan(**({"results": Results(path), "baseline": Baseline(path / "none.json"), "jobs": 0} | choices))

"""Solvers in one to three dimensions that sample the exact solution, add a second-order error, and have a prescribed fault."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from mpmverify.exact import VerificationProblem
from mpmverify.problem import Array, Discretisation, LinearElastic, Problem, components
from mpmverify.solution import Solution, Work


@dataclass(frozen=True)
class Sampled:
    """Samples the exact solution at the cell centres, and adds h^2 times the size of each field to every component.

    Parameters
    ----------
    answer : VerificationProblem
    behaviour : str
        Key of `BEHAVIOURS`.
    """

    answer: VerificationProblem
    behaviour: str = "good"

    @property
    def name(self) -> str:
        return f"sampled-{self.behaviour}"

    @property
    def orders(self) -> Mapping[str, float]:
        return {"displacement": 2.0, "velocity": 2.0, "stress": 2.0}

    @property
    def conserves(self) -> frozenset[str]:
        return frozenset({"mass", "momentum"})

    def size(self, quantity: str) -> float:
        """Return the largest magnitude of an exact field, estimated from the same points on every level."""
        problem = self.answer.problem
        X = np.random.default_rng(0).uniform(problem.lower, problem.upper, (400, problem.dimension))
        X = X if problem.shape is None else X[problem.shape.contains(X)]
        return float(np.abs(self.answer.exact.fields[quantity](X, np.linspace(0, problem.end_time, 9))).max())

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        assert isinstance(problem.material, LinearElastic)
        counts, (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
        h, time = discretisation.h, np.linspace(0, problem.end_time, 9)
        axes = [lower + h * (np.arange(count) + 0.5) for lower, count in zip(problem.lower, counts, strict=True)]
        X = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, problem.dimension)
        if problem.shape is not None:
            X = X[problem.shape.contains(X)]
        exact = {quantity: field(X, time) for quantity, field in self.answer.exact.fields.items()}
        fields = {quantity: values + h**2 * self.size(quantity) for quantity, values in exact.items()}
        instants = np.linspace(0, problem.end_time, steps + 1)
        histories = {"time": instants, "mass": np.full(steps + 1, problem.material.density * problem.measure)}
        moved = problem.material.density * problem.measure * fields["velocity"].mean(axis=1)
        names = components("momentum", problem.dimension)
        histories |= {name: np.interp(instants, time, moved[:, k]) for k, name in enumerate(names)}
        for stock, source in zip(*(components(of, problem.dimension) for of in ("momentum", "impulse")), strict=True):
            histories[source] = histories[stock] - histories[stock][0]
        energy = {"kinetic_energy": np.ones(steps + 1), "strain_energy": instants, "external_work": instants}
        good = Solution(
            time=time,
            dt=dt,
            reference=X,
            position=X + fields["displacement"],
            weight=np.full((len(time), len(X)), problem.measure / len(X)),
            fields=fields,
            histories=histories | energy,
            work=Work(steps, steps * len(X), 0.25),
        )
        return BEHAVIOURS[self.behaviour](good)


def _with_field(solution: Solution, quantity: str, values: Array) -> Solution:
    return replace(solution, fields=dict(solution.fields) | {quantity: values})


def _with_histories(solution: Solution, drop: str = "", **values: Array) -> Solution:
    table = {name: history for name, history in solution.histories.items() if name != drop}
    return replace(solution, histories=table | values)


BEHAVIOURS: Mapping[str, Any] = {
    "good": lambda s: s,
    "stress-out-of-order": lambda s: _with_field(s, "stress", s.fields["stress"][..., ::-1]),
    "stress-of-nine": lambda s: _with_field(s, "stress", np.repeat(s.fields["stress"], 3, axis=2)),
    "flat-velocity": lambda s: _with_field(s, "velocity", s.fields["velocity"][..., :1]),
    "turned-displacement": lambda s: _with_field(s, "displacement", s.fields["displacement"][..., ::-1]),
    "shear-error": lambda s: _with_field(
        s, "stress", s.fields["stress"] + np.array([0.0, 0.0, 1.0]) * np.abs(s.fields["stress"]).max()
    ),
    "momentum-without-axis": lambda s: _with_histories(s, momentum=s.histories["momentum_x"]),
    "lacks-momentum-y": lambda s: _with_histories(s, drop="momentum_y"),
    "lacks-impulse-y": lambda s: _with_histories(s, drop="impulse_y"),
    "loses-momentum-y": lambda s: _with_histories(s, momentum_y=s.histories["momentum_y"] + 1e-9 * s.histories["time"]),
    "mass-of-the-box": lambda s: _with_histories(s, mass=s.histories["mass"] * 2.0),
    "weight-of-the-box": lambda s: replace(s, weight=s.weight * 2.0),
    "flat-points": lambda s: replace(s, reference=s.reference[:, :1], position=s.position[..., :1]),
}
"""Change of a correct solution, by behaviour."""


@dataclass(frozen=True)
class Everywhere:
    """Solver for several problems of one to three dimensions: `Sampled` with the exact solution of the problem it is given."""

    answers: tuple[VerificationProblem, ...]

    name: ClassVar[str] = "everywhere"
    orders: ClassVar[Mapping[str, float]] = {"displacement": 2.0}
    conserves: ClassVar[frozenset[str]] = frozenset({"mass", "momentum"})

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        (answer,) = (answer for answer in self.answers if answer.problem.name == problem.name)
        return Sampled(answer).solve(problem, discretisation)

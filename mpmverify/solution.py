"""What a solver returns: sample points, fields, histories, work and outcome; and the protocol that a solver keeps."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np

from mpmverify.problem import UNITS, Array, Discretisation, Problem


class Status(StrEnum):
    """How a run ended."""

    COMPLETED = "completed"
    UNSTABLE = "unstable"
    NON_FINITE = "non-finite"
    LEFT_GRID = "left the grid"
    TIMED_OUT = "timed out"
    CRASHED = "crashed"


ADVICE: Mapping[Status, str] = {
    Status.COMPLETED: "",
    Status.UNSTABLE: "the kinetic energy grew without bound: lower the Courant number",
    Status.NON_FINITE: "a field became NaN or infinite: lower the Courant number, or look for a division by a zero mass or volume",
    Status.LEFT_GRID: "a particle left the background grid: enlarge the domain or lower the load",
    Status.TIMED_OUT: "the run exceeded its time limit: raise --timeout or coarsen the level",
    Status.CRASHED: "the solver raised an exception or its process died: run it alone with --jobs 1 --solver NAME",
}


@dataclass(frozen=True)
class Outcome:
    """How a run ended, as a value with advice.

    Parameters
    ----------
    status : Status
    detail : str
        What happened in this run: the step, the exception.
    """

    status: Status = Status.COMPLETED
    detail: str = ""

    @property
    def completed(self) -> bool:
        return self.status is Status.COMPLETED

    def __str__(self) -> str:
        parts = [self.status.value, self.detail, ADVICE[self.status]]
        return "; ".join(part for part in parts if part)


@dataclass(frozen=True)
class Work:
    """Cost of a run: steps, point-steps (particles or elements times steps) and seconds without compilation."""

    steps: int = 0
    point_steps: int = 0
    seconds: float = 0.0


@dataclass(frozen=True)
class Solution:
    """Result of one run; T output times, P sample points, N steps.

    Parameters
    ----------
    time : Array
        Output times (T,) [s].
    dt : float
        Time step [s].
    reference : Array
        Reference positions of the sample points (P, dim) [m].
    position : Array
        Current positions (T, P, dim) [m].
    weight : Array
        Quadrature weights (T, P) [m^dim]: each row sums to the measure of the body.
    fields : mapping of str to Array
        (T, P, components) by quantity, all synchronous with `time`.
    histories : mapping of str to Array
        (N + 1,) by name, "time" [s] among them: mass, momentum, impulse, kinetic_energy, strain_energy, external_work,
        per unit cross-section.
    work : Work
    outcome : Outcome
    """

    time: Array
    dt: float
    reference: Array
    position: Array
    weight: Array
    fields: Mapping[str, Array]
    histories: Mapping[str, Array]
    work: Work
    outcome: Outcome = Outcome()

    def arrays(self) -> dict[str, Array]:
        """All arrays by name, fields and histories among them."""
        sampled = {"time": self.time, "reference": self.reference, "position": self.position, "weight": self.weight}
        return sampled | dict(self.fields) | {f"history of {name}": values for name, values in self.histories.items()}

    def inconsistency(self) -> str:
        """Say what contradicts the shapes above; "" when nothing does."""
        unknown = sorted(self.fields.keys() - UNITS.keys())
        if unknown:
            return f"the field {unknown[0]!r} is unknown: known are {', '.join(UNITS)}"
        if "time" not in self.histories:
            return "the histories lack their time"
        shapes = {name: np.shape(values) for name, values in self.arrays().items()}
        if len(shapes["time"]) != 1 or len(shapes["reference"]) != 2 or 0 in shapes["time"] + shapes["reference"]:
            return (
                f"time {shapes['time']} must be (T,) and reference {shapes['reference']} must be (P, dim), none of them empty"
            )
        (outputs,), (points, dimension) = shapes["time"], shapes["reference"]
        expected = {"position": (outputs, points, dimension), "weight": (outputs, points)}
        expected |= {name: (outputs, points, *shapes[name][2:3]) for name in self.fields}
        expected |= {f"history of {name}": shapes["history of time"][:1] for name in self.histories}
        for name, shape in expected.items():
            if shapes[name] != shape or (name in self.fields and len(shape) < 3):
                return f"{name} has the shape {shapes[name]} beside {outputs} output times and {points} points"
        return ""


class Solver(Protocol):
    """A scheme as a frozen value: its fields are the scheme's choices."""

    @property
    def name(self) -> str:
        """Unique name made of the scheme's choices, usable as a netCDF group and a file name."""

    @property
    def orders(self) -> Mapping[str, float]:
        """Formal order in h of the L2 error by quantity, on smooth data and with dt proportional to h."""

    @property
    def conserves(self) -> frozenset[str]:
        """Invariants kept to round-off: of "mass", "momentum"."""

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve; numerical failure is an `Outcome`, misuse raises `UsageError`."""

"""The protocol of a solver, and the solution that it returns: sample points, fields, histories, work and outcome."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Protocol

import numpy as np

from mpmverify.problem import Array, Discretisation, Problem
from mpmverify.problem.quantities import UNITS, components


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
    Status.UNSTABLE: "the solution grew without bound: lower the Courant number",
    Status.NON_FINITE: "a field became NaN or infinite: lower the Courant number, or look for a division by a zero mass or volume",
    Status.LEFT_GRID: "a particle left the background grid: enlarge the domain or lower the load, unless a face or an unstable run drives it out",
    Status.TIMED_OUT: "the run exceeded its time limit: raise the limit or coarsen the level",
    Status.CRASHED: "the solver raised an exception, returned no valid solution or its process died: run it alone",
}


@dataclass(frozen=True)
class Outcome:
    """How a run ended; as text, the status, its detail and advice.

    Parameters
    ----------
    status : Status
    detail : str
        What happened in this run, for example the step or the exception.
    advice : str
        What helps in this run, where the solver knows the cause; by default that of the status, see `ADVICE`.
    """

    status: Status = Status.COMPLETED
    detail: str = ""
    advice: str = ""

    @property
    def completed(self) -> bool:
        return self.status is Status.COMPLETED

    def __str__(self) -> str:
        parts = [self.status.value, self.detail, self.advice or ADVICE[self.status]]
        return "; ".join(part for part in parts if part)


class RunError(Exception):
    """A run that failed without a solution: raised by `Solver.solve`, its outcome becomes that of the run.

    Parameters
    ----------
    status : Status
    detail, advice : str
        See `Outcome`.
    """

    def __init__(self, status: Status, detail: str, advice: str = "") -> None:
        super().__init__(status, detail, advice)
        self.outcome = Outcome(status, detail, advice)

    def __str__(self) -> str:
        return self.outcome.detail


@dataclass(frozen=True)
class Work:
    """Cost of a run: steps, point-steps (particles or elements times steps) and wall time without compilation [s]."""

    steps: int = 0
    point_steps: int = 0
    seconds: float = 0.0


@dataclass(frozen=True)
class Solution:
    """Result of one run, with T output times, P sample points and N steps.

    All arrays are plain `numpy.ndarray` of real numbers. A completed run that violates this specification counts as crashed; one with
    a value that is not finite counts as non-finite. A run that ended early returns the outputs that it reached.

    Parameters
    ----------
    time : Array
        Output times (T,) [s], strictly increasing from 0 to the final time of the problem; at least five, or every step.
    dt : float
        Time step [s], the largest one if it varies; at most nu_C h/c.
    reference : Array
        Reference positions of the sample points (P, dim) [m].
    position : Array
        Current positions (T, P, dim) [m].
    weight : Array
        Quadrature weights (T, P) [m^dim], not negative. The first row sums to the measure of the body; later rows may repeat it or
        hold the current volumes V0 J.
    fields : mapping of str to Array
        Fields (T, P, components) by quantity, all at the times of `time`:

        - "u", the transported scalar [1];
        - "displacement" [m], current minus reference position, and "velocity" [m/s], each with `dim` components;
        - "stress" [Pa], the Cauchy stress at the material point, positive in tension: xx, yy, xy in two dimensions, without the
          out-of-plane component of plane strain, and xx, yy, zz, xy, yz, zx in three;
        - "displacement_gradient" [1], du_i/dX_j = F - I, row by row.
    histories : mapping of str to Array
        Histories (N + 1,) by name, at the start and after every step. "time" [s], from 0 to the final time, is required; the
        others are listed in the notes. A criterion that needs a missing history cannot pass.
    work : Work
    outcome : Outcome

    Notes
    -----
    The histories of a body are the discrete sums of the scheme itself. They are per unit cross-section in one dimension (with the
    units below), per unit thickness in two, and for the whole body in three. In two and three dimensions a vector has one history
    for each component: "momentum_x", "momentum_y" and so on.

    - "mass" [kg/m^2] and "momentum" [kg/(m s)]: sums over all nodes or particles;
    - "impulse" [kg/(m s)]: time integral from 0, by the quadrature of the scheme, of all external forces: tractions, reactions at
      faces with prescribed velocity, and the body force;
    - "kinetic_energy" and "strain_energy" [J/m^2];
    - "external_work" [J/m^2]: work of the same forces from 0, by the same quadrature, including the reactions at moved faces;
    - "dissipated_energy" [J/m^2]: energy dissipated by the material since 0; taken as zero if it is missing;
    - "angular_momentum" about the origin: a scalar [kg m/s] in two dimensions, a vector [kg m^2/s] in three.

    The histories of a transported scalar are "mass" [m], the integral of u over the box, and "inflow" [m], the time integral from 0
    of the flux in minus the flux out through open ends. A solver that declares that it conserves "mass" returns "mass", and "inflow"
    if ends are open; one that declares "momentum" returns "momentum" and "impulse"; one
    that declares "energy" returns "kinetic_energy", "strain_energy" and "external_work".
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

    def excerpt(self, outputs: Array, samples: Array | None, stride: int = 1) -> "Solution":
        """Return the solution at some outputs and samples of its histories, given by their indices, and at every `stride`-th point.

        Without `samples` it has no histories.
        """
        return replace(
            self,
            time=self.time[outputs],
            reference=self.reference[::stride],
            position=self.position[outputs, ::stride],
            weight=self.weight[outputs, ::stride],
            fields={quantity: values[outputs, ::stride] for quantity, values in self.fields.items()},
            histories={} if samples is None else {name: values[samples] for name, values in self.histories.items()},
        )

    def arrays(self) -> dict[str, Array]:
        """Return all arrays by name, including fields and histories."""
        sampled = {"time": self.time, "reference": self.reference, "position": self.position, "weight": self.weight}
        return sampled | dict(self.fields) | {f"history of {name}": values for name, values in self.histories.items()}

    def inconsistency(self) -> str:
        """Return a sentence on the first type or shape that violates the specification above; "" if there is none."""
        parts = {"fields": Mapping, "histories": Mapping, "work": Work, "outcome": Outcome}
        for part, kind in parts.items():
            if not isinstance(getattr(self, part), kind):
                return f"{part} is of type {type(getattr(self, part)).__name__} instead of {kind.__name__}"
        unknown = sorted(self.fields.keys() - UNITS.keys())
        if unknown:
            return f"the field {unknown[0]!r} is unknown: known are {', '.join(UNITS)}"
        if "time" not in self.histories:
            return "the histories lack their time"
        for name, values in self.arrays().items():
            if type(values) is not np.ndarray:  # subclasses such as masked arrays and matrices have other arithmetic
                return f"{name} is of type {type(values).__name__} instead of numpy.ndarray"
            if values.dtype.kind not in "fiu":
                return f"{name} has the type {values.dtype}, and must hold real numbers"
        shapes = {name: np.shape(values) for name, values in self.arrays().items()}
        if len(shapes["time"]) != 1 or len(shapes["reference"]) != 2 or 0 in shapes["time"] + shapes["reference"]:
            return (
                f"time {shapes['time']} must be (T,) and reference {shapes['reference']} must be (P, dim), none of them empty"
            )
        if len(shapes["history of time"]) != 1 or 0 in shapes["history of time"]:
            return f"the histories' time has the shape {shapes['history of time']}, which must be (N + 1,) and not empty"
        (outputs,), (points, dimension) = shapes["time"], shapes["reference"]
        expected = {"position": (outputs, points, dimension), "weight": (outputs, points)}
        expected |= {name: (outputs, points, *shapes[name][2:3]) for name in self.fields}
        expected |= {f"history of {name}": shapes["history of time"] for name in self.histories}
        for name, shape in expected.items():
            if shapes[name] != shape or (name in self.fields and len(shape) < 3):
                if name in self.fields:
                    shape = (outputs, points, len(components(name, dimension)) if 1 <= dimension <= 3 else 0)
                return f"{name} has the shape {shapes[name]}, expected {shape} of {outputs} output times and {points} points"
        return ""


class Solver(Protocol):
    """A numerical scheme as a frozen value whose fields are the options of the scheme.

    Notes
    -----
    A solver that compiles code may have a method `kernel(problem)`. It returns a hashable value that is equal for two problems exactly
    when the compiled code is the same, so that no two worker processes compile the same code at the same time.

    A solver whose error has another order on coarse levels, until the term of the formal order dominates, may have an attribute
    `coarse_orders`: that order by quantity. What it declares then holds when the measured order lies between the two.

    A solver that does not compute in double precision may have an attribute `round_off`: the relative error that rounding causes, such
    as 1e-6. Orders are then judged by the levels whose errors lie above it, and what is conserved is kept to it.
    """

    @property
    def name(self) -> str:
        """Unique name that states the options of the scheme, usable as a netCDF group and a file name."""

    @property
    def orders(self) -> Mapping[str, float]:
        """Formal order in h of the L2 error by quantity, on smooth data and with dt proportional to h."""

    @property
    def conserves(self) -> frozenset[str]:
        """What the scheme conserves: any of "mass" and "momentum", to round-off, and "energy", at its order."""

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve the problem on one level.

        A numerical failure is reported as the `Outcome` of the solution.

        Raises
        ------
        UsageError
            If the solver does not accept the problem or the discretisation.
        RunError
            If the run failed and left no solution.
        """

"""The explicit one-dimensional material point method as a frozen value."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem import (
    Array,
    BodyForce,
    Discretisation,
    LinearElastic,
    Problem,
    Traction,
    Velocity,
    output_steps,
    require,
)
from mpmverify.solution import Outcome, Solution, Status, Work

from . import kernels
from .basis import WIDTH, greville
from .laws import LAWS, LINEAR_ELASTIC
from .state import Ends, Grid, Histories, Nodes, Outputs, Particles, Scheme, Stencil

SCHEDULES = {"USF": kernels.USF, "USL": kernels.USL, "MUSL": kernels.MUSL}
BASES = {1: "linear", 2: "quadratic"}
FORMULATIONS = {"updated": "ul", "total": "tl"}
BODY_FORCES = ("particles", "nodes")

STATUSES = {
    kernels.COMPLETED: Status.COMPLETED,
    kernels.UNSTABLE: Status.UNSTABLE,
    kernels.NON_FINITE: Status.NON_FINITE,
    kernels.LEFT_GRID: Status.LEFT_GRID,
    kernels.INVERTED: Status.NON_FINITE,
}
BLOCK = 4_000_000
"""Most body-force values held at once: 32 MB."""


class State(NamedTuple):
    """First arguments of the time loop, in its order."""

    scheme: Scheme
    grid: Grid
    particles: Particles
    stencil: Stencil
    nodes: Nodes
    ends: Ends


def end_conditions(problem: Problem, steps: int, dt: float, last: int) -> Ends:
    """Tabulate the conditions at x- and x+ over the time levels of the leapfrog."""
    conditions = [problem.boundary["x-"], problem.boundary["x+"]]
    levels = np.arange(steps + 1, dtype=np.float64) * dt
    halves = np.concatenate([[0.0], levels + 0.5 * dt])
    velocity, force = np.zeros((2, steps + 2)), np.zeros((2, steps + 1))
    for side, condition in enumerate(conditions):
        if isinstance(condition, Velocity):
            velocity[side] = condition.value(halves)
        elif isinstance(condition, Traction):
            force[side] = (-1, 1)[side] * condition.value(levels)
    held = np.array([isinstance(condition, Velocity) for condition in conditions])
    return Ends(np.array([0, last]), held, velocity, force)


def place_particles(problem: Problem, density: float, cells: int, at: Discretisation) -> Particles:
    """`ppc` particles in each cell at the offsets (i + 1/2)/ppc and their jitter, undeformed and with the initial velocity."""
    count, volume = cells * at.ppc, at.h / at.ppc
    places = np.arange(count) + 0.5
    if at.jitter:
        places += at.jitter * np.random.default_rng(at.seed).uniform(-1, 1, count)
    reference = problem.lower[0] + at.h * places / at.ppc
    velocity = problem.initial_field("velocity", reference[:, None])[:, 0].copy()
    mass, volumes = np.full(count, density * volume), np.full(count, volume)
    return Particles(reference, np.zeros(count), velocity, np.ones(count), np.zeros(count), mass, volumes)


@dataclass(frozen=True)
class MaterialPoint:
    """Explicit material point method in one dimension: leapfrog in time, lumped nodal mass, B-splines in space.

    Parameters
    ----------
    schedule : {"USF", "USL", "MUSL"}
        When the stress is updated: first, last, or last from velocities that were projected again.
    flip : float
        Share of FLIP in the velocity transfer, the rest is PIC [1].
    degree : {1, 2}
        Degree of the B-spline basis; 1 is the hat.
    formulation : {"updated", "total"}
        Lagrangian formulation.
    body_force_at : {"particles", "nodes"}
        Where the body force is evaluated; nodes keep their material coordinates in the total Lagrangian only.

    Raises
    ------
    UsageError
        If a choice does not exist, or the body force is asked for at the nodes of an updated Lagrangian grid.

    Notes
    -----
    Position, stress and deformation gradient live at t^n, velocity at t^{n-1/2}; what is returned is synchronous. A traction
    acts on the end function of the grid: in the updated Lagrangian formulation the loaded end must stay within its cell.

    References
    ----------
    Sulsky, Chen and Schreyer, 1994, doi:10.1016/0045-7825(94)90112-0. Bardenhagen, 2002, doi:10.1006/jcph.2002.7103. Steffen,
    Kirby and Berzins, 2008, doi:10.1002/nme.2360. de Vaucorbeil, Nguyen and Hutchinson, 2020, doi:10.1016/j.cma.2019.112783.
    """

    schedule: str = "MUSL"
    flip: float = 1.0
    degree: int = 1
    formulation: str = "updated"
    body_force_at: str = "particles"

    conserves: ClassVar[frozenset[str]] = frozenset({"mass", "momentum"})

    def __post_init__(self) -> None:
        for what, value, choices in (
            ("stress-update schedule", self.schedule, tuple(SCHEDULES)),
            ("degree", self.degree, tuple(BASES)),
            ("formulation", self.formulation, tuple(FORMULATIONS)),
            ("body_force_at", self.body_force_at, BODY_FORCES),
        ):
            if value not in choices:
                raise UsageError(
                    f"the {what} of a material point solver is one of {', '.join(map(str, choices))}, not {value!r}"
                )
        if not 0 <= self.flip <= 1:
            raise UsageError(f"the share of FLIP lies between 0 (PIC) and 1 (FLIP), not {self.flip!r}")
        if self.body_force_at == "nodes" and self.formulation != "total":
            raise UsageError(
                "the body force can be taken at the nodes in the total Lagrangian formulation only: set formulation='total'"
            )

    @property
    def name(self) -> str:
        transfer = {0.0: "pic", 1.0: "flip"}.get(self.flip, f"blend{100 * self.flip:.12g}")
        nodal = "-nodalforce" if self.body_force_at == "nodes" else ""
        return f"mpm-{FORMULATIONS[self.formulation]}-{BASES[self.degree]}-{self.schedule.lower()}-{transfer}{nodal}"

    @property
    def orders(self) -> Mapping[str, float]:
        """Formal orders in h while no particle crosses a cell.

        PIC damps at first order. The gradient of the hat is constant in a cell, thus second order in its middle only (`ppc` = 1). The
        lumped mass of the clamped spline is off its node by O(h) in the two functions at each end: half an order in L2 there.
        """
        if self.flip < 1:
            return {"displacement": 1.0, "velocity": 1.0, "stress": 1.0}
        if self.degree == 2:
            return {"displacement": 2.0, "velocity": 1.5, "stress": 1.5}
        return {"displacement": 2.0, "velocity": 2.0, "stress": 1.0}

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve; numerical failure is an `Outcome`.

        Raises
        ------
        UsageError
            If the problem is not a one-dimensional elastic bar with ends held or under traction, initially unstrained.
        """
        state = self._state(problem, discretisation)
        steps, dt = discretisation.time_steps(problem)
        particles = state.particles
        count = len(particles.mass)
        step = output_steps(steps, problem.outputs)
        times = np.arange(steps + 1, dtype=np.float64) * dt
        outputs = Outputs(step, *(np.zeros((len(step), count)) for _ in Outputs._fields[1:]))
        histories = Histories(*(np.zeros(steps + 1) for _ in Histories._fields))
        top_speed = np.abs(state.ends.velocity).max()
        running = np.array([0.0, 0.0, 0.0, 0.5 * particles.mass.sum() * top_speed**2])
        record = (outputs, histories, running, dt)
        kernels.march(*state, *record, np.zeros((0, 0)), 0, 0, 0)  # compiles, takes no pass

        started = time.perf_counter()
        points = greville(*state.grid) if self.body_force_at == "nodes" else particles.reference
        block = max(1, BLOCK // len(points)) if problem.body_force else steps + 1
        code, done, kept = kernels.COMPLETED, 0, 0
        while code == kernels.COMPLETED and done <= steps:
            end = min(done + block, steps + 1)
            body = _tabulate(problem.body_force, points, times[done:end])
            code, done, kept = kernels.march(*state, *record, body, done, end, kept)
        seconds = time.perf_counter() - started

        cause = "; a particle's deformation gradient reached zero" if code == kernels.INVERTED else ""
        detail = "" if code == kernels.COMPLETED else f"at step {done} of {steps}{cause}"
        taken = min(done, steps)
        displacement = outputs.displacement[:kept, :, None]
        # A small-strain body in material coordinates keeps its volume; its F may even be negative.
        small_strain = state.scheme.total and state.scheme.law == LINEAR_ELASTIC
        return Solution(
            time=times[step[:kept]],
            dt=dt,
            reference=particles.reference[:, None],
            position=particles.reference[:, None] + displacement,
            weight=particles.volume * (np.ones_like(outputs.F[:kept]) if small_strain else outputs.F[:kept]),
            fields={
                "displacement": displacement,
                "velocity": outputs.velocity[:kept, :, None],
                "stress": outputs.stress[:kept, :, None],
            },
            histories={"time": times[:done], **{name: h[:done] for name, h in histories._asdict().items()}},
            work=Work(taken, taken * count, seconds),
            outcome=Outcome(STATUSES[code], detail),
        )

    def _state(self, problem: Problem, discretisation: Discretisation) -> State:
        """Check the problem and lay out the state at t = 0."""
        require(problem.dimension == 1, self.name, problem, "one-dimensional problems")
        material = problem.material
        require(type(material) in LAWS, self.name, problem, "linear elastic and neo-Hookean bodies")
        assert isinstance(material, LinearElastic)
        held_or_loaded = all(isinstance(condition, Velocity | Traction) for condition in problem.boundary.values())
        require(held_or_loaded, self.name, problem, "prescribed velocities and tractions as boundary conditions")
        (cells,) = discretisation.cells(problem)
        steps, dt = discretisation.time_steps(problem)
        particles = place_particles(problem, material.density, cells, discretisation)
        for quantity in ("displacement", "displacement_gradient", "stress"):
            given = problem.initial_field(quantity, particles.reference[:, None])
            require(not given.any(), self.name, problem, f"bodies without an initial {quantity}")
        scheme = Scheme(
            SCHEDULES[self.schedule],
            float(self.flip),
            self.formulation == "total",
            self.body_force_at == "nodes",
            LAWS[type(material)],
            float(material.lame_lambda),
            float(material.shear_modulus),
        )
        count = len(particles.mass)
        stencil = Stencil(np.zeros(count, dtype=np.uint32), np.zeros((count, WIDTH)), np.zeros((count, WIDTH)))
        nodes = Nodes(*(np.zeros(cells + WIDTH - 1) for _ in Nodes._fields))
        grid = Grid(float(problem.lower[0]), float(discretisation.h), cells, self.degree)
        return State(scheme, grid, particles, stencil, nodes, end_conditions(problem, steps, dt, cells + self.degree - 1))


def _tabulate(body_force: BodyForce | None, points: Array, times: Array) -> Array:
    """Body force at material points (K,) [m] and times (B,) [s], (B, K) [m/s^2]; empty when there is none."""
    if body_force is None:
        return np.zeros((0, 0))
    return np.ascontiguousarray(body_force(points[:, None], times)[:, :, 0], dtype=float)

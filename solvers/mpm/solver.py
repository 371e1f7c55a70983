"""The explicit material point method as a frozen value."""

import math
import time
from collections.abc import Hashable, Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem import (
    REGULAR,
    Array,
    Discretisation,
    Layout,
    LinearElastic,
    Periodic,
    Problem,
    Spatial,
    output_steps,
    place_particles,
    require,
)
from mpmverify.solution import Solution, Work

from . import formal_orders, loop, passes
from .acceptance import check
from .affine import AFFINE
from .basis import BASES, Axis, Basis, basis_axis, grid_of
from .constitution import LAWS, LINEAR_ELASTIC, constitution
from .endings import End, outcome
from .faces import ghosts, node_positions, tabulate_body_force, tabulate_faces
from .histories import COMPLETED, Outputs, by_component, no_histories
from .order import Strips, strips
from .reconstruction import cells_of
from .start import particles_at_start
from .state import Grid, Nodes, Particles, Scheme, Series, nodal
from .transfers import FLIP, Transfer

SCHEDULES = {"USF": passes.USF, "USL": passes.USL, "MUSL": passes.MUSL}
FORMULATIONS = {"updated": "ul", "total": "tl"}
BODY_FORCES = ("particles", "nodes")

BLOCK = 100_000
"""Largest number of body-force values held at once, so that most runs have several blocks: 0.8 MB."""
MANY = 50_000
"""Number of particles from which several threads are used."""


@dataclass(frozen=True)
class MaterialPoint:
    """Explicit material point method in one, two and three dimensions: leapfrog in time, lumped nodal mass.

    Parameters
    ----------
    schedule : {"USF", "USL", "MUSL"}
        When the stress is updated: first, last, or last from velocities that were projected again.
    transfer : Transfer
        How the velocity of the grid becomes that of the particles.
    basis : {"linear", "quadratic", "cubic", "mls-quadratic", ..., "tls-linear", ..., "ugimp", "cpgimp", "cpdi"}
        B-splines of the grid, of which the linear ones are hats; B-splines with the gradients of moving least squares, or with Taylor
        least squares in the cells; hats averaged over the domain of a particle, which keeps its shape, stretches along the axes, or
        deforms to a parallelepiped. See `basis.BASES`.
    formulation : {"updated", "total"}
        Lagrangian formulation.
    body_force_at : {"particles", "nodes"}
        Where the body force is evaluated; at the nodes, in the total Lagrangian formulation only, where they are material points.
    layout : Layout
        Initial places of the particles in a cell.
    record_every : int
        Steps from one entry of the histories to the next; the first and the last step are always recorded. Instability is detected
        at these steps.

    Raises
    ------
    UsageError
        If a choice does not exist, or two do not go together: the body force at the nodes and the updated Lagrangian formulation, an
        affine transfer and CPDI, Gauss points and domains, USF and domains that stretch, Taylor least squares and USF or a transfer
        other than PIC, FLIP and their blends.

    Notes
    -----
    Position, stress and deformation are known at t^n, velocity at t^{n-1/2}; the solution is synchronous. Of a linear elastic body only
    the determinant of the deformation gradient is kept, unless its particles have domains. A traction acts on the end functions of the
    grid: in the updated Lagrangian formulation a loaded face must stay within its cells. Where a free surface enters a cell by little,
    f/m of the nodes beyond it is large. This is harmless with B-splines; with linear functions use FLIP or FMPM and USF or MUSL, whose
    strains come from velocities averaged by the mass of the particles. Taylor least squares in the updated Lagrangian formulation needs
    more than two particles along an axis of a cell, and may need more than three if they begin jittered.

    References
    ----------
    Sulsky, Chen and Schreyer, 1994, doi:10.1016/0045-7825(94)90112-0. Bardenhagen, 2002, doi:10.1006/jcph.2002.7103. Steffen,
    Kirby and Berzins, 2008, doi:10.1002/nme.2360. Jiang, Schroeder and Teran, 2017, doi:10.1016/j.jcp.2017.02.050 (APIC). de
    Vaucorbeil, Nguyen and Hutchinson, 2020, doi:10.1016/j.cma.2019.112783. Bardenhagen and Kober, 2004, CMES 5(6), 477-495 (GIMP).
    Wallstedt and Guilkey, 2008, doi:10.1016/j.jcp.2008.07.019 (cpGIMP). Sadeghirad, Brannon and Burghardt, 2011, doi:10.1002/nme.3110
    (CPDI). Hu and others, 2018, doi:10.1145/3197517.3201293 (moving least squares). Wobbes, Moller, Galavi and Vuik, 2019,
    doi:10.1002/nme.5956 (Taylor least squares).
    """

    schedule: str = "MUSL"
    transfer: Transfer = FLIP
    basis: str = "linear"
    formulation: str = "updated"
    body_force_at: str = "particles"
    layout: Layout = REGULAR
    record_every: int = 1

    def __post_init__(self) -> None:
        for what, value, choices in (
            ("stress-update schedule", self.schedule, tuple(SCHEDULES)),
            ("basis", self.basis, tuple(BASES)),
            ("formulation", self.formulation, tuple(FORMULATIONS)),
            ("body_force_at", self.body_force_at, BODY_FORCES),
        ):
            if value not in choices:
                raise UsageError(
                    f"the {what} of a material point solver is one of {', '.join(map(str, choices))}, not {value!r}"
                )
        for kind, chosen in ((Transfer, self.transfer), (Layout, self.layout)):
            if not isinstance(chosen, kind):
                what = kind.__name__.lower()
                raise UsageError(f"the {what} of a material point solver is one of mpmverify.solvers.mpm, not {chosen!r}")
        if not (isinstance(self.record_every, int) and self.record_every >= 1):
            raise UsageError(
                f"the histories are recorded every step or every n, not every {self.record_every!r}: give a whole n"
            )
        if self.transfer.affine and self.basis == "cpdi":
            raise UsageError("an affine transfer needs functions that are products: choose another basis than CPDI")
        series = self.transfer.affine or self.transfer.terms > 1
        if self._basis.kind.fitted and (series or self.schedule == "USF"):
            raise UsageError("Taylor least squares goes with PIC, FLIP or a blend of both, and with USL or MUSL")
        if self.schedule == "USF" and self._basis.stretched and self.formulation == "updated":
            raise UsageError("USF would stretch the domains between the two transfers of a step: choose USL or MUSL")
        if self.layout.gauss and self._basis.kind.domains:
            raise UsageError("the domains of GIMP and CPDI are equal parts of a cell: choose another layout than Gauss points")
        if self.body_force_at == "nodes" and self.formulation != "total":
            raise UsageError(
                "the body force can be taken at the nodes in the total Lagrangian formulation only: set formulation='total'"
            )

    @property
    def _basis(self) -> Basis:
        return BASES[self.basis]

    @property
    def name(self) -> str:
        choices = FORMULATIONS[self.formulation], self.basis, self.schedule.lower(), self.transfer.name
        nodal = "-nodalforce" if self.body_force_at == "nodes" else ""
        return f"mpm-{'-'.join(choices)}{nodal}{'' if self.layout == REGULAR else f'-{self.layout.name}'}"

    @property
    def conserves(self) -> frozenset[str]:
        """Mass, and momentum unless fields are fitted: Taylor least squares conserves it to the grid, but not back to the particles."""
        return frozenset({"mass"} if self._basis.kind.fitted else {"mass", "momentum"})

    @property
    def orders(self) -> Mapping[str, float]:
        """Formal orders in h, see `formal_orders.orders`."""
        return formal_orders.orders(self._basis, self.transfer)

    @property
    def coarse_orders(self) -> Mapping[str, float]:
        """Orders on coarse levels, see `formal_orders.coarse_orders`."""
        return formal_orders.coarse_orders(self._basis, self.transfer)

    def kernel(self, problem: Problem) -> Hashable:
        """Key of the compiled loop: equal for problems that share it."""
        kind, width, law = type(self._basis.kind), self._basis.width, LAWS.get(type(problem.material))
        return problem.dimension, kind, width, self.transfer.affine, self.transfer.terms > 1, law is LINEAR_ELASTIC

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve; numerical failure is an `Outcome`.

        Raises
        ------
        UsageError
            If `acceptance.check` refuses the problem, or its body force in spatial coordinates is to be evaluated at the nodes.
        """
        check(problem, self.name, self._basis.kind.fitted)
        nodal = self.body_force_at == "nodes" and isinstance(problem.body_force, Spatial)
        require(not nodal, self.name, problem, "a body force in spatial coordinates at the particles only")
        steps, dt = discretisation.time_steps(problem)
        axes = self._axes(problem, discretisation)
        grid = self._grid(axes, discretisation)
        reference, volume = place_particles(problem, discretisation, self.layout)
        particles = self._particles(problem, reference, volume)
        count, dimension = reference.shape
        state = (
            self._scheme(problem),
            grid,
            particles,
            self._nodes(axes, problem),
            tabulate_faces(problem, axes, discretisation.h, steps, dt),
            self._strips(problem, discretisation, grid, particles),
        )
        step = output_steps(steps, problem.outputs)
        times = np.arange(steps + 1, dtype=np.float64) * dt
        u, v, sigma = (np.zeros((len(step), count, n)) for n in (dimension, dimension, particles.stress.shape[1]))
        outputs = Outputs(step, u, v, sigma, np.zeros((len(step), count)))
        histories = no_histories(steps, self.record_every, dimension)
        top_speed = np.abs(state[4].velocity).max()
        running = np.concatenate([[0.0, 0.0, 0.5 * particles.mass.sum() * top_speed**2, 0.0], np.zeros(dimension)])
        record = (outputs, histories, running, dt)
        march = loop.march
        if count >= MANY:
            march = loop.march_in_threads
        at_rest = np.zeros((0, 0, 0)), 0, 0, 0
        advance = march.entry(*state, *record, *at_rest).bound(*state, *record)
        advance(*at_rest)

        started = time.perf_counter()
        points = node_positions(axes) if self.body_force_at == "nodes" else reference
        spatial = isinstance(problem.body_force, Spatial)
        block = 1 if spatial else max(1, BLOCK // points.size) if problem.body_force else steps + 1
        code, done, kept = COMPLETED, 0, 0
        while code == COMPLETED and done <= steps:
            end = min(done + block, steps + 1)
            if spatial:
                points = np.empty_like(reference)
                points[particles.place] = particles.position
            body = tabulate_body_force(problem.body_force, points, times[done:end])
            code, done, kept = advance(body, done, end, kept)
        seconds = time.perf_counter() - started

        ended = End(code, done, steps, dt, reference[particles.place], particles.position, state[3])
        taken = min(done, steps)
        return Solution(
            time=times[step[:kept]],
            dt=dt,
            reference=reference,
            position=reference + outputs.displacement[:kept],
            weight=outputs.volume[:kept],
            fields={
                "displacement": outputs.displacement[:kept],
                "velocity": outputs.velocity[:kept],
                "stress": outputs.stress[:kept],
            },
            histories={"time": times[histories.step[histories.step < done]], **by_component(histories, done)},
            work=Work(taken, taken * count, seconds),
            outcome=outcome(ended, problem, discretisation, self.basis),
        )

    def _scheme(self, problem: Problem) -> Scheme:
        assert isinstance(problem.material, LinearElastic)
        return Scheme(
            SCHEDULES[self.schedule],
            AFFINE[self.transfer.affine],
            float(self.transfer.flip),
            Series(self.transfer.terms, self.transfer.full_mass) if self.transfer.terms > 1 else None,
            self.formulation == "total",
            self.body_force_at == "nodes",
            *constitution(problem.material),
        )

    def _axes(self, problem: Problem, at: Discretisation) -> tuple[Axis, ...]:
        return tuple(
            basis_axis(self._basis, lower, at.h, cells, isinstance(problem.boundary[f"{name}-"], Periodic))
            for name, lower, cells in zip("xyz", problem.lower, at.cells(problem), strict=False)
        )

    def _grid(self, axes: tuple[Axis, ...], at: Discretisation) -> Grid:
        stretched = self._basis.stretched and self.formulation == "updated"
        return grid_of(axes, at.h, self._basis, ghosts(axes), 0.5 / at.ppc, stretched)

    def _nodes(self, axes: tuple[Axis, ...], problem: Problem) -> Nodes:
        count, d = math.prod(len(axis.nodes) for axis in axes), len(axes)
        values = [nodal(n, count) for n in (1 + d, *[d] * 6)]
        return Nodes(*[*values, cells_of(axes, self._basis, problem.boundary)])

    def _strips(self, problem: Problem, at: Discretisation, grid: Grid, particles: Particles) -> Strips:
        many, moving = particles.place.size >= MANY, self.formulation == "updated"
        rows = (2 if self._basis.width == 2 else 4) + self._basis.kind.reach
        return strips(grid.lower[-1], at.h, at.cells(problem), rows, particles, moving, grid.stride[-1], many)

    def _particles(self, problem: Problem, reference: Array, volume: Array) -> Particles:
        whole = self._basis.kind.domains or LAWS[type(problem.material)] is not LINEAR_ELASTIC
        return particles_at_start(problem, reference, volume, whole, bool(self.transfer.affine))

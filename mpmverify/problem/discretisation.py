"""One level of a refinement: cell size, time step and particles; and the steps at which a solver returns its fields."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpmverify.errors import UsageError
from mpmverify.problem.problem import Problem


@dataclass(frozen=True)
class Discretisation:
    """One level of a refinement.

    Parameters
    ----------
    h : float
        Cell or element size [m]; must divide every side of the box.
    courant : float
        Upper bound of the Courant number nu_C = c dt/h; dt is chosen so that it divides the final time.
    ppc : int
        Particles per cell and dimension; grid-based solvers ignore it.
    jitter : float
        Largest random displacement of a particle from its regular position, as a fraction of the particle spacing; below 1/2,
        so that every particle stays in its cell. The particle volumes do not change. Grid-based solvers ignore it.
    seed : int
        Seed of the displacements, which are uniform and independent: `numpy.random.default_rng(seed)`.

    Raises
    ------
    UsageError
        If h or the Courant number is not positive and finite, ppc is less than 1, the jitter is not in [0, 1/2), the seed is
        negative, or a seed is given without jitter.
    """

    h: float
    courant: float
    ppc: int = 1
    jitter: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name, value in (("cell size", self.h), ("Courant number", self.courant)):
            if not (math.isfinite(value) and value > 0):
                raise UsageError(f"the {name} must be positive and finite, not {value!r}")
        if self.ppc < 1:
            raise UsageError(f"the number of particles per cell must be at least 1, not {self.ppc!r}")
        if not 0 <= self.jitter < 0.5:
            raise UsageError(f"the jitter is a fraction of the particle spacing in [0, 0.5), not {self.jitter!r}")
        if self.seed < 0 or (self.seed and not self.jitter):
            raise UsageError(f"a seed must not be negative and needs a jitter: give a jitter with the seed {self.seed!r}")

    def cells(self, problem: Problem) -> tuple[int, ...]:
        """Return the number of cells along each side of the problem's box.

        Raises
        ------
        UsageError
            If the cell size does not divide a side to a relative 1e-9.
        """
        counts = tuple(round(length / self.h) for length in problem.lengths)
        for count, length in zip(counts, problem.lengths, strict=True):
            if count < 1 or abs(count * self.h - length) > 1e-9 * length:
                raise UsageError(f"problem {problem.name!r}: a cell size of {self.h!r} does not divide the side {length!r}")
        return counts

    def time_steps(self, problem: Problem) -> tuple[int, float]:
        """Return the number of steps and the time step [s]: the fewest equal steps within the Courant number."""
        limit = self.courant * self.h / problem.material.wave_speed
        steps = max(1, math.ceil(problem.end_time / limit - 1e-9))
        return steps, problem.end_time / steps


def output_steps(steps: int, outputs: int) -> NDArray[np.int64]:
    """Return the steps at which fields are returned: the first, the last and equally spaced ones between, each step at most once."""
    count = min(steps, outputs)
    return np.round(np.arange(count + 1) * (steps / count)).astype(np.int64)

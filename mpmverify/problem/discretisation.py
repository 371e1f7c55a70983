"""One level of a refinement: cell size, time step and particles, and the steps at which fields are returned."""

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
        Courant number nu_C = c dt/h, an upper bound: the time step divides the final time.
    ppc : int
        Particles per cell and dimension; grid-based solvers ignore it.
    jitter : float
        Largest displacement of a particle from its place, as a share of the spacing of particles, below 1/2 so that none
        leaves its cell; grid-based solvers ignore it. Volumes stay: the quadrature is off by what the particles are.
    seed : int
        Of the displacements, which are uniform and independent: `numpy.random.default_rng(seed)`.

    Raises
    ------
    UsageError
        If a value is not positive and finite, the jitter is not in [0, 1/2), or a seed is given without jitter.
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
            raise UsageError(f"the jitter of the particles is a share of their spacing in [0, 0.5), not {self.jitter!r}")
        if self.seed < 0 or (self.seed and not self.jitter):
            raise UsageError(f"a seed is not negative and needs a jitter: give one beside the seed {self.seed!r}")

    def cells(self, problem: Problem) -> tuple[int, ...]:
        """Number of cells along each side of the problem's box."""
        counts = tuple(round(length / self.h) for length in problem.lengths)
        for count, length in zip(counts, problem.lengths, strict=True):
            if count < 1 or abs(count * self.h - length) > 1e-9 * length:
                raise UsageError(f"problem {problem.name!r}: a cell size of {self.h!r} does not divide the side {length!r}")
        return counts

    def time_steps(self, problem: Problem) -> tuple[int, float]:
        """Number of steps and the step [s]: the fewest equal steps that respect the Courant number."""
        limit = self.courant * self.h / problem.material.wave_speed
        steps = max(1, math.ceil(problem.end_time / limit - 1e-9))
        return steps, problem.end_time / steps


def output_steps(steps: int, outputs: int) -> NDArray[np.int64]:
    """Steps at which fields are returned: 0, the last one and evenly between, at most one output a step."""
    count = min(steps, outputs)
    return np.round(np.arange(count + 1) * (steps / count)).astype(np.int64)

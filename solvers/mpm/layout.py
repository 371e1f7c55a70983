"""Where the particles of a body begin."""

import numpy as np

from mpmverify.problem import Array, Discretisation, Problem


def place_particles(problem: Problem, at: Discretisation) -> tuple[Array, Array]:
    """Reference positions (P, d) [m], x fastest, and volumes (P,) [m^d].

    `ppc` particles along each axis of a cell at the offsets (i + 1/2)/ppc, and their jitter.
    """
    counts = [cells * at.ppc for cells in at.cells(problem)]
    along = [np.arange(count) + 0.5 for count in counts]
    places = np.stack([axis.ravel() for axis in reversed(np.meshgrid(*reversed(along), indexing="ij"))], axis=1)
    if at.jitter:
        places += at.jitter * np.random.default_rng(at.seed).uniform(-1, 1, places.shape)
    volume = (at.h / at.ppc) ** problem.dimension
    return np.array(problem.lower) + at.h * places / at.ppc, np.full(len(places), volume)

"""Speed of linear USL in 2D relative to the limit of the memory bandwidth: `python tests/benchmarks/bandwidth.py`.

The limit counts the particle data that a step moves, each number once per pass. It leaves out the grid: loops over the nodes are
short compared with those over the particles, and the nodes stay in the cache as long as a few rows of the grid fit into it.
"""

import math
import time
from collections.abc import Callable

import click
import numba
import numpy as np
from bodies import periodic_body
from rich.console import Console
from rich.table import Table
from schemes import SCHEMES

from mpmverify.problem import Array

DOUBLE = 8
"""Bytes of a float64."""
LEAN = 208
"""Bytes per particle-step of a layout with (x, v), (sigma, sigma_zz) and (m, V) only: 80 to the grid, 128 to the particles."""


def bytes_of_step(dimension: int) -> tuple[int, int]:
    """Bytes per particle-step of linear USL with FLIP: read in the pass to the grid; read and written in the pass from the grid.

    The state x, v, J, sigma, m and V of a particle is one row, which is moved as a whole because memory is moved by cache lines. Each
    pass also reads the order of the particles. Sorting the particles by cell every few steps is not counted.
    """
    state, order = 2 * dimension + 1 + dimension * (dimension + 1) // 2 + 2, 1
    return DOUBLE * (state + order), DOUBLE * (2 * state + order)


@numba.njit(parallel=True)
def triad(a: Array, b: Array, c: Array, factor: float) -> None:
    """Set a = b + factor c: 24 bytes per entry."""
    for i in numba.prange(a.size):
        a[i] = b[i] + factor * c[i]


@numba.njit(parallel=True)
def update(a: Array, factor: float) -> None:
    """Multiply a by a factor in place: 16 bytes per entry."""
    for i in numba.prange(a.size):
        a[i] *= factor


def bandwidth(entries: int = 20_000_000, rounds: int = 7) -> tuple[float, float]:
    """Best measured bandwidth of the triad and of the update in place [byte/s], on numba's current number of threads."""
    a, b, c = np.ones((3, entries))
    calls: tuple[tuple[int, Callable[[], None]], ...] = ((24, lambda: triad(a, b, c, 2.0)), (16, lambda: update(a, 1.0)))
    found = []
    for size, call in calls:
        seconds = math.inf
        for _ in range(rounds + 1):
            started = time.perf_counter()
            call()
            seconds = min(seconds, time.perf_counter() - started)
        found.append(size * entries / seconds)
    return found[0], found[1]


@click.command(help=__doc__.split("\n")[0])
@click.option("--particles", type=float, default=1e6, show_default=True, help="Approximate number of particles.")
@click.option("--steps", type=int, default=40, show_default=True, help="Steps per round.")
@click.option("--rounds", type=int, default=5, show_default=True, help="Number of rounds; the best one counts.")
def main(particles: float, steps: int, rounds: int) -> None:
    problem, at = periodic_body(2, particles, steps)
    solver = SCHEMES["linear USL FLIP"]
    moved = sum(bytes_of_step(2))
    table = Table(title=f"{solver.name}: share of the memory limit at {moved} (lean: {LEAN}) bytes per particle-step")
    for heading in ("threads", "triad GB/s", "update GB/s", "limit Mp/s", "measured Mp/s", "share", "lean limit Mp/s", "share"):
        table.add_column(heading, justify="right")
    for threads in sorted({1, numba.config.NUMBA_NUM_THREADS}):
        numba.set_num_threads(threads)
        streamed, updated = bandwidth()
        works = [solver.solve(problem, at).work for _ in range(rounds)]
        rate = max(work.point_steps / work.seconds for work in works)
        limits = updated / moved, updated / LEAN
        shares = [(f"{1e-6 * limit:.0f}", f"{rate / limit:.0%}") for limit in limits]
        measured = f"{1e-6 * rate:.1f}"
        table.add_row(
            str(threads), f"{1e-9 * streamed:.1f}", f"{1e-9 * updated:.1f}", shares[0][0], measured, shares[0][1], *shares[1]
        )
    Console(width=120).print(table)


if __name__ == "__main__":
    main()

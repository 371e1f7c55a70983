"""Share of the limit that the memory sets to linear USL in two dimensions: `python tests/benchmarks/bandwidth.py`.

The limit counts what a step moves of the particles alone, each number once per pass; that of the grid, the loops over which are
short beside them, stays in the cache as long as a few rows of it do.
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
LEAN = 208
"""Bytes a particle-step with (x, v), (sigma, sigma_zz) and (m, V) alone: 80 to the grid, 128 to the particles."""


def bytes_of_step(dimension: int) -> tuple[int, int]:
    """Bytes that linear USL with FLIP moves for a particle and step, in each pass: read to the grid, read and written from it.

    The state x, v, J, sigma, m and V lies in one row, so that all of it comes and goes with its cache lines; either pass reads whose turn it
    is. To bring particles of a cell together again, every few steps, is not counted.
    """
    state, turn = 2 * dimension + 1 + dimension * (dimension + 1) // 2 + 2, 1
    return DOUBLE * (state + turn), DOUBLE * (2 * state + turn)


@numba.njit(parallel=True)
def triad(a: Array, b: Array, c: Array, factor: float) -> None:
    """Write b + factor c into a: 24 bytes an entry."""
    for i in numba.prange(a.size):
        a[i] = b[i] + factor * c[i]


@numba.njit(parallel=True)
def update(a: Array, factor: float) -> None:
    """Multiply a by a factor: 16 bytes an entry."""
    for i in numba.prange(a.size):
        a[i] *= factor


def bandwidth(entries: int = 20_000_000, rounds: int = 7) -> tuple[float, float]:
    """Best of triad and of the update in place [byte/s], on as many threads as numba is set to."""
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
@click.option("--particles", type=float, default=1e6, show_default=True, help="Number of particles, about.")
@click.option("--steps", type=int, default=40, show_default=True, help="Steps of a round.")
@click.option(
    "--rounds", type=int, default=5, show_default=True, help="Rounds, of which the best counts, as for the bandwidth."
)
def main(particles: float, steps: int, rounds: int) -> None:
    problem, at = periodic_body(2, particles, steps)
    solver = SCHEMES["linear USL FLIP"]
    moved = sum(bytes_of_step(2))
    table = Table(title=f"{solver.name}: share of the limit of memory at {moved} (lean: {LEAN}) bytes a particle-step")
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

"""Speed compared with taichi and warp on the same problem: `python tests/benchmarks/peers.py`.

The problem is a periodic box of linear elastic material in two or three dimensions, in double precision, with two particles per cell
along each axis. Two schemes are compared, both USL and updated Lagrangian: hat functions with FLIP, and quadratic B-splines with APIC. The
second is the scheme of taichi's examples mpm88 and mpm99, but with the gradient of the splines instead of moving least squares. All
codes take the same particles, sorted by cell, and the same time step. Their positions, velocities and stresses are compared before
they are timed. The peers do less work: they store det F instead of F and one mass and volume for all particles, and they compute neither
energies nor checks.

Each code's loop over the steps is timed without compilation. The codes take turns.
"""

import os
import statistics
import time
from collections.abc import Callable

import click
import numba
import numpy as np
from bodies import periodic_body
from rich.console import Console
from rich.table import Table
from schemes import SCHEMES, Body, Peer, State, advance, sorted_body, synchronous

from mpmverify.problem import Array, Discretisation, Problem
from mpmverify.solution import Solution
from mpmverify.solvers.mpm import MaterialPoint

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
TOLERANCE = 1e-10
"""Largest accepted deviation: the schemes are the same, so that after some dozen steps results differ by round-off only."""


def deviation(state: State, order: Array, solution: Solution) -> dict[str, float]:
    """Largest difference of displacement, velocity and stress at the end, relative to the largest value of each [1]."""
    found = {}
    displacement = state.position - solution.reference[order]
    for name, values in (("displacement", displacement), ("velocity", state.velocity), ("stress", state.stress)):
        ours = solution.fields[name][-1][order]
        found[name] = float(np.abs(values - ours).max() / np.abs(ours).max())
    return found


def seconds_of_peer(peer: Peer, body: Body, steps: int) -> float:
    """Wall time of a number of steps from the current state [s]."""
    peer.wait()
    started = time.perf_counter()
    for _ in range(steps):
        peer.step(body.dt, body.dt)
    peer.wait()
    return time.perf_counter() - started


def peers_of(body: Body, quadratic: bool, threads: int) -> dict[str, Peer]:
    """Peers by name: taichi on a number of threads, and in two dimensions warp, which runs on one thread."""
    from taichi_peer import TaichiPeer
    from warp_peer import WarpPeer

    peers: dict[str, Peer] = {"taichi": TaichiPeer(body, quadratic, threads)}
    return peers | {"warp": WarpPeer(body, quadratic)} if body.position.shape[1] == 2 else peers


def compare(
    solver: MaterialPoint, problem: Problem, at: Discretisation, steps: int, rounds: int, threads: int
) -> dict[str, float]:
    """Million particle-steps per second of each code, as the median over rounds in which the codes take turns."""
    numba.set_num_threads(threads)
    solution = solver.solve(problem, at)
    body, order = sorted_body(problem, at, solution.reference)
    peers = peers_of(body, solver.basis == "quadratic", threads)
    for name, peer in peers.items():
        advance(peer, body, steps)
        found = deviation(synchronous(peer, body), order, solution)
        click.echo(
            f"{solver.name}, {threads} threads, {name}: differs by " + ", ".join(f"{k} {v:.1e}" for k, v in found.items())
        )
        if not max(found.values()) < TOLERANCE:
            raise SystemExit(f"{name} does not solve the same problem: its results differ by more than {TOLERANCE:g}")
    del solution
    timed: dict[str, Callable[[], float]] = {"mpmverify": lambda: solver.solve(problem, at).work.seconds}
    timed |= {name: lambda peer=peer: seconds_of_peer(peer, body, steps) for name, peer in peers.items()}
    seconds: dict[str, list[float]] = {name: [] for name in timed}
    for _ in range(rounds):
        for name, measure in timed.items():
            seconds[name].append(measure())
    return {name: 1e-6 * len(body.position) * steps / statistics.median(values) for name, values in seconds.items()}


@click.command(help=__doc__.split("\n")[0])
@click.option("--particles", type=float, default=1e6, show_default=True, help="Approximate number of particles.")
@click.option("--steps", type=int, default=40, show_default=True, help="Steps per round.")
@click.option("--rounds", type=int, default=5, show_default=True, help="Number of rounds; the median counts.")
@click.option("--threads", type=int, multiple=True, help="Numbers of threads  [default: 1 and all].")
@click.option("--scheme", type=click.Choice(sorted(SCHEMES)), multiple=True, help="Schemes  [default: all].")
@click.option("--dimension", type=click.IntRange(2, 3), default=2, show_default=True, help="Dimension of the body.")
def main(particles: float, steps: int, rounds: int, threads: tuple[int, ...], scheme: tuple[str, ...], dimension: int) -> None:
    problem, at = periodic_body(dimension, particles, steps)
    count = (at.ppc * at.cells(problem)[0]) ** dimension
    table = Table(title=f"Million particle-steps per second, {dimension}D, {count:,} particles, float64")
    for heading in ("scheme", "threads", "mpmverify", "taichi", "warp", "/ taichi", "/ warp", "/ faster peer"):
        table.add_column(heading, justify="left" if heading == "scheme" else "right")
    for name in scheme or SCHEMES:
        for some in threads or sorted({1, numba.config.NUMBA_NUM_THREADS}):
            rate = compare(SCHEMES[name], problem, at, steps, rounds, some)
            click.echo(", ".join(f"{code} {value:.1f}" for code, value in rate.items()) + " million particle-steps per second")
            ours, *others = (rate.get(code) for code in ("mpmverify", "taichi", "warp"))
            ratios = [other and ours / other for other in (*others, max(filter(None, others)))]
            shown = [f"{r:.1f}" if r else "" for r in (ours, *others)] + [f"{r:.2f}" if r else "" for r in ratios]
            table.add_row(name, str(some), *shown)
    Console(width=120).print(table)


if __name__ == "__main__":
    main()

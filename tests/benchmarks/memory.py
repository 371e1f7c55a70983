"""Peak memory of a run: `python tests/benchmarks/memory.py`.

Linear USL with FLIP in two dimensions takes, per particle, 80 bytes of state, 20 bytes of cell, order and node numbers, and 24 bytes of
layout. At four particles per cell a node's 128 bytes are 32 bytes per particle, and a cell's 8 bytes are 2. Each output time takes 64 bytes per
particle, and 16 more for the positions when the solution is returned. With two output times, the first and the last, the peak is at the end:
80 + 20 + 24 + 32 + 2 + 2 (64 + 16) = 318 bytes per particle.
"""

import resource
import sys

import click
from bodies import periodic_body
from schemes import SCHEMES


def peak() -> float:
    """Peak resident set size of this process [byte]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


@click.command(help=__doc__.split("\n")[0])
@click.option("--particles", type=float, default=1e7, show_default=True, help="Approximate number of particles.")
@click.option("--steps", type=int, default=4, show_default=True, help="Steps of the run.")
@click.option("--dimension", type=click.IntRange(1, 3), default=2, show_default=True, help="Dimension of the body.")
@click.option("--scheme", type=click.Choice(sorted(SCHEMES)), default="linear USL FLIP", show_default=True, help="Scheme.")
def main(particles: float, steps: int, dimension: int, scheme: str) -> None:
    solver = SCHEMES[scheme]
    solver.solve(*periodic_body(dimension, 60_000, 1))  # compiles the threaded time loop
    before = peak()
    solution = solver.solve(*periodic_body(dimension, particles, steps))
    assert solution.outcome.completed, str(solution.outcome)
    count = len(solution.reference)
    click.echo(
        f"{solver.name}, {dimension}D, {count:,} particles: peak {peak() / 2**30:.2f} GiB resident, {before / 2**30:.2f} GiB of it "
        f"before the run: {(peak() - before) / count:.0f} bytes per particle"
    )


if __name__ == "__main__":
    main()

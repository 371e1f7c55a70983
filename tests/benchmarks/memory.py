"""Largest resident memory of a run: `python tests/benchmarks/memory.py`.

In two dimensions a particle of linear USL with FLIP takes 80 bytes of state, 20 of its place, its turn and its node, and 24 of its layout, a
node 128 bytes (32 a particle at four a cell), a cell 8 (2 a particle), each output time 64 bytes a particle and 16 more for its position at the
end. With the first and the last time alone the most is reached there: 80 + 20 + 24 + 32 + 2 + 2 (64 + 16) = 318.
"""

import resource
import sys

import click
from bodies import periodic_body
from schemes import SCHEMES


def peak() -> float:
    """Largest resident set of this process so far [byte]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


@click.command(help=__doc__.split("\n")[0])
@click.option("--particles", type=float, default=1e7, show_default=True, help="Number of particles, about.")
@click.option("--steps", type=int, default=4, show_default=True, help="Steps of the run.")
@click.option("--dimension", type=click.IntRange(1, 3), default=2, show_default=True, help="Of the body.")
@click.option("--scheme", type=click.Choice(sorted(SCHEMES)), default="linear USL FLIP", show_default=True, help="Scheme.")
def main(particles: float, steps: int, dimension: int, scheme: str) -> None:
    solver = SCHEMES[scheme]
    solver.solve(*periodic_body(dimension, 60_000, 1))  # compiles the loop in threads
    before = peak()
    solution = solver.solve(*periodic_body(dimension, particles, steps))
    assert solution.outcome.completed, str(solution.outcome)
    count = len(solution.reference)
    click.echo(
        f"{solver.name}, {dimension}D, {count:,} particles: at most {peak() / 2**30:.2f} GiB resident, {before / 2**30:.2f} GiB of it "
        f"before the run: {(peak() - before) / count:.0f} bytes a particle"
    )


if __name__ == "__main__":
    main()

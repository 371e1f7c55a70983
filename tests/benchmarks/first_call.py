"""Compilation time in the first run of a variant: `python tests/benchmarks/first_call.py`.

Two new processes solve each variant one after the other. The disk cache is empty at first: the first process compiles the time loop, the
second process finds it on the disk.
"""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from typing import Any

import click
from bodies import MATERIAL, periodic_body
from rich.console import Console
from rich.table import Table

from mpmverify.problem import NeoHookean
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint, fmpm
from mpmverify.solvers.mpm.solver import MANY

FEW = 1_000
FINITE_STRAIN = NeoHookean(MATERIAL.youngs_modulus, MATERIAL.density, MATERIAL.poissons_ratio)
VARIANTS: list[tuple[Any, ...]] = [
    (1, MaterialPoint("MUSL", FLIP, "linear"), FEW),
    (2, MaterialPoint("USL", FLIP, "linear"), FEW),
    (2, MaterialPoint("USL", FLIP, "linear"), 1.2 * MANY),
    (2, MaterialPoint("USL", APIC, "quadratic"), FEW),
    (3, MaterialPoint("USL", APIC, "quadratic"), FEW),
    (3, MaterialPoint("USL", APIC, "quadratic"), 1.2 * MANY),
    (3, MaterialPoint("USL", fmpm(2), "cubic"), FEW),
    (3, MaterialPoint("USL", APIC, "cubic"), 1.2 * MANY),
    (3, MaterialPoint("MUSL", FLIP, "cpdi"), FEW),
    (3, MaterialPoint("MUSL", FLIP, "tls-cubic"), 1.2 * MANY),
    (3, MaterialPoint("USL", APIC, "quadratic"), FEW, FINITE_STRAIN),
    (3, MaterialPoint("MUSL", FLIP, "tls-cubic"), 1.2 * MANY, FINITE_STRAIN),
]


def compilation_time(number: int) -> float:
    """Time of a first solution outside its time steps, less the same of a second solution [s]."""
    dimension, solver, particles, *material = VARIANTS[number]
    problem, at = periodic_body(dimension, particles, 1)
    problem = replace(problem, material=material[0] if material else MATERIAL)
    outside = []
    for _ in range(2):
        started = time.perf_counter()
        solution = solver.solve(problem, at)
        assert solution.outcome.completed, str(solution.outcome)
        outside.append(time.perf_counter() - started - solution.work.seconds)
    return outside[0] - outside[1]


def in_a_process(number: int, cache: str) -> float:
    """`compilation_time` of a variant in a new process with a disk cache [s]."""
    command = [sys.executable, __file__, "--variant", str(number)]
    said = subprocess.run(command, env=os.environ | {"NUMBA_CACHE_DIR": cache}, check=True, capture_output=True, text=True)
    return float(said.stdout)


@click.command(help=__doc__.split("\n")[0])
@click.option(
    "--variant",
    type=click.IntRange(0, len(VARIANTS) - 1),
    help="Print the seconds of one variant in this process, without the table.",
)
def main(variant: int | None) -> None:
    if variant is not None:
        click.echo(compilation_time(variant))
        return
    table = Table("", "dimension", "particles", "first process [s]", "second process [s]")
    for number, (dimension, solver, particles, *material) in enumerate(VARIANTS):
        with tempfile.TemporaryDirectory() as cache:
            seconds = [f"{in_a_process(number, cache):.1f}" for _ in range(2)]
        table.add_row(f"{solver.name}{', neo-Hookean' if material else ''}", str(dimension), f"{particles:,.0f}", *seconds)
    Console().print(table)


if __name__ == "__main__":
    main()

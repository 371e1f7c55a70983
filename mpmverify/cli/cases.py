"""What a case asks of a solver, in a few lines: its problem, how far it strains and moves a body, and its levels."""

import math
from collections.abc import Iterator

import numpy as np

from mpmverify.dataset.statement import statement
from mpmverify.errors import UsageError
from mpmverify.problem import Spatial, Transport
from mpmverify.problem.particles import place_particles
from mpmverify.study import Case

SAMPLES = 9
"""Number of times, from the start to the end, at which the largest strain and displacement are looked for."""

MOST_POINTS = 100_000
"""Largest number of material points of a coarsest level at which they are looked for."""
SMALL = 0.02
"""Displacement gradient below which what differs by its square, or the stress by it, is hidden by the errors of most levels."""


def described(case: Case) -> Iterator[tuple[str, str]]:
    """Yield what is to be known of a case before a solver is put on it, each with its name."""
    problem, facts = case.problem.problem, statement(case.problem.problem)
    faces = {name.removeprefix("face "): value for name, value in facts.items() if name.startswith("face ")}
    yield "domain", facts["domain"] + (f", body: {facts['body']}" if "body" in facts else "")
    yield "material", facts["material"]
    for condition in dict.fromkeys(faces.values()):
        yield "faces", f"{', '.join(face for face, value in faces.items() if value == condition)}: {condition}"
    if not isinstance(problem.material, Transport):
        yield from _motion(case)
        started = sorted(quantity.replace("_", " ") for quantity in problem.initial)
        yield "starts with", ", ".join(started) or "nothing: at rest"
        force = problem.body_force
        yield "body force", "none" if force is None else "at positions" if isinstance(force, Spatial) else "at material points"
    yield "fields", ", ".join(quantity.replace("_", " ") for quantity in case.problem.exact.fields)
    try:
        case.converging()
        ladder = case.ladder_in_h()
    except UsageError:
        yield "your code", "cannot be judged here by what it declares: give criteria and levels"
    else:
        sizes = ", ".join(f"{level.h:.4g}" for level in ladder.tier("quick") or ladder.levels)
        yield "levels", f"{ladder.label}: h = {sizes} m; norm {case.norm}"
    yield "exposes", case.problem.exposes


def _motion(case: Case) -> Iterator[tuple[str, str]]:
    """Yield the largest displacement gradient and displacement of the material points."""
    problem, fields = case.problem.problem, case.problem.exact.fields
    ladders = [case.ladder] if case.ladder else [series.refinement for series in case.series]
    levels = [level for ladder in ladders[:1] for level in ladder.tier("quick") or ladder.levels]
    if not levels:
        return
    coarsest, finest = (choose(levels, key=lambda level: level.h) for choose in (max, min))
    count = math.prod(coarsest.cells(problem)) * coarsest.ppc**problem.dimension
    if count > MOST_POINTS:
        yield "strain", f"not looked for: the coarsest level has {count} material points"
        return
    points, times = place_particles(problem, coarsest)[0], np.linspace(0.0, problem.end_time, SAMPLES)
    largest = {}
    for quantity in fields.keys() & {"displacement_gradient", "displacement"}:
        try:
            largest[quantity] = float(np.max(np.abs(fields[quantity](points, times))))
        except Exception as error:  # the closed form may be the user's own
            raise UsageError(f"the exact {quantity} of case {case.name!r} raises {type(error).__name__}: {error}") from error
    if (strain := largest.get("displacement_gradient")) is None:
        yield "strain", "not known: the displacement gradient is no field of the exact solution"
    else:
        yield "strain", f"displacement gradient up to {strain:.2g}"
        if strain < SMALL:
            yield (
                "hardly sees",
                "which measure the stress has, whether volumes change, and products of strains and of rotations",
            )
    if (moved := largest.get("displacement")) is not None:
        yield "moves", f"up to {moved:.2g} m, which is {moved / finest.h:.2g} cells of the finest level"

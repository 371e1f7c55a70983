"""What a solver returns, held against the contract of `Solution`."""

import dataclasses
import math
import textwrap
from numbers import Real
from typing import Any

import numpy as np

from mpmverify.problem import Discretisation, Problem
from mpmverify.problem.quantities import components, history_units
from mpmverify.solution import Outcome, Solution, Status

LEAST_OUTPUTS = 4
"""Intervals between outputs without which the largest error over them says nothing of a run."""


def lacking(solver: Any) -> list[str]:
    """Return the attributes of the protocol `Solver` that an object lacks."""
    return [part for part in ("name", "orders", "conserves", "solve") if not hasattr(solver, part)]


def malformed(solution: Any, dimension: int) -> str:
    """Say why what a solver returned for a problem of some dimension has not the form of a `Solution`; "" when it has."""
    if not isinstance(solution, Solution):
        return f"it returned {type(solution).__name__} instead of a Solution"
    if wrong := solution.inconsistency():
        return f"it returned an inconsistent solution: {wrong}"
    if solution.reference.shape[1] != dimension:
        return f"its points have {solution.reference.shape[1]} coordinates in {dimension} dimensions"
    known = history_units(dimension)
    if unknown := sorted(solution.histories.keys() - known.keys()):
        return f"it returned the unknown history {unknown[0]!r}: known are {', '.join(known)}"
    for quantity, values in solution.fields.items():
        names = components(quantity, dimension)
        if values.shape[2] != len(names):
            return f"its {quantity} has {values.shape[2]} components instead of {', '.join(names)}"
    if not (_is_number(solution.dt) and math.isfinite(solution.dt) and solution.dt > 0):
        return f"its time step dt is {solution.dt!r}, which is not positive and finite"
    for name, value in dataclasses.asdict(solution.work).items():
        if not (_is_number(value) and math.isfinite(value) and value >= 0):
            return f"its work has {name} = {value!r}, which must be finite and not negative"
    return ""


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool | np.bool_)


def breach(solution: Solution, problem: Problem, level: Discretisation) -> str:
    """Say how a completed solution, finite and of the right form, breaks the contract of `Solution`; "" when it keeps it."""
    if not solution.outcome.completed:
        return ""
    end = problem.end_time
    if solution.dt * problem.material.wave_speed > level.courant * level.h * (1 + 1e-6):
        limit = level.courant * level.h / problem.material.wave_speed
        return f"its time step is {solution.dt:.9g} s, above the limit of {limit:.9g} s at the Courant number {level.courant:g}"
    for what, times in (("output", solution.time), ("history", solution.histories["time"])):
        if times[0] != 0:
            return f"its first {what} is at {times[0]:g} s instead of 0"
        if not np.all(np.diff(times) > 0):
            return f"its {what} times do not rise strictly"
        if abs(times[-1] - end) > 1e-9 * end:
            return f"it reports completion, but its last {what} is at {times[-1]:.12g} s and the final time is {end:.12g} s"
    asked = min(len(solution.histories["time"]) - 1, problem.outputs)
    needed = min(asked, LEAST_OUTPUTS)
    if len(solution.time) < needed + 1:
        return f"it returned {len(solution.time)} outputs: the problem asks for {asked + 1}, and {needed + 1} are needed"
    if needed and (gap := float(np.max(np.diff(solution.time)))) > 2 * (1 + 1e-6) * end / needed:
        return f"its outputs leave out {gap:.6g} s: the problem asks for one every {end / asked:.6g} s"
    if np.any(solution.weight < 0):
        return f"its weights are negative, down to {np.min(solution.weight):g}"
    covered, measure = float(np.sum(solution.weight[0])), problem.measure
    if abs(covered - measure) > 1e-6 * measure:
        what = "box" if problem.shape is None else "body"
        return f"its first weights sum to {covered:.9g}, and the measure of the {what} is {measure:.9g}"
    return ""


def confirmed(solution: Solution) -> Outcome:
    """Outcome of a solution; a run that the solver reports as completed is non-finite when one of its arrays is."""
    outcome = solution.outcome
    bad = [name for name, values in solution.arrays().items() if not np.all(np.isfinite(values))]
    if outcome.completed and bad:
        detail = f"the solver reports completion, but {bad[0]} is not finite{_since(solution, bad[0])}"
        return Outcome(Status.NON_FINITE, detail)
    return Outcome(outcome.status, plain(outcome.detail), plain(outcome.advice))


def _since(solution: Solution, name: str) -> str:
    """Say from when on an array of a solution is not finite; "" if it has no time, or its times are not finite either."""
    values = solution.arrays()[name]
    time = solution.histories["time"] if name.startswith("history of ") else solution.time
    if name in ("time", "history of time", "reference") or not np.all(np.isfinite(time)):
        return ""
    broken = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
    return f" from t = {time[np.argmax(broken)]:.4g} s on"


def plain(text: str) -> str:
    """One line that every file format and every terminal takes."""
    encodable = text.encode("utf-8", "replace").decode()
    return textwrap.shorten("".join(char for char in encodable if char.isprintable() or char.isspace()), 500)

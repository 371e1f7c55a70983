"""The statement of a problem in a few words: what a reader needs beside its equations."""

import dataclasses
import re
from typing import Any

from mpmverify.problem import BoundaryCondition, Constant, Problem, Traction, Velocity

SYMBOLS = {
    "youngs_modulus": ("E", "Pa"),
    "density": ("ρ", "kg/m³"),
    "poissons_ratio": ("ν", ""),
    "velocity": ("a", "m/s"),
}
"""Symbol and unit of the parameters of a material."""
NAMES = {"NeoHookean": "neo-Hookean"}
"""Names of classes that are not their words in lower case."""
DATUM: dict[type[BoundaryCondition], str] = {Traction: "Pa", Velocity: "m/s"}
"""Unit of what a condition prescribes."""


def statement(problem: Problem) -> dict[str, str]:
    """Domain, material, final time, boundary conditions and the body that does not fill its domain, by name."""
    facts = {
        "domain": " x ".join(f"[{lo:g}, {hi:g}] m" for lo, hi in zip(problem.lower, problem.upper, strict=True)),
        "material": _value(problem.material),
        "wave speed": f"{problem.material.wave_speed:g} m/s",
        "final time": f"{problem.end_time:g} s",
        **({} if problem.shape is None else {"body": " and ".join(map(_value, problem.shape.bodies))}),
    }
    return facts | {f"face {face}": _condition(problem.boundary[face]) for face in sorted(problem.boundary, key=_along)}


def _along(face: str) -> tuple[str, bool]:
    """Order of the faces: "x-", "x+", "y-", ..."""
    return face[:-1], face.endswith("+")


def _condition(condition: BoundaryCondition) -> str:
    """Return "periodic", "velocity 0 m/s" or "traction [Pa]: ramp load, amplitude = 1e-06, duration = 0.3"."""
    datum = getattr(condition, "value", None)
    if datum is None:
        return _value(condition)
    unit = DATUM.get(type(condition), "")
    if isinstance(datum, Constant):
        return f"{_name(condition)} {_number(datum.value)} {unit}".rstrip()
    return f"{_name(condition)}{f' [{unit}]' if unit else ''}: {_value(datum)}"


def _value(value: Any) -> str:
    """Name of a value with its parameters; of what is no dataclass the name alone."""
    parts = [_name(value)]
    for field in dataclasses.fields(value) if dataclasses.is_dataclass(value) else ():
        symbol, unit = SYMBOLS.get(field.name, (field.name.replace("_", " "), ""))
        parts.append(f"{symbol} = {_number(getattr(value, field.name))} {unit}".rstrip())
    return ", ".join(parts)


def _name(value: Any) -> str:
    name = getattr(value, "__name__", type(value).__name__)
    return NAMES.get(name, re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).lower())


def _number(value: Any) -> str:
    """Four digits of a float, without the sign of a zero; anything else as it prints."""
    return f"{value + 0.0:.4g}" if isinstance(value, float) else str(value)

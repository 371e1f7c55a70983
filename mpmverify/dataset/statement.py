"""Short description of a problem for the report: domain, material, final time and boundary conditions."""

import dataclasses
import re
from typing import Any

from mpmverify.problem import BoundaryCondition, Constant, Problem, Traction, Velocity

SYMBOLS = {
    "youngs_modulus": ("E", "Pa"),
    "density": ("ρ", "kg/m³"),
    "poissons_ratio": ("ν", ""),
    "velocity": ("a", "m/s"),
    "viscosity": ("η", "Pa s"),
    "relaxation_time": ("τ", "s"),
    "second": ("C₂₀", "Pa"),
    "third": ("C₃₀", "Pa"),
}
"""Symbol and unit of the parameters of a material."""
NAMES = {"NeoHookean": "neo-Hookean"}
"""Displayed names of classes, where they are not the class name in lower case."""
PRESCRIBED_UNITS: dict[type[BoundaryCondition], str] = {Traction: "Pa", Velocity: "m/s"}
"""Unit of the value that a boundary condition prescribes."""


def statement(problem: Problem) -> dict[str, str]:
    """Return the domain, material, wave speed, final time, body (if it does not fill the domain) and boundary conditions by name."""
    facts = {
        "domain": " x ".join(f"[{lo:g}, {hi:g}] m" for lo, hi in zip(problem.lower, problem.upper, strict=True)),
        "material": _value(problem.material),
        "wave speed": f"{problem.material.wave_speed:g} m/s",
        "final time": f"{problem.end_time:g} s",
        **({} if problem.shape is None else {"body": " and ".join(map(_value, problem.shape.bodies))}),
    }
    return facts | {f"face {face}": _condition(problem.boundary[face]) for face in sorted(problem.boundary, key=_along)}


def _along(face: str) -> tuple[str, bool]:
    """Sort key for the faces: "x-", "x+", "y-", ..."""
    return face[:-1], face.endswith("+")


def _condition(condition: BoundaryCondition) -> str:
    """Return "periodic", "velocity 0 m/s" or "traction [Pa]: ramp load, amplitude = 1e-06, duration = 0.3"."""
    prescribed = getattr(condition, "value", None)
    if prescribed is None:
        return _value(condition)
    unit = PRESCRIBED_UNITS.get(type(condition), "")
    if isinstance(prescribed, Constant):
        return f"{_name(condition)} {_number(prescribed.value)} {unit}".rstrip()
    return f"{_name(condition)}{f' [{unit}]' if unit else ''}: {_value(prescribed)}"


def _value(value: Any) -> str:
    """Return the name of a value and, if it is a dataclass, its parameters."""
    parts = [_name(value)]
    for field in dataclasses.fields(value) if dataclasses.is_dataclass(value) else ():
        symbol, unit = SYMBOLS.get(field.name, (field.name.replace("_", " "), ""))
        parts.append(f"{symbol} = {_number(getattr(value, field.name))} {unit}".rstrip())
    return ", ".join(parts)


def _name(value: Any) -> str:
    name = getattr(value, "__name__", type(value).__name__)
    return NAMES.get(name, re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).lower())


def _number(value: Any) -> str:
    """Return a float with four digits and without the sign of zero; anything else as `str` gives it."""
    return f"{value + 0.0:.4g}" if isinstance(value, float) else str(value)

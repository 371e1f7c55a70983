"""Quantities that a solver returns: their units and their components in one, two and three dimensions."""

from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UNITS: Mapping[str, str] = {
    "u": "1",
    "displacement": "m",
    "velocity": "m s-1",
    "stress": "Pa",
    "displacement_gradient": "1",
}
"""Unit of every field that a solver may return (UDUNITS spelling)."""

SYMMETRIC: Mapping[int, tuple[str, ...]] = {2: ("xx", "yy", "xy"), 3: ("xx", "yy", "zz", "xy", "yz", "zx")}
"""Order of the independent components of a symmetric tensor, by dimension."""
VECTORS = ("reference", "position", "displacement", "velocity", "momentum", "impulse")


def components(quantity: str, dimension: int) -> tuple[str, ...]:
    """Return the names of the components of a field or history, in their order.

    Parameters
    ----------
    quantity : str
        A name in `VECTORS` is a vector; "stress" is a symmetric tensor, in plane strain without its out-of-plane component;
        "displacement_gradient" is the tensor du_i/dX_j, row by row; "angular_momentum" is a vector in three dimensions and a scalar
        in two; every other quantity is a scalar.
    dimension : {1, 2, 3}
        Dimension of the body.

    Returns
    -------
    tuple of str
        In two dimensions ("velocity_x", "velocity_y") or ("stress_xx", "stress_yy", "stress_xy"); the quantity's own name if it has
        one component.
    """
    axes = "xyz"[:dimension]
    if dimension == 1:
        return (quantity,)
    if quantity in VECTORS or (quantity == "angular_momentum" and dimension == 3):
        return tuple(f"{quantity}_{axis}" for axis in axes)
    if quantity == "stress":
        return tuple(f"{quantity}_{pair}" for pair in SYMMETRIC[dimension])
    if quantity == "displacement_gradient":
        return tuple(f"{quantity}_{row}{column}" for row, column in product(axes, repeat=2))
    return (quantity,)


def multiplicity(quantity: str, dimension: int) -> Array:
    """Return how often each component occurs in the full tensor, (components,): 2 for shear components of the stress, else 1."""
    names = components(quantity, dimension)
    twice = quantity == "stress" and dimension > 1
    return np.array([2.0 if twice and name[-1] != name[-2] else 1.0 for name in names])


def unit(base: str, metres: int, rest: str = "") -> str:
    """Join a unit from its parts: ("kg", -1, "s-1") gives "kg m-1 s-1"."""
    length = "" if metres == 0 else "m" if metres == 1 else f"m{metres}"
    return " ".join(part for part in (base, length, rest) if part)


def history_units(dimension: int, *, transported: bool = False) -> dict[str, str]:
    """Return the units of all histories that a solver may return, by the names of their components.

    Histories of a body are per unit cross-section in one dimension, per unit thickness in two and of the whole body in three. For a
    `transported` scalar u [1], the mass is the integral of u over the box.
    """
    power = dimension - 3
    table = {
        "time": "s",
        "mass": unit("", dimension) if transported else unit("kg", power),
        "momentum": unit("kg", power + 1, "s-1"),
        "impulse": unit("kg", power + 1, "s-1"),
        "kinetic_energy": unit("J", power),
        "strain_energy": unit("J", power),
        "external_work": unit("J", power),
        "dissipated_energy": unit("J", power),
        "inflow": unit("", dimension),
    }
    if dimension > 1:
        table["angular_momentum"] = unit("kg", power + 2, "s-1")
    return {name: units for history, units in table.items() for name in components(history, dimension)}

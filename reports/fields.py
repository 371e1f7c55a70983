"""Quantities of fields in two and three dimensions, and the scales of their colours."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .record import Array, Field

NOISE = 1e-6
"""Share of the largest component of a group, such as the stress, below which a component counts as zero."""
REACH = 10.0
"""Multiple of the size of a group at which errors are cut off: one point that has left the body would coarsen all the others."""
Product = Callable[[Mapping[str, Array], Mapping[str, Array]], Array]


@dataclass(frozen=True)
class Quantity:
    """A component of a field, or a scalar made of its components.

    Parameters
    ----------
    key : str
        Name in the data of the page: "stress_xy", "displacement_magnitude", "stress_mises".
    name : str
        Name for readers.
    group : str
        The stored quantity: "stress".
    units : str
        UDUNITS spelling.
    numerical : Array
        Numerical field (T, P).
    exact, error : Array or None
        Exact field and numerical minus exact field (T, P); None if no exact field is known.
    """

    key: str
    name: str
    group: str
    units: str
    numerical: Array
    exact: Array | None
    error: Array | None


@dataclass(frozen=True)
class Scale:
    """Scale of colours, in the unit of the quantity.

    Parameters
    ----------
    low, high : float
        Values at the ends; both zero if all fields of the group vanish.
    signed : bool
        Whether the ends are opposite, and the colours diverge from zero.
    """

    low: float
    high: float
    signed: bool


def quantities(field: Field) -> tuple[Quantity, ...]:
    """Return the quantities of a field: magnitude and components of each vector, von Mises and components of the stress."""
    groups: dict[str, list[str]] = {}
    for name in field.numerical:
        groups.setdefault(group_of(name), []).append(name)
    table: list[Quantity] = []
    for group, names in groups.items():
        suffixes = {name: name.removeprefix(group).strip("_") for name in names}
        if set(suffixes.values()) == set("xyz"[: field.dimension]):
            table.append(_norm(field, group, suffixes, _dot, "magnitude", f"{group} magnitude"))
        elif {"xx", "yy", "xy"} <= set(suffixes.values()) and group == "stress":
            assumed = "" if "zz" in suffixes.values() else " (σzz taken as 0)"
            table.append(_norm(field, group, suffixes, mises_product, "mises", f"von Mises stress{assumed}"))
        for name in names:
            shown = name.replace("_", " ")
            exact, error = field.exact.get(name), field.error.get(name)
            table.append(Quantity(name, shown, group, field.units[name], field.numerical[name], exact, error))
    return tuple(table)


def group_of(component: str) -> str:
    """Return the quantity of a component: "stress" of "stress_xy"."""
    return re.sub(r"_[xyz]{1,2}$", "", component)


def _dot(left: Mapping[str, Array], right: Mapping[str, Array]) -> Array:
    products: Array = np.sum([left[name] * right[name] for name in left], axis=0)
    return products


def mises_product(left: Mapping[str, Array], right: Mapping[str, Array]) -> Array:
    """Return the bilinear form whose root, for equal arguments, is the von Mises stress.

    Parameters
    ----------
    left, right : mapping of str to Array
        Components of two symmetric tensors by suffix, "xx" to "zx" [Pa]. A component that is not given is zero.

    Returns
    -------
    Array
        (a_xx - a_yy)(b_xx - b_yy)/2 + (a_yy - a_zz)(b_yy - b_zz)/2 + (a_zz - a_xx)(b_zz - b_xx)/2 + 3 (a_xy b_xy + a_yz b_yz + a_zx b_zx)
        [Pa²].
    """
    none = np.zeros_like(left["xx"])

    def part(tensor: Mapping[str, Array], name: str) -> Array:
        return tensor.get(name, none)

    axes = ("xx", "yy", "zz", "xx")
    normal = [(part(left, i) - part(left, j)) * (part(right, i) - part(right, j)) for i, j in pairwise(axes)]
    shear = [part(left, name) * part(right, name) for name in ("xy", "yz", "zx")]
    form: Array = np.sum(normal, axis=0) / 2 + 3 * np.sum(shear, axis=0)
    return form


def _norm(field: Field, group: str, suffixes: Mapping[str, str], product: Product, key: str, shown: str) -> Quantity:
    """Return the root of a bilinear form of the components.

    Notes
    -----
    With B for the form, e for the exact field and d for its error, the error of the root is
    (2 B(e, d) + B(d, d)) / (√B(e + d, e + d) + √B(e, e)), which keeps the digits that the difference of the roots would lose.
    """
    names = list(suffixes)
    units = field.units[names[0]]

    def parts(fields: Mapping[str, Array]) -> dict[str, Array]:
        return {suffixes[name]: fields[name] for name in names}

    with np.errstate(over="ignore", invalid="ignore"):  # of an unstable run
        numerical = np.sqrt(product(parts(field.numerical), parts(field.numerical)))
        exact = error = None
        if all(name in field.exact for name in names):
            known, off = parts(field.exact), parts(field.error)
            exact = np.sqrt(product(known, known))
            total = numerical + exact
            error = (2 * product(known, off) + product(off, off)) / np.where(total == 0, 1.0, total)
    return Quantity(f"{group}_{key}", shown, group, units, numerical, exact, error)


def size_of_group(name: str, quantities: Sequence[Quantity]) -> float:
    """Return the size of the fields of one group: the largest exact value, or what nine tenths of the numerical values stay below.

    The latter counts where the exact field vanishes; a few points that have left the body do not change it.
    """
    group = [entry for entry in quantities if entry.group == name]
    peaks = [_peak(entry.exact) for entry in group if entry.exact is not None]
    sizes = [np.abs(entry.numerical[np.isfinite(entry.numerical)]) for entry in group]
    return max([*peaks, *(float(np.quantile(entry, 0.9)) for entry in sizes if entry.size)], default=0.0)


def _peak(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if finite.size else 0.0


def scale(quantity: Quantity, group_size: float) -> Scale:
    """Return the scale of a quantity over all its times and points.

    The numerical field is followed beyond either end of the exact range by half of it or a tenth of `group_size`, and up to
    `group_size` where the exact field vanishes. Round-off of a component that vanishes is shown on the scale of its group; a
    uniform value on a scale from zero.
    """
    numerical = quantity.numerical[np.isfinite(quantity.numerical)]
    known = numerical if quantity.exact is None else quantity.exact[np.isfinite(quantity.exact)]
    floor = NOISE * group_size
    if _peak(known) > floor:
        low, high = float(known.min()), float(known.max())
        room = max((high - low) / 2, 0.1 * group_size)
        inside = np.append(numerical.clip(low - room, high + room), (low, high))
    else:
        inside = np.append(numerical.clip(-group_size, group_size), 0.0)
    low, high = float(inside.min()), float(inside.max())
    largest = max(-low, high)
    if largest <= floor:
        positive = quantity.key.endswith(("magnitude", "mises"))
        return Scale(0.0 if positive else -group_size, group_size, not positive)
    if high - low <= floor:
        return Scale(min(low, 0.0), max(high, 0.0), False)
    if min(-low, high) > 0.05 * largest:
        return Scale(-largest, largest, True)
    return Scale(low, high, False)


def telling(quantity: Quantity, rows: NDArray[np.intp]) -> int:
    """Return the place in `rows` of the last output, or of the largest exact value where the exact field has nearly vanished then."""
    known = quantity.numerical if quantity.exact is None else quantity.exact
    peaks = [_peak(known[row]) for row in rows]
    return len(peaks) - 1 if peaks[-1] > 0.05 * max(peaks) else int(np.argmax(peaks))


def held_error(quantity: Quantity, group_size: float) -> Array:
    """Return the error (T, P), cut off at `REACH` times the size of its group; not a number where no exact field is known."""
    if quantity.error is None:
        return np.full_like(quantity.numerical, np.nan)
    finite = np.where(np.isinf(quantity.error), np.nan, quantity.error)
    limit = REACH * group_size
    return finite.clip(-limit, limit) if limit > 0 else finite

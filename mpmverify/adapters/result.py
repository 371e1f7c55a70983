"""What a code outside Python returns: files of a run, read into a `Solution`."""

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from mpmverify.adapters.deck import Deck
from mpmverify.adapters.formats import read_file, wrong
from mpmverify.problem import Array, components
from mpmverify.problem.quantities import SYMMETRIC, UNITS, VECTORS, history_units
from mpmverify.solution import Solution, Work

SHORT = {"t": "time", "V": "weight", "volume": "weight"}
"""Short names of columns beside those of vectors and tensors, see `short_names`."""


def read_result(
    folder: Path, result: str, histories: str, columns: Mapping[str, str], deck: Deck, seconds: float = 0.0
) -> Solution:
    """Read the result of a run.

    Parameters
    ----------
    folder : Path
    result : str
        Name of the file with all output times, or a pattern of the files of one each.
    histories : str
        Name of a file with a column "time" and one for each history; "" for none.
    columns : mapping of str to str
        Names of columns or arrays in the files -> names of components, such as "velocity_x".
    deck : Deck
        The run that the code was given. Reference positions, weights, times and steps are those of the deck unless the files have
        others.
    seconds : float
        Wall time of the program [s].

    Raises
    ------
    RunError
        If a file is not there, cannot be read, or does not hold what a `Solution` needs.
    """
    files = sorted(folder.glob(result), key=_numbered)
    if not files or (histories and not (folder / histories).is_file()):
        raise wrong(f"there is no file {histories if files else result!r}")
    dimension = deck.problem.dimension
    names = [*_components(deck), *history_units(dimension)]
    if wrongly := [name for name in columns.values() if name not in names]:
        raise wrong(f"`columns` names {wrongly[0]!r}, which is none of {', '.join(names)}")
    known = short_names(deck) | dict(columns) | {name: name for name in _components(deck)}
    parts = [_renamed(read_file(path, dimension), known) for path in files]
    steps, dt = deck.steps
    sums = {"time": np.asarray(dt * np.arange(steps + 1), dtype=np.float64)}
    if histories:
        known = {"t": "time"} | dict(columns) | {name: name for name in history_units(dimension)}
        sums = {name: values.ravel() for name, values in _renamed(read_file(folder / histories, dimension), known).items()}
        if "time" not in sums:
            raise wrong(f"{histories!r} has no column 'time'")
    return _assembled(parts[0] if len(parts) == 1 else _joined(parts), sums, deck, seconds)


def _numbered(path: Path) -> list[tuple[int, str]]:
    """Key that sorts out2 before out10."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _renamed(found: Mapping[str, Array], known: Mapping[str, str]) -> dict[str, Array]:
    """Arrays by the names of their components; those of no component are left out."""
    table: dict[str, Array] = {}
    for name, values in found.items():
        if name in known:
            if known[name] in table:
                raise wrong(f"the result has two columns of {known[name]}: remove {name!r}")
            table[known[name]] = values
        elif near := get_close_matches(name.lower(), [*known, *UNITS, *VECTORS], 1, 0.85):
            raise wrong(f"the result has a column {name!r}: is it {near[0]!r}? Rename it, or name it in `columns`")
    return table


def _components(deck: Deck) -> list[str]:
    """Names of all components that a result may hold."""
    quantities = ("time", "point", "weight", "reference", "position", *deck.quantities)
    return [name for quantity in quantities for name in components(quantity, deck.problem.dimension)]


def short_names(deck: Deck) -> dict[str, str]:
    """Return the short names of columns: x is a position, X a reference position, ux, vx, sxx as usual; in one dimension also u, v, s."""
    dimension = deck.problem.dimension
    names = dict(SHORT)
    letters = {"reference": "XYZ", "position": "xyz", "velocity": [f"v{axis}" for axis in "xyz"]}
    if "u" not in deck.quantities:
        letters["displacement"] = [f"u{axis}" for axis in "xyz"]
        pairs = SYMMETRIC.get(dimension, ("xx",))
        letters["stress"] = [f"s{pair}" for pair in pairs]
        names |= {"u": "displacement", "v": "velocity", "s": "stress"} if dimension == 1 else {}
    for quantity, short in letters.items():
        names |= dict(zip(short, components(quantity, dimension), strict=False))
    return names


def _joined(parts: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Arrays over all output times, of which each file holds one."""
    names = set(parts[0])
    if any(set(part) != names or any(np.size(part[name]) != np.size(parts[0][name]) for name in names) for part in parts):
        raise wrong("the files of the result do not hold the same arrays, of the same length")
    return {name: np.stack([part[name].ravel() for part in parts]) for name in parts[0]}


def _assembled(values: dict[str, Array], histories: dict[str, Array], deck: Deck, seconds: float) -> Solution:
    dimension, (X, weight) = deck.problem.dimension, deck.sample
    time, values = _by_output(values, deck)
    fields = {}
    for quantity in deck.quantities:
        parts = components(quantity, dimension)
        if missing := [part for part in parts if part not in values]:
            if len(missing) < len(parts):
                raise wrong(f"the result lacks {missing[0]}, and has other components of the {quantity}")
            continue
        fields[quantity] = np.stack([values[part] for part in parts], axis=-1)

    if not fields and not any(part in values for part in components("position", dimension)):
        raise wrong(f"the result has none of {', '.join(deck.quantities)}, and no positions")

    def vector(name: str) -> Array | None:
        parts = components(name, dimension)
        return np.stack([values[part] for part in parts], axis=-1) if all(part in values for part in parts) else None

    count = next((len(array[0]) for array in values.values()), 0)
    reference, position = vector("reference"), vector("position")
    if reference is not None:
        if np.any(reference != reference[0]):
            raise wrong("the reference positions of the result differ between output times")
        reference = reference[0]
    elif count == len(X):
        reference = X
    else:
        raise wrong(
            f"the result has {count} points, the problem {len(X)}: is it that of another level? Points of your own need reference positions, "
            f"{', '.join('XYZ'[:dimension])}"
        )
    if position is None:
        position = reference + fields["displacement"] if "displacement" in fields else np.tile(reference, (len(time), 1, 1))
    elif "displacement" in deck.quantities and "displacement" not in fields:
        fields["displacement"] = position - reference
    if "weight" not in values and count != len(X):
        raise wrong(f"the result has {count} points, the problem {len(X)}: add the volume of each as 'weight'")
    weights = values["weight"] if "weight" in values else np.tile(weight, (len(time), 1))
    steps, dt = deck.steps
    if len(histories["time"]) > 1 and len(histories["time"]) != steps + 1:
        steps, dt = len(histories["time"]) - 1, float(np.max(np.diff(histories["time"])))
    work = Work(steps, steps * count, seconds)
    return Solution(time, dt, reference, position, weights, fields, histories, work)


def _by_output(values: dict[str, Array], deck: Deck) -> tuple[Array, dict[str, Array]]:
    """Output times (T,) and arrays (T, P), from arrays (T, P) or from columns in which the outputs follow each other."""
    values = dict(values)
    shapes = {array.shape for name, array in values.items() if name != "time" and array.ndim == 2}
    if shapes:
        time = values.pop("time", None)
        if len(shapes) > 1:
            raise wrong(f"the arrays of the result have different shapes, {', '.join(map(str, sorted(shapes)))}")
        outputs, points = next(iter(shapes))
        values = {name: array if array.ndim == 2 else _repeated(name, array, outputs, points) for name, array in values.items()}
        if time is not None:
            time = time[:, 0] if time.ndim == 2 else time
    elif "time" in values:
        column = values.pop("time")
        starts = np.r_[0, np.flatnonzero(np.diff(column)) + 1]
        lengths = np.diff(np.r_[starts, len(column)])
        if len(set(lengths.tolist())) != 1:
            least, most = lengths.min(), lengths.max()
            raise wrong(f"the result has {least} rows at one output time and {most} at another: give every point at each")
        time, outputs = column[starts], len(starts)
        values = {name: array.reshape(outputs, -1) for name, array in values.items()}
    else:
        rows, outputs, time = len(next(iter(values.values()), [])), len(deck.output_times), None
        if rows != outputs * len(deck.sample[0]):
            raise wrong(
                f"the result has no column 'time', and {rows} rows are not those of {len(deck.sample[0])} points at {outputs} times"
            )
        values = {name: array.reshape(outputs, -1) for name, array in values.items()}
    if time is None:
        time = deck.output_times
    if len(time) != outputs:
        raise wrong(f"the result has {outputs} outputs and {len(time)} output times")
    if (order := values.pop("point", None)) is not None:
        sorting = np.argsort(order, axis=1, kind="stable")
        numbers = np.take_along_axis(order, sorting, axis=1)
        if np.any(numbers != numbers[0]) or np.any(np.diff(numbers[0]) <= 0):
            raise wrong("the numbers of the points differ between output times, or one stands for two points")
        values = {name: np.take_along_axis(array, sorting, axis=1) for name, array in values.items()}
    return np.asarray(time, dtype=float), values


def _repeated(name: str, array: Array, outputs: int, points: int) -> Array:
    if array.shape != (points,):
        raise wrong(f"{name} of the result has the shape {array.shape} beside {outputs} outputs and {points} points")
    return np.tile(array, (outputs, 1))

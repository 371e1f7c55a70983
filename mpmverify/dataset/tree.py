"""Writing of the groups of a netCDF file, and reading of them.

Notes
-----
Texts are stored as arrays of characters, because the netCDF library kills a process that has a file with variable-length strings open
twice (Unidata/netcdf4-python#1444, pydata/xarray#9093). All variables are declared before the first value is written; xarray's own
writer alternates and takes ten times as long for a tree of fifty groups.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np

from mpmverify.dataset.files import compression

CHECKSUM = "checksum"
"""Attribute with the digest of a file."""
ENCODING = "_Encoding"
"""Attribute of a text: the encoding of its characters."""
COORDINATES = "coordinates"
"""Attribute with the names of coordinates, by CF."""


class Variable(NamedTuple):
    """A variable of a file: its dimensions, its numbers or texts (an array of str), and its attributes."""

    dimensions: tuple[str, ...]
    values: np.ndarray
    attributes: Mapping[str, Any]


def variable(dimensions: str | tuple[str, ...], values: Any, attributes: Mapping[str, Any] | None = None) -> Variable:
    """Return a variable; of one dimension, the name is enough."""
    along = (dimensions,) if isinstance(dimensions, str) else dimensions
    return Variable(along, np.asarray(values), attributes or {})


def text(values: Sequence[Any]) -> np.ndarray:
    """Return texts as an array (n,) of str, also if it is empty."""
    return np.array(list(values), dtype=str)


@dataclass(frozen=True)
class Group:
    """A group of a file, as it is written and as it is read.

    Parameters
    ----------
    variables : mapping of str to Variable
    coordinates : mapping of str to Variable
        Variables that others refer to by CF's attribute `coordinates`, or that bear the name of their dimension. Of a group that was
        read, they are among `variables`.
    attributes : mapping of str
    """

    variables: Mapping[str, Variable] = field(default_factory=dict)
    coordinates: Mapping[str, Variable] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)

    def joined(self, other: "Group") -> "Group":
        """Return this group with all that another one has."""
        return Group(
            {**self.variables, **other.variables},
            {**self.coordinates, **other.coordinates},
            {**self.attributes, **other.attributes},
        )

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Values of all variables and coordinates by name."""
        return {name: entry.values for name, entry in (*self.variables.items(), *self.coordinates.items())}

    @property
    def units(self) -> dict[str, str]:
        """Units of all variables and coordinates by name; "1" where none are said."""
        every = (*self.variables.items(), *self.coordinates.items())
        return {name: str(entry.attributes.get("units", "1")) for name, entry in every}

    def sizes(self) -> dict[str, int]:
        """Sizes of the dimensions.

        Raises
        ------
        ValueError
            If two variables disagree on one.
        """
        found: dict[str, int] = {}
        for name, (dimensions, values, _) in (*self.variables.items(), *self.coordinates.items()):
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if found.setdefault(dimension, size) != size:
                    raise ValueError(f"{name} has {size} values along {dimension}, where others have {found[dimension]}")
        return found


def write_groups(path: Path, groups: Mapping[str, Group]) -> str:
    """Write groups by their path with a checksum, and return it.

    `xarray.open_datatree` reads them with their coordinates, texts and attributes.
    """
    with netCDF4.Dataset(path, "w") as file:
        pending: list[tuple[netCDF4.Variable, np.ndarray]] = []
        for place, content in groups.items():
            pending += _declare(file if place == "/" else file.createGroup(place), content)
        written: dict[tuple[str, str], np.ndarray] = {}
        for stored, values in pending:
            stored[...] = values
            written[stored.group().path, stored.name] = values
        digest = _digest(_stored(file, written))
        file.setncattr(CHECKSUM, digest)
    return digest


def read_groups(file: netCDF4.Dataset) -> tuple[str, dict[str, Group]]:
    """Read all that a file holds, once.

    Returns
    -------
    str
        Digest of the names, sizes, values and attributes in every group.
    dict of str to Group
        Groups by path. `xarray.open_datatree` opens every group anew, and takes longer.
    """
    found = list(_stored(file, {}))
    return _digest(found), {
        part.path: Group({n: _decoded(v) for n, v in part.variables.items()}, {}, part.attributes) for part in found
    }


class _Stored(NamedTuple):
    """A group as it is stored: texts are characters."""

    path: str
    sizes: list[tuple[str, int]]
    variables: dict[str, Variable]
    attributes: dict[str, Any]


def _stored(group: netCDF4.Dataset, known: Mapping[tuple[str, str], np.ndarray]) -> Iterator[_Stored]:
    """Yield a group and those within; values `known` by the path of their group and their name, which were written, are not read."""
    variables = {}
    for name, entry in group.variables.items():
        values = known.get((group.path, name))
        if values is None:
            entry.set_auto_maskandscale(False)
            entry.set_auto_chartostring(False)
            values = np.ascontiguousarray(entry[...]).reshape(entry.shape)
        variables[name] = Variable(entry.dimensions, values, _attributes(entry))
    yield _Stored(group.path, [(name, len(size)) for name, size in group.dimensions.items()], variables, _attributes(group))
    for inner in group.groups.values():
        yield from _stored(inner, known)


def _attributes(owner: netCDF4.Dataset | netCDF4.Variable) -> dict[str, Any]:
    return {name: owner.getncattr(name) for name in owner.ncattrs()}


def _digest(groups: Iterable[_Stored]) -> str:
    found = hashlib.sha256()

    def add(attributes: Mapping[str, Any]) -> None:
        found.update(repr({n: np.asarray(value).tolist() for n, value in attributes.items() if n != CHECKSUM}).encode())

    for part in groups:
        found.update(repr((part.path, part.sizes)).encode())
        add(part.attributes)
        for name, (dimensions, values, attributes) in part.variables.items():
            add(attributes)
            found.update(repr((name, dimensions)).encode() + values.tobytes())
    return found.hexdigest()


def _decoded(stored: Variable) -> Variable:
    """A stored variable as it was before it was written."""
    dimensions, values, attributes = stored
    if ENCODING not in attributes:
        return stored
    words = values.view(f"S{values.shape[-1]}").reshape(values.shape[:-1])
    rest = {name: value for name, value in attributes.items() if name != ENCODING}
    return Variable(dimensions[:-1], np.char.decode(words, "utf-8"), rest)


def _declare(group: netCDF4.Dataset, content: Group) -> list[tuple[netCDF4.Variable, np.ndarray]]:
    """Declare the dimensions, variables and attributes of one group, and return the variables with the values to write."""
    sizes = content.sizes()
    for name, size in sizes.items():
        group.createDimension(name, size)
    auxiliary = {name: set(entry.dimensions) for name, entry in sorted(content.coordinates.items()) if name not in sizes}
    named: set[str] = set()
    pending = []
    for name, entry in (*content.variables.items(), *content.coordinates.items()):
        stored, values = _variable(group, name, entry)
        attributes = dict(entry.attributes)
        mine = [other for other, along in auxiliary.items() if along <= set(entry.dimensions)]
        if name not in content.coordinates and mine:
            attributes.setdefault(COORDINATES, " ".join(mine))
        named.update(attributes.get(COORDINATES, "").split())
        stored.setncatts(attributes)
        pending.append((stored, values))
    rest = " ".join(name for name in auxiliary if name not in named)
    group.setncatts({**content.attributes, **({COORDINATES: rest} if rest else {})})
    return pending


def _variable(group: netCDF4.Dataset, name: str, entry: Variable) -> tuple[netCDF4.Variable, np.ndarray]:
    dimensions, values, _ = entry
    if values.dtype.kind != "U":
        return group.createVariable(name, values.dtype, dimensions, compression=compression(values.nbytes)), values
    encoded = np.char.encode(values, "utf-8")
    width = max(1, encoded.dtype.itemsize)
    length = f"string{width}"
    if length not in group.dimensions:
        group.createDimension(length, width)
    stored = group.createVariable(name, "S1", [*dimensions, length], compression=compression(encoded.nbytes))
    stored.set_auto_chartostring(False)
    stored.setncattr(ENCODING, "utf-8")
    return stored, np.ascontiguousarray(encoded.astype(f"S{width}")).view("S1").reshape(*values.shape, width)

"""Writing of a DataTree to a netCDF file, and reading of one.

Notes
-----
Texts are stored as arrays of characters, because the netCDF library kills a process that has a file with variable-length strings open
twice (Unidata/netcdf4-python#1444, pydata/xarray#9093). All variables are declared before the first value is written; xarray's own
writer alternates and takes ten times as long for a tree of fifty groups.
"""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import netCDF4
import numpy as np
import xarray as xr

from mpmverify.dataset.files import compression

CHECKSUM = "checksum"
"""Attribute with the digest of a file."""


def write_tree(path: Path, tree: xr.DataTree) -> None:
    """Write a tree with its checksum; `xarray.open_datatree` reads it back with its coordinates, texts and attributes."""
    with netCDF4.Dataset(path, "w") as file:
        pending: list[tuple[netCDF4.Variable, np.ndarray]] = []
        for node in tree.subtree:
            group = file if node.path == "/" else file.createGroup(node.path)
            pending += _declare(group, node.to_dataset(inherit=False))
        written: dict[tuple[str, str], np.ndarray] = {}
        for variable, values in pending:
            variable[...] = values
            written[variable.group().path, variable.name] = values
        file.setncattr(CHECKSUM, read_groups(file, written)[0])


class Group(NamedTuple):
    """A group of a file as it is stored: dimensions, values and attributes of each variable, and the attributes of the group."""

    variables: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, Any]]]
    attributes: dict[str, Any]


def read_groups(
    file: netCDF4.Dataset, known: Mapping[tuple[str, str], np.ndarray] = MappingProxyType({})
) -> tuple[str, dict[str, Group]]:
    """Read all that a file holds, once.

    Parameters
    ----------
    file : netCDF4.Dataset
    known : mapping of (str, str) to ndarray
        Values by the path of their group and the name of their variable, which are not read: of a file that is being written.

    Returns
    -------
    str
        Digest of the names, sizes, values and attributes in every group.
    dict of str to Group
        Groups by path. `xarray.open_datatree` opens every group anew, and takes longer.
    """
    found = hashlib.sha256()
    groups: dict[str, Group] = {}

    def attributes(owner: netCDF4.Dataset | netCDF4.Variable) -> dict[str, Any]:
        stated = {name: owner.getncattr(name) for name in owner.ncattrs()}
        listed = {name: np.asarray(value).tolist() for name, value in stated.items() if name != CHECKSUM}
        found.update(repr(listed).encode())
        return stated

    def add(group: netCDF4.Dataset) -> None:
        found.update(repr((group.path, [(name, len(size)) for name, size in group.dimensions.items()])).encode())
        stored = Group({}, attributes(group))
        for name, variable in group.variables.items():
            stated = attributes(variable)
            values = known.get((group.path, name))
            if values is None:
                variable.set_auto_maskandscale(False)
                variable.set_auto_chartostring(False)
                values = np.ascontiguousarray(variable[...]).reshape(variable.shape)
            found.update(repr((name, variable.dimensions)).encode() + values.tobytes())
            stored.variables[name] = variable.dimensions, values, stated
        groups[group.path] = stored
        for inner in group.groups.values():
            add(inner)

    add(file)
    return found.hexdigest(), groups


def decoded(group: Group) -> xr.Dataset:
    """Return a stored group as it was before it was written: with texts and coordinates."""
    variables = {name: xr.Variable(*stored) for name, stored in group.variables.items()}
    return xr.decode_cf(xr.Dataset(variables, attrs=group.attributes)).load()


def _declare(group: netCDF4.Dataset, dataset: xr.Dataset) -> list[tuple[netCDF4.Variable, np.ndarray]]:
    """Declare the dimensions, variables and attributes of one group, and return the variables with the values to write."""
    for name, size in dataset.sizes.items():
        group.createDimension(str(name), size)
    auxiliary = {str(name) for name in dataset.coords} - {str(name) for name in dataset.sizes}
    named: set[str] = set()
    pending = []
    for name, values in dataset.variables.items():
        variable, content = _variable(group, str(name), values)
        attributes = dict(values.attrs)
        mine = sorted(coord for coord in auxiliary if set(dataset.variables[coord].dims) <= set(values.dims))
        if name not in dataset.coords and mine:
            attributes.setdefault("coordinates", " ".join(mine))
        named.update(attributes.get("coordinates", "").split())
        variable.setncatts(attributes)
        pending.append((variable, content))
    rest = " ".join(sorted(auxiliary - named))
    group.setncatts(dataset.attrs | ({"coordinates": rest} if rest else {}))
    return pending


def _variable(group: netCDF4.Dataset, name: str, values: xr.Variable) -> tuple[netCDF4.Variable, np.ndarray]:
    dimensions = [str(dimension) for dimension in values.dims]
    if values.dtype.kind not in "OU":
        return group.createVariable(name, values.dtype, dimensions, compression=compression(values.nbytes)), values.values
    encoded = np.char.encode(values.values.astype(str), "utf-8")
    width = max(1, encoded.dtype.itemsize)
    length = f"string{width}"
    if length not in group.dimensions:
        group.createDimension(length, width)
    variable = group.createVariable(name, "S1", [*dimensions, length], compression=compression(encoded.nbytes))
    variable.set_auto_chartostring(False)
    variable.setncattr("_Encoding", "utf-8")
    return variable, np.ascontiguousarray(encoded.astype(f"S{width}")).view("S1").reshape(*values.shape, width)


def text(values: Sequence[str]) -> np.ndarray:
    """Return texts as an array (n,) that xarray accepts also if it is empty."""
    return np.array(list(values), dtype=object if len(values) else "U1")

"""Files of numbers from any code, read as arrays by name: tables of text, NPZ, netCDF, VTK and XDMF."""

import contextlib
import io
import itertools
import re
import warnings
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mpmverify.problem import Array, components
from mpmverify.problem.quantities import SYMMETRIC
from mpmverify.solution import RunError, Status

SEPARATOR = re.compile(r"\s*[,;\t]\s*|\s+")
TABLES, MESHES = (".csv", ".txt", ".dat"), (".vtk", ".vtu", ".vtp", ".xdmf", ".xmf")


def wrong(what: str) -> RunError:
    """Return the failure of a run whose result cannot be used."""
    return RunError(Status.CRASHED, what, "let the code write its result as the handbook's page on own programs says")


def read_file(path: Path, dimension: int) -> dict[str, Array]:
    """Return the arrays of a file by name: columns of a table, or components of the arrays of an NPZ, netCDF, VTK or XDMF file.

    Raises
    ------
    RunError
        If it cannot be read.
    """
    readers = dict.fromkeys(TABLES, _read_table) | dict.fromkeys(MESHES, _read_mesh)
    readers |= {".npz": _read_npz, ".nc": _read_netcdf}
    if path.suffix.lower() not in readers:
        raise wrong(f"'{path.name}' has an unknown form: write one of {', '.join(readers)}")
    try:
        return readers[path.suffix.lower()](path, dimension)
    except RunError:
        raise
    except (Exception, SystemExit) as error:  # readers of foreign files raise of every kind
        raise wrong(f"'{path.name}' cannot be read ({error or type(error).__name__})") from error


def _read_table(path: Path, _dimension: int) -> dict[str, Array]:
    """Columns of a table whose first line, with or without "#", names them."""
    with path.open(encoding="utf-8-sig") as lines:
        skipped, first = next(((k, line) for k, line in enumerate(lines) if line.strip()), (0, ""))
    names = [name.strip("\"'") for name in SEPARATOR.split(first.strip().lstrip("#%").strip())]
    if not all(re.match(r"[A-Za-z_]", name) for name in names) or first.strip() == "":
        raise wrong(f"'{path.name}' does not begin with a line of column names")
    separator = next((mark for mark in ",;\t" if mark in first), None)
    with warnings.catch_warnings(action="error"):  # a table without rows
        table = np.loadtxt(path, delimiter=separator, skiprows=skipped + 1, ndmin=2, encoding="utf-8-sig")
    if table.shape[1] != len(names):
        raise wrong(f"'{path.name}' has {len(names)} column names and {table.shape[1]} columns")
    if len(set(names)) < len(names):
        raise wrong(f"'{path.name}' names a column twice")
    return dict(zip(names, table.T, strict=True))


def _read_npz(path: Path, dimension: int) -> dict[str, Array]:
    with contextlib.closing(np.load(path, allow_pickle=False)) as arrays:
        if not zipfile.is_zipfile(path):
            raise wrong(f"'{path.name}' is no NPZ file")
        return _split({name: np.asarray(arrays[name], dtype=float) for name in arrays.files}, dimension)


def _read_netcdf(path: Path, dimension: int) -> dict[str, Array]:
    import netCDF4  # a run without such files does without it

    with netCDF4.Dataset(path) as data:
        arrays = {name: np.ma.filled(variable[:].astype(float), np.nan) for name, variable in data.variables.items()}
    return _split(arrays, dimension)


def _read_mesh(path: Path, dimension: int) -> dict[str, Array]:
    """Point arrays of one output; those of a symmetric tensor are in the order of VTK, xx, yy, zz, xy, yz, xz."""
    try:
        import meshio
    except ImportError as error:
        raise wrong(f"'{path.name}' needs meshio: pip install meshio") from error
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):  # it prints what it cannot read
        mesh = meshio.read(path)
    arrays = {"position": mesh.points} | {name: np.asarray(values, dtype=float) for name, values in mesh.point_data.items()}
    return {name: values[None] for name, values in _split(arrays, dimension, of_mesh=True).items()}


def _split(arrays: Mapping[str, Array], dimension: int, *, of_mesh: bool = False) -> dict[str, Array]:
    """Arrays whose last axis is that of components, as one array for each; of a mesh, those in three dimensions are cut down."""
    found: dict[str, Array] = {}
    for name, values in arrays.items():
        parts = components(name, dimension)
        if of_mesh and values.ndim > 1 and values.shape[-1] in (3, 6, 9):
            values = values[..., _kept(name, values.shape[-1], dimension)]
        # In one dimension (P, 1) is a field of a mesh, or reference positions; any other array (T, P) has no axis of components.
        least = 2 if of_mesh or len(parts) > 1 or name == "reference" else 3
        if values.ndim >= least and values.shape[-1] == len(parts):
            found |= {part: values[..., k] for k, part in enumerate(parts)}
        else:
            found[name] = values
    return found


def _kept(name: str, count: int, dimension: int) -> list[int]:
    """Indices of the components that a vector or tensor of a mesh, always given in three dimensions, has in fewer."""
    axes = range(dimension)
    if count == 3:
        return list(axes)
    if count == 6:
        return {1: [0], 2: [0, 1, 3], 3: list(range(6))}[dimension]
    pairs = [("xyz".index(pair[0]), "xyz".index(pair[1])) for pair in SYMMETRIC.get(dimension, ("xx",))]
    full = name != "stress"
    return [3 * a + b for a, b in (itertools.product(axes, repeat=2) if full else pairs)]

"""Reading and writing of a finished run as one netCDF file."""

from pathlib import Path

import netCDF4
import numpy as np

from mpmverify.atomic import write_atomic
from mpmverify.dataset import provenance
from mpmverify.dataset.files import check_ours
from mpmverify.errors import ResultsError
from mpmverify.problem import Array
from mpmverify.problem.quantities import UNITS, components, history_units, unit
from mpmverify.solution import Outcome, Solution, Status, Work


def write_run(path: Path, key: str, solution: Solution, title: str) -> None:
    """Write a solution; the variables have the meanings given in `Solution`.

    Parameters
    ----------
    path : Path
        File to write. A file that is not an mpmverify run is never overwritten.
    key : str
        Content key of the run.
    solution : Solution
        The solution.
    title : str
        Attribute `title` of the file.

    Raises
    ------
    ResultsError
        If `path` is not an mpmverify run, or the file cannot be written.
    """
    if path.exists():
        check_ours(path, "run")

    def write(temporary: Path) -> None:
        with netCDF4.Dataset(temporary, "w") as file:
            file.setncatts(provenance.attributes("run", title, "Fields and histories of one run of one solver."))
            file.setncatts(
                {
                    "id": key,
                    "status": solution.outcome.status.value,
                    "detail": solution.outcome.detail,
                    "advice": solution.outcome.advice,
                    "dt": solution.dt,
                    "steps": solution.work.steps,
                    "point_steps": solution.work.point_steps,
                    "seconds": solution.work.seconds,
                }
            )
            dimension = solution.reference.shape[1]
            sizes = {
                "time": len(solution.time),
                "point": len(solution.reference),
                "dimension": dimension,
                "step": len(solution.histories["time"]),
            }
            for name, size in sizes.items():
                file.createDimension(name, size)

            # All variables are declared before the first value is written, because alternating is slower in netCDF4.
            pending: list[tuple[netCDF4.Variable, Array]] = []

            def put(name: str, dimensions: tuple[str, ...], values: Array, units: str, long_name: str) -> None:
                variable = file.createVariable(name, "f8", dimensions)
                variable.setncatts({"units": units, "long_name": long_name})
                pending.append((variable, values))

            put("time", ("time",), solution.time, "s", "output time")
            put("reference", ("point", "dimension"), solution.reference, "m", "reference position of the sample points")
            put("position", ("time", "point", "dimension"), solution.position, "m", "current position of the sample points")
            put("weight", ("time", "point"), solution.weight, unit("", dimension), "quadrature weight of the sample points")
            for quantity, values in solution.fields.items():
                along, names = f"{quantity}_component", components(quantity, dimension)
                file.createDimension(along, values.shape[2])
                put(quantity, ("time", "point", along), values, UNITS[quantity], ", ".join(names).replace("_", " "))
            units = history_units(dimension, transported="u" in solution.fields)
            for name, values in solution.histories.items():
                put(f"history_{name}", ("step",), values, units[name], name.replace("_", " "))
            for variable, values in pending:
                variable[...] = values

    write_atomic(path, write)


def read_run(path: Path, key: str) -> Solution:
    """Read a solution.

    Parameters
    ----------
    path : Path
        File of the run.
    key : str
        Content key that the run must have.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, damaged, not an mpmverify run, or a run with another key.
    """
    attributes = check_ours(path, "run")
    if attributes.get("id") != key:
        raise ResultsError(f"'{path}' contains another run, {attributes.get('id')}: delete it")
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            variables = {name: np.asarray(variable[...]) for name, variable in file.variables.items()}
        return Solution(
            time=variables["time"],
            dt=float(attributes["dt"]),
            reference=variables["reference"],
            position=variables["position"],
            weight=variables["weight"],
            fields={name: values for name, values in variables.items() if name in UNITS},
            histories={name.removeprefix("history_"): v for name, v in variables.items() if name.startswith("history_")},
            work=Work(int(attributes["steps"]), int(attributes["point_steps"]), float(attributes["seconds"])),
            outcome=Outcome(Status(attributes["status"]), str(attributes["detail"]), str(attributes["advice"])),
        )
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise ResultsError(f"'{path}' is damaged: delete it and run again") from error

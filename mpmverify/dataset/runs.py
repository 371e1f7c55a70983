"""Reading and writing of a finished run as one netCDF file: what was measured on it, and an excerpt of its fields and histories."""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np

from mpmverify.atomic import write_atomic
from mpmverify.dataset import provenance
from mpmverify.dataset.files import check_ours, compression, damaged, make_way
from mpmverify.problem import Array
from mpmverify.problem.quantities import UNITS, components, history_units, unit
from mpmverify.solution import Outcome, Solution, Status, Work


@dataclass(frozen=True)
class Run:
    """What is kept of a finished run.

    Parameters
    ----------
    solution : Solution
        At the outputs and the samples of the histories that are kept.
    errors : mapping of str to (Array, Array)
        Norms of the error and sizes of the exact field at all outputs by quantity, see `mpmverify.criteria.norms.errors`; empty
        unless the run completed.
    metrics : mapping of str to float
        What the criteria measured on the whole solution.
    shown : bool
        Whether as much is kept as the pages show.
    """

    solution: Solution
    errors: Mapping[str, tuple[Array, Array]]
    metrics: Mapping[str, float]
    shown: bool

    @property
    def measured(self) -> dict[str, str]:
        """The errors and metrics as texts in JSON, which give every number back exactly."""
        errors = {quantity: [norms.tolist() for norms in pair] for quantity, pair in self.errors.items()}
        return {"errors": json.dumps(errors), "metrics": json.dumps({name: float(v) for name, v in self.metrics.items()})}

    def checksum(self, key: str) -> str:
        """Digest of the key and of every number of the run."""
        solution = self.solution
        facts = [key, self.shown, float(solution.dt), self.measured]
        facts += [dataclasses.astuple(part) for part in (solution.work, solution.outcome)]
        total = hashlib.sha256(json.dumps(facts).encode())
        for name, values in solution.arrays().items():
            total.update(f"{name}{values.shape}".encode())
            total.update(np.ascontiguousarray(values, dtype=float).tobytes())
        return total.hexdigest()


def write_run(path: Path, key: str, run: Run, title: str) -> None:
    """Write a run; the variables have the meanings given in `Solution`.

    The position is left out where it is bit for bit the sum of reference position and displacement, or the reference position of a
    solution without displacement.

    Parameters
    ----------
    path : Path
        File to write. A file that is not an mpmverify run is never overwritten.
    key : str
        Content key of the run.
    run : Run
    title : str
        Attribute `title` of the file.

    Raises
    ------
    ResultsError
        If `path` is not an mpmverify run, or the file cannot be written.
    """
    make_way(path, "run")
    solution = run.solution

    def write(temporary: Path) -> None:
        with netCDF4.Dataset(temporary, "w") as file:
            file.setncatts(
                provenance.attributes("run", title, "What was measured on one run of one solver, and some of its fields.")
            )
            file.setncatts(
                {
                    "id": key,
                    "status": solution.outcome.status.value,
                    "detail": solution.outcome.detail,
                    "advice": solution.outcome.advice,
                    "dt": float(solution.dt),
                    "steps": solution.work.steps,
                    "point_steps": solution.work.point_steps,
                    "seconds": solution.work.seconds,
                    "shown": int(run.shown),
                    "checksum": run.checksum(key),
                }
                | run.measured
            )
            dimension = solution.reference.shape[1]
            sizes = {"time": len(solution.time), "point": len(solution.reference), "dimension": dimension}
            if solution.histories:
                sizes["step"] = len(solution.histories["time"])
            for name, size in sizes.items():
                file.createDimension(name, size)

            # All variables are declared before the first value is written, because alternating is slower in netCDF4.
            pending: list[tuple[netCDF4.Variable, Array]] = []

            def put(name: str, dimensions: tuple[str, ...], values: Array, units: str, long_name: str) -> None:
                variable = file.createVariable(name, "f8", dimensions, compression=compression(8 * values.size))
                variable.setncatts({"units": units, "long_name": long_name})
                pending.append((variable, values))

            put("time", ("time",), solution.time, "s", "output time")
            put("reference", ("point", "dimension"), solution.reference, "m", "reference position of the sample points")
            if _position(solution.time, solution.reference, solution.fields).tobytes() != solution.position.tobytes():
                put("position", ("time", "point", "dimension"), solution.position, "m", "current position of the sample points")
            put("weight", ("time", "point"), solution.weight, unit("", dimension), "quadrature weight of the sample points")
            for quantity, values in solution.fields.items():
                along, names = f"component{values.shape[2]}", components(quantity, dimension)
                if along not in file.dimensions:
                    file.createDimension(along, values.shape[2])
                put(quantity, ("time", "point", along), values, UNITS[quantity], ", ".join(names).replace("_", " "))
            units = history_units(dimension, transported="u" in solution.fields)
            for name, values in solution.histories.items():
                put(f"history_{name}", ("step",), values, units[name], name.replace("_", " "))
            for variable, values in pending:
                variable[...] = values

    write_atomic(path, write)


def _position(time: Array, reference: Array, fields: Mapping[str, Array]) -> Array:
    """Position (T, P, dim) [m] that follows from the reference position and the displacement."""
    return reference + fields.get("displacement", np.zeros((len(time), 1, 1)))


def read_run(path: Path, key: str) -> Run:
    """Read a run.

    Parameters
    ----------
    path : Path
        File of the run.
    key : str
        Content key that the run must have.

    Raises
    ------
    DamagedError
        If the file cannot be read, is another run, or does not hold what was written.
    ResultsError
        If the file is missing or was not written as a run by this version.
    """
    attributes = check_ours(path, "run")
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            variables = {name: np.asarray(variable[...]) for name, variable in file.variables.items()}
        fields = {name: values for name, values in variables.items() if name in UNITS}
        time, reference = variables["time"], variables["reference"]
        solution = Solution(
            time=time,
            dt=float(attributes["dt"]),
            reference=reference,
            position=variables["position"] if "position" in variables else _position(time, reference, fields),
            weight=variables["weight"],
            fields=fields,
            histories={name.removeprefix("history_"): v for name, v in variables.items() if name.startswith("history_")},
            work=Work(int(attributes["steps"]), int(attributes["point_steps"]), float(attributes["seconds"])),
            outcome=Outcome(Status(attributes["status"]), str(attributes["detail"]), str(attributes["advice"])),
        )
        errors = {q: (np.array(norms), np.array(sizes)) for q, (norms, sizes) in json.loads(attributes["errors"]).items()}
        run = Run(solution, errors, json.loads(attributes["metrics"]), bool(attributes["shown"]))
        sound = run.checksum(key) == attributes["checksum"]
    except (OSError, RuntimeError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise damaged(path) from error
    if not sound:
        raise damaged(path)
    return run

"""The files that state one run for a code outside Python: `problem.json`, the same in `problem.txt`, and tables of numbers."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mpmverify.adapters.body_force import in_modes
from mpmverify.errors import UsageError
from mpmverify.problem import Array, Discretisation, Problem, Spatial, Transport, components, output_steps, place_particles

FORMAT = "mpmverify problem 1"
POINTS = ("particles", "nodes")
MODULI = ("youngs_modulus", "poissons_ratio", "lame_lambda", "shear_modulus", "viscosity", "relaxation_time", "second", "third")


@dataclass(frozen=True)
class Deck:
    """One run as files state it: a problem, a level and the sample points.

    Parameters
    ----------
    problem : Problem
    level : Discretisation
    points : {"particles", "nodes"}
        Points of the tables: the particles of the level, or the nodes of its cells.

    Raises
    ------
    UsageError
        If nodes are asked for a body that does not fill its box, or the body force depends on current positions.
    """

    problem: Problem
    level: Discretisation
    points: str = "particles"

    def __post_init__(self) -> None:
        name = self.problem.name
        if self.points not in POINTS:
            raise UsageError(f"there are no points {self.points!r}: choose {' or '.join(POINTS)}")
        if self.points == "nodes" and self.problem.shape is not None:
            raise UsageError(f"the body of {name!r} does not fill its box: sample it at particles")
        if isinstance(self.problem.body_force, Spatial):
            raise UsageError(
                f"the body force of {name!r} depends on current positions, which no table gives: use a solver in Python"
            )

    @cached_property
    def sample(self) -> tuple[Array, Array]:
        """Reference positions (P, dim) [m] and weights (P,) [m^dim] of the points; of nodes, those of the trapezoidal rule."""
        if self.points == "particles":
            return place_particles(self.problem, self.level)
        counts, h = self.level.cells(self.problem), self.level.h
        axes = [lower + h * np.arange(count + 1) for lower, count in zip(self.problem.lower, counts, strict=True)]
        ends = [h * np.r_[0.5, np.ones(count - 1), 0.5] for count in counts]
        positions = np.stack([along.ravel() for along in np.meshgrid(*axes, indexing="ij")], axis=1)
        weights = np.prod(np.stack([along.ravel() for along in np.meshgrid(*ends, indexing="ij")]), axis=0)
        return positions, weights

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the problem that have initial values and that a code may return."""
        transported = isinstance(self.problem.material, Transport)
        return ("u",) if transported else ("displacement", "velocity", "stress", "displacement_gradient")

    @cached_property
    def steps(self) -> tuple[int, float]:
        """Number of steps and the time step [s]."""
        return self.level.time_steps(self.problem)

    @cached_property
    def half_steps(self) -> Array:
        """Times 0, dt/2, dt, ... (2 N + 1,) [s], at which the tables over time are given."""
        steps, dt = self.steps
        return np.asarray(dt / 2 * np.arange(2 * steps + 1), dtype=np.float64)

    @cached_property
    def output_times(self) -> Array:
        """Times at which a code returns its fields (T,) [s]."""
        steps, dt = self.steps
        return np.asarray(dt * output_steps(steps, self.problem.outputs), dtype=np.float64)

    def write(self, folder: Path) -> None:
        """Write the files into a folder that exists.

        Raises
        ------
        OSError
            If a file cannot be written.
        """
        X, weight = self.sample
        names, columns = [*components("reference", self.problem.dimension), "weight"], [X, weight[:, None]]
        for quantity in self.quantities:
            names += components(quantity, self.problem.dimension)
            columns.append(self.problem.initial_field(quantity, X))
        _write_table(folder / "points.txt", names, np.hstack(columns))
        stated = self.statement() | {"boundary": self._boundary(folder), "body_force_modes": self._body_force(folder)}
        (folder / "problem.json").write_text(json.dumps(stated, indent=1) + "\n", encoding="utf-8")
        (folder / "problem.txt").write_text("".join(f"{line}\n" for line in _lines(stated)), encoding="utf-8")

    def statement(self) -> dict[str, Any]:
        """Return what `problem.json` says beside boundary conditions and body force."""
        problem, (steps, dt) = self.problem, self.steps
        law = problem.material
        material = {"velocity": law.velocity} if isinstance(law, Transport) else {"density": law.density}
        material |= {name: getattr(law, name) for name in MODULI if hasattr(law, name)}
        return {
            "format": FORMAT,
            "name": problem.name,
            "dimension": problem.dimension,
            "lower": problem.lower,
            "upper": problem.upper,
            "h": self.level.h,
            "cells": self.level.cells(problem),
            "steps": steps,
            "dt": dt,
            "end_time": problem.end_time,
            "output_steps": output_steps(steps, problem.outputs).tolist(),
            "points": len(self.sample[0]),
            "law": type(law).__name__,
            **material,
            "wave_speed": law.wave_speed,
        }

    def _boundary(self, folder: Path) -> dict[str, dict[str, Any]]:
        """Conditions by face; a value that varies in time has a table."""
        stated = {}
        for face, condition in self.problem.boundary.items():
            entry: dict[str, Any] = {"condition": type(condition).__name__}
            if (history := getattr(condition, "value", None)) is not None:
                values = np.asarray(history(self.half_steps), dtype=float)
                if np.all(values == values[0]):
                    entry["value"] = float(values[0])
                else:
                    entry["table"] = f"{face}.txt"
                    integral = np.asarray(history.integral(self.half_steps), dtype=float)
                    table = np.stack([self.half_steps, values, integral], axis=1)
                    _write_table(folder / entry["table"], ["time", "value", "integral"], table)
            stated[face] = entry
        return stated

    def _body_force(self, folder: Path) -> int:
        """Write the body force; return its number of modes."""
        force = self.problem.body_force
        if force is None:
            return 0
        assert not isinstance(force, Spatial), "such a deck is refused"
        amplitudes, modes = in_modes(lambda t: force(self.sample[0], t), self.half_steps)
        count, axes = len(modes), "xyz"[: self.problem.dimension]
        _write_table(folder / "body_force_amplitudes.txt", [f"amplitude_{k}" for k in range(count)], amplitudes)
        names = [f"mode_{k}_{axis}" for k in range(count) for axis in axes]
        _write_table(folder / "body_force_modes.txt", names, modes.transpose(1, 0, 2).reshape(len(self.sample[0]), -1))
        return count


def _write_table(path: Path, names: list[str], table: Array) -> None:
    np.savetxt(path, table, fmt="%.17g", header=" ".join(names))


def _lines(stated: Mapping[str, Any]) -> list[str]:
    """Statement as lines of a name and its values, such as "cells 48 48" and "boundary x- Velocity 0"."""
    lines = []
    for name, value in stated.items():
        if isinstance(value, Mapping):
            lines += [f"{name} {face} {' '.join(str(part) for part in entry.values())}" for face, entry in value.items()]
        else:
            parts = value if isinstance(value, list | tuple) else [value]
            lines.append(" ".join([name, *(repr(part) if isinstance(part, float) else str(part) for part in parts)]))
    return lines

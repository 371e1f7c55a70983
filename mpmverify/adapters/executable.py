"""A code in any language on the bench: a program that reads a problem from files and writes its result to files."""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mpmverify.adapters.deck import Deck
from mpmverify.adapters.result import read_result
from mpmverify.convergence import ROUND_OFF
from mpmverify.errors import UsageError
from mpmverify.problem import Discretisation, Problem
from mpmverify.solution import RunError, Solution, Status

REFUSED = 77
"""Exit status of a program that does not take a problem; its last line says why."""
PRINTED = "printed.txt"
"""File in the folder of a run with all that the program printed."""


@dataclass(frozen=True)
class Executable:
    """A solver that is a program. It starts in a folder with the problem's files, see `Deck`, and leaves its result there.

    Parameters
    ----------
    bench : Path
        The file that describes it. Paths are relative to its folder; the files of a run that fails are kept in `<name>-failed` there.
    name, orders, coarse_orders, conserves, round_off
        See `Solver`.
    command : tuple of str
        Program and arguments; one that is the name of a file beside `bench` stands for it.
    sources : tuple of Path
        Files that the result depends on: the program, and what it loads.
    points : {"particles", "nodes"}
        Points of the tables.
    result : str
        Name of the result's file, or a pattern for one file per output time.
    histories : str
        Name of the file of histories; "" for none.
    columns : mapping of str to str
        Names of columns or arrays in the result -> names of components.
    time_limit : float
        Limit for one run [s].
    memory_limit : float
        Limit of address space for one run [GB], where the system can set one; 0 for none.
    """

    bench: Path = field(repr=False)
    name: str
    orders: Mapping[str, float]
    command: tuple[str, ...]
    conserves: frozenset[str] = frozenset()
    sources: tuple[Path, ...] = field(default=(), repr=False)
    points: str = "particles"
    result: str = "result.csv"
    histories: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    time_limit: float = 600.0
    memory_limit: float = 0.0
    coarse_orders: Mapping[str, float] = field(default_factory=dict)
    round_off: float = ROUND_OFF

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Write the problem, run the program, and read its result.

        Raises
        ------
        UsageError
            If the program does not take the problem, cannot be started, or its files cannot be written.
        RunError
            If it ends with another exit status than 0, exceeds a limit, or leaves no readable result.
        """
        deck = Deck(problem, discretisation, self.points)
        with tempfile.TemporaryDirectory(prefix=f"{self.name}-", ignore_cleanup_errors=True) as place:
            folder = Path(place)
            try:
                deck.write(folder)
            except OSError as error:
                raise UsageError(
                    f"cannot write the problem to '{folder}' ({error.strerror or error}): free the disk"
                ) from error
            try:
                seconds = self._run(folder, problem)
                return read_result(folder, self.result, self.histories, self.columns, deck, seconds)
            except RunError as error:
                kept = (
                    self.bench.absolute().parent
                    / f"{self.name}-failed"
                    / f"{problem.name}-{slug(discretisation)}".replace("/", "-")
                )
                shutil.rmtree(kept, ignore_errors=True)
                shutil.copytree(folder, kept)
                outcome = error.outcome
                raise RunError(outcome.status, f"{outcome.detail}; its files are in {kept}", outcome.advice) from error

    def _run(self, folder: Path, problem: Problem) -> float:
        """Run the program; return its wall time [s]."""
        beside = self.bench.absolute().parent
        program, *arguments = [str(beside / part) if (beside / part).is_file() else part for part in self.command]
        with (folder / PRINTED).open("wb") as printed:
            started = time.perf_counter()
            try:
                process = subprocess.Popen(
                    [program, *arguments],
                    cwd=folder,
                    stdin=subprocess.DEVNULL,
                    stdout=printed,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                    preexec_fn=self._restrict if os.name == "posix" else None,
                )
            except OSError as error:
                raise UsageError(
                    f"'{program}' cannot be started ({error.strerror or error}): correct `command` in '{self.bench}'"
                ) from error
            try:
                status = process.wait(self.time_limit)
            except subprocess.TimeoutExpired as error:
                raise RunError(
                    Status.TIMED_OUT, f"the program did not end within {self.time_limit:g} s", "raise time_limit in bench.toml"
                ) from error
            finally:
                seconds = time.perf_counter() - started
                _end(process)
        said = last_lines(folder / PRINTED)
        if status == REFUSED:
            raise UsageError(
                f"solver {self.name!r} cannot solve {problem.name!r}: {said.splitlines()[-1] if said else 'it gives no reason'}"
            )
        if status:
            how = f"exit status {status}" if status > 0 else f"signal {signal.Signals(-status).name}"
            raise RunError(
                Status.CRASHED,
                f"the program ended with {how}" + (f" and printed: {said}" if said else ""),
                "run it in that folder",
            )
        return seconds

    def _restrict(self) -> None:
        """Limit the memory of the program, and let it end with the process that started it."""
        import ctypes
        import resource

        if self.memory_limit:
            size = int(self.memory_limit * 1e9)
            resource.setrlimit(resource.RLIMIT_AS, (size, size))
        if hasattr(ctypes.CDLL(None), "prctl"):
            ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG, on Linux


def slug(level: Discretisation) -> str:
    """Return the name of a level in names of files."""
    return f"h{level.h:.6g}-courant{level.courant:.6g}-ppc{level.ppc}" + (
        f"-jitter{level.jitter:g}-{level.seed}" if level.jitter else ""
    )


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End the program and all that it started."""
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError, PermissionError):  # nothing is left, or it belongs to somebody else
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()


def last_lines(path: Path, most: int = 240) -> str:
    """Return the end of a file of text, of at most so many characters."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - most))
        return file.read().decode("utf-8", "replace").strip()

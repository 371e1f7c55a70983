"""Runs that failed: what happened, at which step and time, what helps, and the command that runs them again."""

import re
import shlex
from collections.abc import Mapping, Set
from dataclasses import dataclass

from .notation import DASH, cell_size, count, ladder, number, size
from .record import Level, Record, Series

PRINTED, KEPT = " and printed: ", "; its files are in "
"""What separates the parts of the detail of a program that failed."""
PROGRAM, RESULTS = "Executable", "Files"
"""Classes of the solvers that a file `bench.toml` describes: a program, or the results of exported problems."""


@dataclass(frozen=True)
class FailedRun:
    """One run that failed.

    Parameters
    ----------
    h, courant, ppc : str
        Its level.
    status : str
        How it ended, such as "crashed".
    step, time : str
        Where it ended; an en dash where it is not known.
    happened : str
        Detail of its outcome.
    printed : str
        End of what the program printed; "" if there is nothing of it.
    href : str
        Link to the run file; "" if there is none.
    """

    h: str
    courant: str
    ppc: str
    status: str
    step: str
    time: str
    happened: str
    printed: str
    href: str


@dataclass(frozen=True)
class Failure:
    """The failed runs of one series.

    Parameters
    ----------
    anchor : str
        Anchor on the page that shows it.
    study, case, solver, ladder : str
    href : str
        Link to the verdicts on the solver in this case.
    total : str
        Number of runs of the series.
    runs : tuple of FailedRun
    advice : tuple of str
        What helps, each sentence once.
    command : str
        Command that runs the series again.
    """

    anchor: str
    study: str
    case: str
    solver: str
    ladder: str
    href: str
    total: str
    runs: tuple[FailedRun, ...]
    advice: tuple[str, ...]
    command: str


def failures(record: Record, places: Mapping[tuple[str, str], str], runs: Set[str]) -> dict[tuple[str, str, str], Failure]:
    """Return the failures of a study by (case, solver, refinement).

    Parameters
    ----------
    record : Record
    places : mapping of (str, str) to str
        Anchor of the verdicts on each (case, solver).
    runs : set of str
        Keys of the run files that exist.
    """
    failed = [series for series in record.series if series.failed]
    return {
        (series.case, series.solver, series.refinement): Failure(
            anchor=f"failed-{k}",
            study=record.name,
            case=series.case,
            solver=series.solver,
            ladder=ladder(series.refinement),
            href=f"{record.name}.html#{places[series.case, series.solver]}",
            total=count(len(series.levels)),
            runs=tuple(_run(level, runs) for level in _ended(series)),
            advice=tuple(dict.fromkeys(advice for level in _ended(series) if (advice := _parts(level.outcome)[2]))),
            command=command(record, series.solver),
        )
        for k, series in enumerate(failed, 1)
    }


def command(record: Record, solver: str) -> str:
    """Return the command that runs a solver of a study again, in a folder of its own so that the results at hand stay as they are."""
    study = str(record.attributes.get("id", record.name))
    own = next((name for name in record.schemes if study.endswith(f"-with-{name}")), "")
    chosen = [study, "--solver", solver]
    if own:
        kind = record.schemes[own].partition("(")[0]
        chosen = [] if kind == RESULTS else [study.removesuffix(f"-with-{own}")]
        # The file that declares a solver of one's own is not stored: the name of a file says nothing on another machine.
        chosen += ["--with", "bench.toml" if kind in (PROGRAM, RESULTS) else "FILE.py:NAME"]
    tier = str(record.attributes.get("tier", "quick"))
    courant = re.search(r"Courant number (\S+)$", record.restricted_to)
    options = ["--tier", tier] * (tier != "quick") + (["--courant", courant[1]] if courant else [])
    return shlex.join(["mpmverify", "run", *chosen, *options, "--out", "rerun"])


def _ended(series: Series) -> list[Level]:
    return [level for level in series.levels if level.outcome != "completed"]


def _run(level: Level, runs: Set[str]) -> FailedRun:
    status, detail, _ = _parts(level.outcome)
    happened, _, printed = detail.partition(PRINTED)
    printed, cut, kept = printed.rpartition(KEPT) if KEPT in printed else (printed, "", "")
    step, time = _reached(level, detail)
    return FailedRun(
        h=cell_size(level.h),
        courant=size(level.courant),
        ppc=count(level.ppc),
        status=status,
        step=step,
        time=time,
        happened=f"{happened}{cut}{kept}",
        printed=printed,
        href=f"../runs/{level.run}.nc" if level.run in runs else "",
    )


def _parts(outcome: str) -> tuple[str, str, str]:
    """Split an outcome into status, detail and advice, as `mpmverify.solution.Outcome` joins them."""
    status, _, rest = outcome.partition("; ")
    detail, _, advice = rest.rpartition("; ")
    return status, detail, advice


def _reached(level: Level, detail: str) -> tuple[str, str]:
    """Return the step and the time [s] at which a run ended: those of its detail, else those up to which it returned steps."""
    since, step = re.search(r"from t = (\S+) s on$", detail), re.search(r"\bat step (\d+)(?: of (\d+))?", detail)
    if since:
        return DASH, since[1]
    if not step:
        return (count(level.steps), number(level.steps * level.dt)) if level.steps else (DASH, DASH)
    of = f" of {count(int(step[2]))}" if step[2] else ""
    return f"{count(int(step[1]))}{of}", number(int(step[1]) * level.dt)

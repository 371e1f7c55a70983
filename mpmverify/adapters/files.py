"""Results that are already there: a folder of problems, written for a code to run wherever it likes, and the results beside them."""

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mpmverify.adapters.deck import Deck
from mpmverify.adapters.result import read_result
from mpmverify.atomic import write_atomic
from mpmverify.convergence import ROUND_OFF
from mpmverify.errors import UsageError
from mpmverify.execution.keys import digest
from mpmverify.problem import Discretisation, Problem, components
from mpmverify.solution import Solution
from mpmverify.study import Case, Refinement, Study

FORMAT = "mpmverify problems 1"
INDEX, BENCH = "problems.json", "bench.toml"


@dataclass(frozen=True)
class Files:
    """A solver whose results lie in the folders of exported problems.

    Parameters
    ----------
    bench : Path
        The file that describes it.
    name, orders, coarse_orders, conserves, round_off
        See `Solver`.
    problems : Path
        Index of the exported problems, which `export` wrote.
    sources : tuple of Path
        Files of the results.
    points, result, histories, columns
        See `Executable`.
    """

    bench: Path = field(repr=False)
    name: str
    orders: Mapping[str, float]
    problems: Path = field(repr=False)
    conserves: frozenset[str] = frozenset()
    sources: tuple[Path, ...] = field(default=(), repr=False)
    points: str = "particles"
    result: str = "result.csv"
    histories: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    coarse_orders: Mapping[str, float] = field(default_factory=dict)
    round_off: float = ROUND_OFF

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Read the result of a run.

        Raises
        ------
        UsageError
            If the problem is not among the exported ones, or has changed since.
        RunError
            If there is no readable result.
        """
        key = digest(problem, discretisation)
        for case in read_index(self.problems)["cases"]:
            for level in case["levels"]:
                if level["key"] == key:
                    deck = Deck(problem, discretisation, self.points)
                    return read_result(self.problems.parent / level["folder"], self.result, self.histories, self.columns, deck)
        raise UsageError(
            f"{problem.name!r} at h = {discretisation.h:g} is not in '{self.problems}', or has changed: export it anew"
        )

    def study(self, get: Callable[[str], Study]) -> Study:
        """Return the exported study, with the exported cases and levels.

        Parameters
        ----------
        get : callable
            Returns a study by name.

        Raises
        ------
        UsageError
            If the study lacks an exported case.
        """
        index = read_index(self.problems)
        declared = get(index["study"])
        cases = {case.name: case for case in declared.cases}
        kept = []
        for entry in index["cases"]:
            if entry["case"] not in cases:
                raise UsageError(f"the study {declared.name!r} has no case {entry['case']!r} any more: export it anew")
            levels = tuple(Discretisation(**level["level"]) for level in entry["levels"])
            ladder = Refinement(entry["ladder"], levels, len(levels))
            kept.append(dataclasses.replace(cases[entry["case"]], ladder=ladder))
        return dataclasses.replace(declared, cases=tuple(kept))


def export(
    study: Study, name: str, folder: Path, *, cases: Sequence[str], levels: int | None, points: str
) -> Mapping[str, str]:
    """Write the problems of a study, with a file `bench.toml` that describes their results; return the reasons for cases left out.

    Parameters
    ----------
    study : Study
    name : str
        Name of the study on the command line.
    folder : Path
        Must not exist, or be empty.
    cases : sequence of str
        Names of cases; all of them if there is none.
    levels : int or None
        Number of levels, from the coarsest; by default those of the quick tier.
    points : {"particles", "nodes"}

    Raises
    ------
    UsageError
        If the folder is not empty, a case is unknown, or no case can be written.
    OSError
        If a file cannot be written.
    """
    known = [case.name for case in study.cases]
    if unknown := [case for case in cases if case not in known]:
        raise UsageError(f"the study {study.name!r} has no case {unknown[0]!r}: choose from {', '.join(known)}")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"'{folder}' is not empty: choose a new folder")
    written, refused = [], {}
    for case in study.cases:
        if case.name in (cases or known):
            try:
                written.append(_export(case, folder, levels, points))
            except UsageError as error:
                refused[case.name] = str(error)
    if not written:
        raise UsageError(next(iter(refused.values())))
    index = {"format": FORMAT, "study": name, "cases": written}
    write_atomic(folder / INDEX, lambda path: path.write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8"))
    quantities = ", ".join(
        f"{quantity} = 2" for quantity in next(c for c in study.cases if c.name == written[0]["case"]).problem.exact.fields
    )
    (folder / BENCH).write_text(TEMPLATE.format(place=folder / BENCH, quantities=quantities, points=points), encoding="utf-8")
    return refused


TEMPLATE = """\
# What your code declares. Once its results lie in the folders beside this file, this judges them:
#   mpmverify run --with {place}
name = "my-code"
orders = {{ {quantities} }}  # formal order in h of each field that you return; delete the others
conserves = []  # "mass", "momentum", "energy": needs histories
problems = "problems.json"
points = "{points}"
result = "result.csv"  # in each folder; or a pattern such as "out*.vtu", one file for each output time
# histories = "histories.csv"
"""


def _export(case: Case, folder: Path, levels: int | None, points: str) -> dict[str, Any]:
    ladder = case.ladder_in_h()
    chosen = ladder.levels[: levels or ladder.quick or len(ladder.levels)]
    if levels and len(ladder.levels) < levels:
        raise UsageError(f"case {case.name!r} has {len(ladder.levels)} levels: ask for fewer")
    entries = []
    for k, level in enumerate(chosen):
        deck = Deck(case.problem.problem, level, points)
        place = Path(case.name.replace("/", "-").replace(" ", "-")) / f"level-{k + 1}"
        (folder / place).mkdir(parents=True, exist_ok=True)
        deck.write(folder / place)
        (folder / place / "example.csv").write_text(_example(deck), encoding="utf-8")
        entries.append({"folder": place.as_posix(), "key": digest(deck.problem, level), "level": dataclasses.asdict(level)})
    return {"case": case.name, "ladder": ladder.label, "levels": entries}


def _example(deck: Deck, rows: int = 3) -> str:
    """First lines of a result: the initial values of some points."""
    (X, weight), dimension = deck.sample, deck.problem.dimension
    names = ["time", *components("reference", dimension), "weight"]
    columns = [[0.0] * rows, *X[:rows].T, weight[:rows]]
    for quantity in deck.quantities:
        names += components(quantity, dimension)
        columns += list(deck.problem.initial_field(quantity, X[:rows]).T)
    lines = [",".join(names), *(",".join(f"{value:.17g}" for value in row) for row in zip(*columns, strict=True))]
    return "\n".join(lines) + "\n"


def read_index(path: Path) -> dict[str, Any]:
    """Read the index of exported problems.

    Raises
    ------
    UsageError
        If there is none, or it is damaged.
    """
    try:
        index = json.loads(path.read_text(encoding="utf-8"))
        if index["format"] != FORMAT:
            raise UsageError(f"'{path}' is of another version: export the problems anew")
        for case in index["cases"]:
            (
                case["case"],
                case["ladder"],
                [(level["folder"], level["key"], Discretisation(**level["level"])) for level in case["levels"]],
            )
        index["study"]
    except UsageError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"'{path}' is no index of exported problems ({error}): export them anew") from error
    return dict(index)

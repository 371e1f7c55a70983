"""Styles of curves: colour by solver, marker by family, dash by ladder."""

from collections.abc import Sequence
from dataclasses import dataclass

from .record import Measure, Series

COLOURS = 10
"""Number of colours, `--series-0` to `--series-9` in the style sheet; safe for colour-blind readers on light and dark pages."""
DASHES = ("solid", "dash", "dot", "dashdot")
SYMBOLS = (
    ("circle", "pentagon"),
    ("square", "diamond"),
    ("triangle-up", "triangle-down"),
    ("cross", "x"),
    ("star", "hexagram"),
)
"""Two markers for each family; the second is used when all colours have been used with the first."""
STROKES = {"solid": "", "dash": "5 3", "dot": "1.5 2.5", "dashdot": "6 2.5 1.5 2.5"}
"""SVG stroke patterns of the dashes, for drawings other than charts."""


@dataclass(frozen=True)
class Style:
    """Style of one curve."""

    colour: int
    dash: str
    symbol: str

    @property
    def paint(self) -> str:
        return f"var(--series-{self.colour})"


def styles(series: Sequence[Series]) -> list[Style]:
    """Return the styles of the series of a study; a solver has the same colour and marker in every case."""
    solvers = list(dict.fromkeys(entry.solver for entry in series))
    families = list(dict.fromkeys(entry.family for entry in series))
    ladders: dict[tuple[str, str], list[str]] = {}
    table = []
    for entry in series:
        of_solver = ladders.setdefault((entry.case, entry.solver), [])
        of_solver.append(entry.refinement)
        wrap, colour = divmod(solvers.index(entry.solver), COLOURS)
        marks = SYMBOLS[families.index(entry.family) % len(SYMBOLS)]
        table.append(Style(colour, DASHES[(len(of_solver) - 1) % len(DASHES)], marks[wrap % len(marks)]))
    return table


def selection(series: Sequence[Series], measure: Measure | None, count: int = 6) -> set[int]:
    """Choose at most `count` series of a case that are drawn at first.

    The families have about equal shares, each spread over its solvers; the first ladder of a solver is preferred to the others.
    """
    families: dict[str, list[tuple[int, int]]] = {}
    seen: dict[str, int] = {}
    for k, entry in enumerate(series):
        if measure in entry.estimates:
            ladder = seen[entry.solver] = seen.get(entry.solver, -1) + 1
            families.setdefault(entry.family, []).append((ladder, k))
    places = dict.fromkeys(families, 0)
    for turn in range(len(series)):
        for family, members in families.items():
            if turn < len(members) and sum(places.values()) < count:
                places[family] += 1
    chosen = set()
    for family, members in families.items():
        first = sorted(members)[: max(places[family], sum(ladder == 0 for ladder, _ in members))]
        chosen |= {first[turn * len(first) // places[family]][1] for turn in range(places[family])}
    return chosen

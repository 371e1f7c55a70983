"""How curves are told apart: colour by solver, marker by family, dash by ladder; never by colour alone."""

from collections.abc import Sequence
from dataclasses import dataclass

from .record import Measure, Series

COLOURS = 10
"""Colours of the palette, `--series-0` and on in the style sheet; safe for colour-blind readers on light and dark."""
DASHES = ("solid", "dash", "dot", "dashdot")
SYMBOLS = (
    ("circle", "pentagon"),
    ("square", "diamond"),
    ("triangle-up", "triangle-down"),
    ("cross", "x"),
    ("star", "hexagram"),
)
"""Markers of each family: the first until its colours are used up, then the second."""
STROKES = {"solid": "", "dash": "5 3", "dot": "1.5 2.5", "dashdot": "6 2.5 1.5 2.5"}
"""The same dashes for drawings that are not charts."""


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
    """Styles of the series of a study: a solver keeps its colour and marker in every case."""
    solvers = list(dict.fromkeys(entry.solver for entry in series))
    families = list(dict.fromkeys(entry.family for entry in series))
    ladders: dict[tuple[str, str], list[str]] = {}
    table = []
    for entry in series:
        mine = ladders.setdefault((entry.case, entry.solver), [])
        mine.append(entry.refinement)
        wrap, colour = divmod(solvers.index(entry.solver), COLOURS)
        marks = SYMBOLS[families.index(entry.family) % len(SYMBOLS)]
        table.append(Style(colour, DASHES[(len(mine) - 1) % len(DASHES)], marks[wrap % len(marks)]))
    return table


def selection(series: Sequence[Series], measure: Measure | None, most: int = 6) -> set[int]:
    """Choose which of the series of a case are drawn at first: as many of each family, spread over it, first ladders first."""
    families: dict[str, list[tuple[int, int]]] = {}
    seen: dict[str, int] = {}
    for k, entry in enumerate(series):
        if measure in entry.estimates:
            ladder = seen[entry.solver] = seen.get(entry.solver, -1) + 1
            families.setdefault(entry.family, []).append((ladder, k))
    places = dict.fromkeys(families, 0)
    for turn in range(len(series)):
        for family, members in families.items():
            if turn < len(members) and sum(places.values()) < most:
                places[family] += 1
    chosen = set()
    for family, members in families.items():
        first = sorted(members)[: max(places[family], sum(ladder == 0 for ladder, _ in members))]
        chosen |= {first[turn * len(first) // places[family]][1] for turn in range(places[family])}
    return chosen

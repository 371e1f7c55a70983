"""Diagnosis: which planted faults change the errors of a sound code as those of a code that fails differ from a sound one.

A signature holds the decimal logarithm of every relative error of a solver: by case, level, quantity and norm, with the defects of mass
and momentum, and whether each run completed. A fault in a code changes some of them; the table of signatures holds these changes for
faults planted in several variants of the textbook's code, see `mpmverify.selftest.signatures`.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mpmverify.criteria.evidence import Level
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import ResultsError
from mpmverify.problem import Array

TABLE = Path(__file__).with_name("signatures.json")
"""Signatures of the planted faults."""
LEAST, MOST = 1e-5, 10.0
"""Relative errors between which a signature tells errors apart, so that a blow-up does not drown all else."""
LEAST_DEFECT = 1e-4
"""The same for the defects of mass and momentum, where round-off lies many decades below."""
UNFINISHED = 2.0
"""Entry of a run that did not complete, in decades; 0 for one that did."""
SAME = 0.1
"""Change of an error [decades] that counts as none: sound codes differ by as much."""
THRESHOLD = 0.35
"""Least similarity of a cause that is named: a right plane code that is not in the table has 0.33, a variant left out of it up to 0.6."""
LEAST_CASES = 3
"""Least number of cases of the table: on one case alone, what sets two right schemes apart may look like a fault."""
NAMED = 3
"""Largest number of causes that are named."""
DEFECTS = "mass_defect", "momentum_defect"

Signature = Mapping[str, float]
"""Entries by place: study, case, level, and what was measured."""


class Likeness(NamedTuple):
    """A cause of errors, and how similar the errors of its planted faults are: 1 if they are the same, 0 if no error changes alike."""

    cause: str
    similarity: float


class Measured(NamedTuple):
    """What a signature needs of one run: its place, whether it completed, relative errors by (quantity, norm), and metrics by name."""

    case: str
    h: float
    courant: float
    ppc: int
    completed: bool
    errors: Mapping[tuple[str, str], float]
    metrics: Mapping[str, float]


def measured(level: Level) -> Measured:
    """Return what a signature needs of a level."""
    relative = {
        (quantity, norm): error[k] / (size[k] or 1.0)
        for quantity, (error, size) in level.errors.items()
        for k, norm in enumerate(NORMS)
    }
    place = level.case, level.h, level.courant, level.ppc
    return Measured(*place, level.outcome == "completed", relative, level.metrics)


def signature(study: str, runs: Iterable[Measured]) -> Signature:
    """Return the signature of the runs of one solver on a study."""
    entries: dict[str, float] = {}
    for run in runs:
        place = f"{study} | {run.case} | h={run.h:.6g} nu_C={run.courant:.6g} ppc={run.ppc}"
        entries[f"{place} | completed"] = 0.0 if run.completed else UNFINISHED
        for (quantity, norm), error in run.errors.items():
            if norm != "L1":  # nearly that in L2
                entries[f"{place} | {quantity} {norm}"] = _decades(error, LEAST)
        for name in run.metrics.keys() & DEFECTS:
            entries[f"{place} | {name}"] = _decades(run.metrics[name], LEAST_DEFECT)
    return entries


def _decades(value: float, least: float) -> float:
    return float(np.log10(np.clip(np.nan_to_num(value, nan=MOST, posinf=MOST), least, MOST)))


def similarity(one: Array, other: Array) -> float:
    """Return how much of two changes of signatures is the same: 1 - sum |a - b| / sum (|a| + |b|), between 0 and 1.

    Parameters
    ----------
    one, other : Array
        Changes of the same entries [decades]; NaN where an entry is missing. Each is reduced by `SAME` towards 0 first.

    Notes
    -----
    One less the dissimilarity of Bray and Curtis (1957), doi:10.2307/1942268, for values of either sign. It sees amplitudes, which a
    cosine does not. By measurement on faults in another code it names as many true causes as a cosine, and more than a distance.
    """
    known = np.isfinite(one) & np.isfinite(other)
    a, b = (np.sign(v[known]) * np.maximum(np.abs(v[known]) - SAME, 0.0) for v in (one, other))
    total = np.sum(np.abs(a) + np.abs(b))
    return float(1 - np.sum(np.abs(a - b)) / total) if total > 0 else 0.0


@dataclass(frozen=True)
class Signatures:
    """Signatures of sound codes, and their changes by planted faults.

    Parameters
    ----------
    problems : mapping of str to str
        Digest of the problem of each case, by "study | case".
    entries : tuple of str
        Places of the entries (E,).
    sound : mapping of str to Array
        Signature (E,) of each sound variant by name [decades]; NaN where an entry is missing.
    changes : mapping of str to mapping of str to tuple of Array
        Changes (E,) by the faults of each cause, by variant [decades].
    """

    problems: Mapping[str, str]
    entries: tuple[str, ...]
    sound: Mapping[str, Array]
    changes: Mapping[str, Mapping[str, tuple[Array, ...]]]

    def likenesses(self, found: Signature) -> tuple[Likeness, ...]:
        """Return all causes, the most similar first.

        Each fault is compared in the variant that it was planted in: how it changes the errors of the variant, and how the signature that
        was found differs from the variant. The best of all faults and variants counts. Errors of a sound variant are like those of no
        fault.
        """
        mine = np.array([found.get(entry, np.nan) for entry in self.entries])
        if any(np.all(np.abs(mine - sound)[np.isfinite(mine - sound)] <= SAME) for sound in self.sound.values()):
            return ()
        best: dict[str, float] = {}
        for variant, sound in self.sound.items():
            for cause, changes in self.changes[variant].items():
                best[cause] = max(best.get(cause, 0.0), *(similarity(mine - sound, change) for change in changes))
        return tuple(sorted((Likeness(*pair) for pair in best.items()), key=lambda one: -one.similarity))

    def without(self, variant: str) -> "Signatures":
        """Return the signatures without those of a variant."""
        kept = {name: sound for name, sound in self.sound.items() if name != variant}
        return Signatures(self.problems, self.entries, kept, {name: self.changes[name] for name in kept})

    def write(self, path: Path) -> None:
        """Write the table: signatures and changes in hundredths of a decade, one a line."""
        body: dict[str, Any] = {
            "problems": self.problems,
            "entries": self.entries,
            "sound": {variant: _hundredths(sound) for variant, sound in self.sound.items()},
            "changes": {
                variant: {cause: list(map(_hundredths, changes)) for cause, changes in causes.items()}
                for variant, causes in self.changes.items()
            },
        }
        text = json.dumps(body, separators=(",", ":")).replace("]", "]\n").replace('","', '",\n"')
        path.write_text(f"{text}\n", encoding="utf-8")


def _hundredths(values: Array) -> list[int | None]:
    return [None if np.isnan(value) else round(100 * value) for value in values]


def _of_hundredths(values: Sequence[int | None]) -> Array:
    return np.array(values, dtype=float) / 100


@cache
def read_signatures(path: Path = TABLE) -> Signatures:
    """Read a table of signatures.

    Raises
    ------
    ResultsError
        If it cannot be read.
    """
    try:
        body = json.loads(path.read_text(encoding="utf-8"))
        return Signatures(
            body["problems"],
            tuple(body["entries"]),
            {variant: _of_hundredths(sound) for variant, sound in body["sound"].items()},
            {
                variant: {cause: tuple(map(_of_hundredths, changes)) for cause, changes in causes.items()}
                for variant, causes in body["changes"].items()
            },
        )
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise ResultsError(
            f"'{path}' is no table of signatures: make it with `mpmverify selftest --signatures FILE`"
        ) from error


def diagnosis(found: Signature) -> str:
    """Say what errors like these come from; "" if no cause is similar enough, or they are of fewer than `LEAST_CASES` cases of the table."""
    table = read_signatures()
    if len({tuple(entry.split(" | ")[:2]) for entry in found.keys() & set(table.entries)}) < LEAST_CASES:
        return ""
    alike = [one for one in table.likenesses(found)[:NAMED] if one.similarity >= THRESHOLD]
    if not alike:
        return ""
    *others, last = (f"{one.cause} ({one.similarity:.2f})" for one in alike)
    causes = f"{', '.join(others)} or {last}" if others else last
    return f"errors like these come from {causes}: likenesses with faults planted in another code, not proofs"

"""Faults: passages of a solver's source, and what stands there instead."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from mpmverify.errors import UsageError


@dataclass(frozen=True)
class Edit:
    """One passage of a file, and what replaces it.

    Parameters
    ----------
    file : str
        Path below the folder of the solvers.
    old, new : str
    place, of : int
        Which occurrence of `old` in the file is meant, from 0, and how many there must be.
    """

    file: str
    old: str
    new: str
    place: int = 0
    of: int = 1

    def begin(self, text: str) -> int:
        """Offset of the passage in the text of its file.

        Raises
        ------
        UsageError
            If the file does not hold the passage so often: the fault was declared for another version of it.
        """
        if text.count(self.old) != self.of:
            raise UsageError(
                f"{self.file} holds {self.old!r} {text.count(self.old)} times, not {self.of}: declare the fault anew"
            )
        at = -1
        for _ in range(self.place + 1):
            at = text.index(self.old, at + 1 if at < 0 else at + len(self.old))
        return at

    def applied(self, text: str) -> str:
        """Text of the file with the passage replaced."""
        at = self.begin(text)
        return text[:at] + self.new + text[at + len(self.old) :]


@dataclass(frozen=True)
class Fault:
    """A fault of one solver family.

    Parameters
    ----------
    family : str
        Folder of the family: "mpm", "taylor_galerkin", "fem".
    rule : str
        Rule that made it, or "named".
    name : str
        What is wrong, in a few words.
    edits : tuple of Edit
        Made one after the other.
    """

    family: str
    rule: str
    name: str
    edits: tuple[Edit, ...]

    @property
    def id(self) -> str:
        """Rule, family and a digest of the edits, which stays when the file changes elsewhere."""
        total = hashlib.sha256(repr([(edit.file, edit.old, edit.new, edit.place) for edit in self.edits]).encode())
        return f"{self.family}/{self.rule}/{total.hexdigest()[:8]}"

    def planted(self, sources: Path) -> dict[str, str]:
        """Text of each file that the fault changes, by its path below `sources`."""
        texts: dict[str, str] = {}
        for edit in self.edits:
            text = texts.get(edit.file) or (sources / edit.file).read_text(encoding="utf-8")
            texts[edit.file] = edit.applied(text)
        return texts


@dataclass(frozen=True)
class Passage:
    """Where a fault stands, for people: file, line, and the lines before and after the first edit."""

    file: str
    line: int
    before: str
    after: str


def passage(fault: Fault, sources: Path) -> Passage:
    """Look up where a fault stands in the sources."""
    edit = fault.edits[0]
    text = (sources / edit.file).read_text(encoding="utf-8")
    begin = edit.begin(text)
    end = begin + len(edit.old.rstrip("\n"))
    first, last = text.rfind("\n", 0, begin) + 1, (text + "\n").index("\n", end)
    after = text[first:begin] + edit.new.rstrip("\n") + text[end:last]
    return Passage(edit.file, text.count("\n", 0, begin) + 1, " ".join(text[first:last].split()), " ".join(after.split()))

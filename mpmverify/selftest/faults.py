"""Faults: edits of a solver's source text."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from mpmverify.errors import UsageError


@dataclass(frozen=True)
class Edit:
    """Replacement of one passage of a source file.

    Parameters
    ----------
    file : str
        Path relative to the folder of the solvers.
    old, new : str
        The passage and its replacement.
    occurrence : int
        Which occurrence of `old` to replace, counted from 0.
    count : int
        Number of occurrences of `old` that the file must hold.
    """

    file: str
    old: str
    new: str
    occurrence: int = 0
    count: int = 1

    def begin(self, text: str) -> int:
        """Return the offset of the passage in the text of its file, in characters.

        Raises
        ------
        UsageError
            If `old` does not occur `count` times: the fault was declared for another version of the file.
        """
        if text.count(self.old) != self.count:
            raise UsageError(
                f"{self.file} holds {self.old!r} {text.count(self.old)} times, not {self.count}: adapt the fault to the source"
            )
        at = -1
        for _ in range(self.occurrence + 1):
            at = text.index(self.old, at + 1 if at < 0 else at + len(self.old))
        return at

    def applied(self, text: str) -> str:
        """Return the text of the file with the passage replaced."""
        at = self.begin(text)
        return text[:at] + self.new + text[at + len(self.old) :]


@dataclass(frozen=True)
class Fault:
    """A fault of one solver family.

    Parameters
    ----------
    family : str
        Folder of the family: "mpm", "taylor_galerkin" or "fem".
    rule : str
        Rule that generated the fault, or "named".
    name : str
        Short description of the error.
    edits : tuple of Edit
        Applied in this order.
    """

    family: str
    rule: str
    name: str
    edits: tuple[Edit, ...]

    @property
    def id(self) -> str:
        """Family, rule and a digest of the edits; it does not change when other parts of the file do."""
        total = hashlib.sha256(repr([(edit.file, edit.old, edit.new, edit.occurrence) for edit in self.edits]).encode())
        return f"{self.family}/{self.rule}/{total.hexdigest()[:8]}"

    def planted(self, sources: Path) -> dict[str, str]:
        """Return the new text of each changed file, by its path relative to `sources`."""
        texts: dict[str, str] = {}
        for edit in self.edits:
            text = texts.get(edit.file) or (sources / edit.file).read_text(encoding="utf-8")
            texts[edit.file] = edit.applied(text)
        return texts


@dataclass(frozen=True)
class Passage:
    """Location of a fault for display: file, line number, and the text of its lines before and after the first edit."""

    file: str
    line: int
    before: str
    after: str


def passage(fault: Fault, sources: Path) -> Passage:
    """Return the location of a fault's first edit in the sources."""
    edit = fault.edits[0]
    text = (sources / edit.file).read_text(encoding="utf-8")
    begin = edit.begin(text)
    end = begin + len(edit.old.rstrip("\n"))
    first, last = text.rfind("\n", 0, begin) + 1, (text + "\n").index("\n", end)
    after = text[first:begin] + edit.new.rstrip("\n") + text[end:last]
    return Passage(edit.file, text.count("\n", 0, begin) + 1, " ".join(text[first:last].split()), " ".join(after.split()))


def named(family: str, name: str, *edits: tuple[str, str, str]) -> Fault:
    """Return a named fault of edits (file, old, new)."""
    return Fault(family, "named", name, tuple(Edit(*edit) for edit in edits))

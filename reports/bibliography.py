"""The sources of a study as BibTeX, from the texts that cite them: what a text does not state is left out."""

import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from urllib.parse import quote

MOST = 40
"""Largest number of authors after the first; the time to read a text is bounded."""
_PREFIX = r"(?:(?:de|del|den|der|di|la|le|van|von) ){0,3}"
_NAME = rf"{_PREFIX}[^\W\d_a-z][\w'’-]+"
_PERSON = rf"{_NAME}(?: [^\W\d_a-z][\w'’-]+)?(?: [^\W\d_a-z]\.(?:-?[^\W\d_a-z]\.){{0,3}}){{1,5}}"
_DOI = r"doi:(10\.\d+/[^\s,;{}%\\]*[^\s,;.){}%\\])"
FULL = re.compile(rf"({_PERSON}(?:, (?:and )?{_PERSON}| and {_PERSON}){{0,{MOST}}}) \((\d{{4}})\)\. ([^;]*)")
"""A citation with the initials of its authors: "Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford"."""
SHORT = re.compile(rf"({_NAME}(?:(?:, {_NAME}){{0,{MOST}}} and {_NAME})?) \((\d{{4}})\)")
"""A citation by surnames: "Donea (1984), doi:10.1002/nme.1620200108"."""
TAILS = (
    re.compile(rf"(?:, (?P<title>[A-Z][^,]*))?, {_DOI.replace('(', '(?P<doi>', 1)}"),
    re.compile(r", (?P<title>[A-Z][^,]*), (?P<journal>[A-Z][^,\d]*) (?P<volume>\d+), (?P<pages>\d+-\d+)"),
    re.compile(r", (?P<title>[A-Z][^,]*), (?:chapter|section)s? "),
)
"""What follows a short citation that tells more than its authors and its year."""
KINDS = {
    "article": re.compile(r"(?P<journal>[^,\d][^,]*?) (?P<volume>\d+)(?:\((?P<number>[^)]+)\))?, (?P<pages>\d[\d-]*)"),
    "incollection": re.compile(
        rf"In: (?P<editor>{_PERSON}(?:, {_PERSON})*) \(eds?\.\), (?P<booktitle>.+), (?P<publisher>[^,]+), (?P<pages>\d+-\d+)"
    ),
    "book": re.compile(r"(?P<publisher>[^,]*\bPress)(?:, (?P<address>[A-Z]\w+))?(?:, (?:chapter|section)s? .*)?"),
}
"""What follows the title of a full citation, by the kind of entry."""
ESCAPES = str.maketrans(
    {sign: f"\\{sign}" for sign in "&%$#_"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    | {"{": r"\textbraceleft{}", "}": r"\textbraceright{}"}  # an escaped brace would count in BibTeX
)
ORDER = (
    "author",
    "editor",
    "title",
    "booktitle",
    "journal",
    "volume",
    "number",
    "pages",
    "publisher",
    "address",
    "howpublished",
    "note",
    "year",
    "doi",
)


@dataclass(frozen=True)
class Reference:
    """One source.

    Parameters
    ----------
    kind : str
        Kind of the BibTeX entry.
    surnames : tuple of str
        Surnames of the authors; empty if only a DOI is known.
    fields : mapping of str to str
        Fields as plain text; names are separated by " and ".
    """

    kind: str
    surnames: tuple[str, ...]
    fields: Mapping[str, str] = field(default_factory=dict)

    @property
    def identified(self) -> bool:
        """Whether a reader can find it: it has a title or a DOI."""
        return "title" in self.fields or "doi" in self.fields


@dataclass(frozen=True)
class Bibliography:
    """A file of BibTeX entries on a page: `href` holds the file, so that it is downloaded without a network or scripts.

    Parameters
    ----------
    file, note : str
        Name of the file, and number of its entries.
    text, href : str
    """

    file: str
    note: str
    text: str
    href: str


def references(texts: Iterable[str]) -> tuple[Reference, ...]:
    """Return the sources that some texts cite, each once, by author and year.

    Citations of one source are merged: those with the same DOI, or with the same authors and year of which one states no title.
    """
    merged: list[Reference] = []
    for found in sorted((one for text in dict.fromkeys(texts) for one in _cited(text)), key=lambda one: -len(one.fields)):
        same = next((k for k, known in enumerate(merged) if _same(known, found)), None)
        if same is None:
            merged.append(found)
        else:
            merged[same] = replace(merged[same], fields=dict(found.fields) | dict(merged[same].fields))
    return tuple(sorted(merged, key=lambda one: (_plain("".join(one.surnames[:1])), one.fields.get("year", ""), _title(one))))


def bibtex(texts: Iterable[str]) -> str:
    """Return the sources that some texts cite as a BibTeX file; "" if none can be identified."""
    found = references(texts)
    taken = set[str]()
    entries = [_entry(reference, _key(reference, taken)) for reference in found if reference.identified]
    if not entries:
        return ""
    vague = [f"% Not enough is stated of: {_names(one.surnames)} ({one.fields['year']})" for one in found if not one.identified]
    head = "% Made from the citations in the results. Fields that they do not state are left out."
    return "\n\n".join(["\n".join([head, *vague]), *entries]) + "\n"


def downloadable(texts: Iterable[str], name: str) -> Bibliography | None:
    """Return the sources that some texts cite as a file to download, or None if none can be identified.

    Parameters
    ----------
    texts : iterable of str
    name : str
        Name of the file, without ending.
    """
    text = bibtex(texts)
    if not text:
        return None
    many = text.count("\n@")
    href = f"data:application/x-bibtex;charset=utf-8,{quote(text)}"
    return Bibliography(f"{name}.bib", f"{many} {'entry' if many == 1 else 'entries'}", text, href)


def _cited(text: str) -> Iterator[Reference]:
    text = " ".join(text.split())
    found = [_full(match[1], match[2], match[3]) for match in FULL.finditer(text)]
    brief = FULL.sub("; ", text)
    found += [_short(match[1], match[2], brief[match.end() :].partition(";")[0]) for match in SHORT.finditer(brief)]
    yield from found
    stated = {reference.fields.get("doi") for reference in found}
    yield from (Reference("misc", (), {"doi": doi}) for doi in re.findall(_DOI, text) if doi not in stated)


def _full(people: str, year: str, rest: str) -> Reference:
    persons = [_person(person) for person in re.findall(_PERSON, people)]
    doi = re.search(_DOI, rest)
    stated = re.sub(rf",? ?{_DOI}.*", "", rest).strip().rstrip(".")
    title, _, place = stated.partition(". ")
    known = {"author": " and ".join(f"{last}, {first}" for last, first in persons), "title": title, "year": year}
    if doi:
        known["doi"] = doi[1]
    surnames = tuple(last for last, _ in persons)
    if notes := re.fullmatch(r"([^,]+), (unpublished .*)", stated):
        return Reference("unpublished", surnames, known | {"title": notes[1], "note": notes[2]})
    for kind, pattern in KINDS.items():
        if match := pattern.fullmatch(place):
            found = {name: value for name, value in match.groupdict().items() if value}
            if "editor" in found:
                found["editor"] = " and ".join(", ".join(_person(one)) for one in re.findall(_PERSON, found["editor"]))
            return Reference(kind, surnames, known | found)
    return Reference("misc", surnames, known | ({"howpublished": place} if place else {}))


def _short(people: str, year: str, rest: str) -> Reference:
    surnames = tuple(re.findall(_NAME, people))
    known = {"author": " and ".join(surnames), "year": year}
    for pattern in TAILS:
        if match := pattern.match(rest):
            found = {name: value for name, value in match.groupdict().items() if value}
            return Reference("article" if "journal" in found else "misc", surnames, known | found)
    return Reference("misc", surnames, known)


def _person(text: str) -> tuple[str, str]:
    """Return surname and initials."""
    match = re.fullmatch(r"(.*?) ((?:[^\W\d_a-z]\.-?\s?)+)", text)
    assert match is not None, "a person has initials"
    return match[1], match[2]


def _same(known: Reference, found: Reference) -> bool:
    one, other = (reference.fields.get("doi", "").lower() for reference in (known, found))
    if one and other:
        return one == other
    if not found.surnames or [*map(_plain, known.surnames)] != [*map(_plain, found.surnames)]:
        return False
    if known.fields.get("year") != found.fields.get("year"):
        return False
    return not _title(known) or not _title(found) or _title(known) == _title(found)


def _title(reference: Reference) -> str:
    return reference.fields.get("title", "").lower()


def _entry(reference: Reference, key: str) -> str:
    lines = [f"@{reference.kind}{{{key},"]
    for name in ORDER:
        if value := reference.fields.get(name):
            shown = value if name == "doi" else value.translate(ESCAPES)
            if name == "pages":
                shown = shown.replace("-", "--")
            lines.append(f"  {name} = {{{{{shown}}}}}," if name in ("title", "booktitle") else f"  {name} = {{{shown}}},")
    return "\n".join([*lines, "}"])


def _key(reference: Reference, taken: set[str]) -> str:
    name = re.sub(r"[^a-z0-9]", "", _plain(reference.surnames[0])) if reference.surnames else "source"
    base = f"{name or 'source'}{reference.fields.get('year', '')}"
    key = next(one for one in (base, *(f"{base}-{k}" for k in range(2, 10_000))) if one not in taken)
    taken.add(key)
    return key


def _names(surnames: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(surnames[:-1]), surnames[-1])))


def _plain(text: str) -> str:
    return unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().lower()

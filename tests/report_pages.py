"""Pages of a report, read by a parser that accepts no mistake."""

import json
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from mpmverify.dataset.files import Results


class Page(HTMLParser):
    """Checks that tags are balanced, and collects identifiers, links, resources, text and scripts."""

    VOID = frozenset(("meta", "link", "input", "br", "hr", "img"))

    def __init__(self, path: Path) -> None:
        super().__init__(convert_charrefs=True)
        self.path, self.open = path, []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.resources: list[str] = []
        self.labelled: list[str] = []
        self.text: list[str] = []
        self.cells: list[str] = []
        self.data: list[str] = []
        self.scripts = 0
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list) -> None:
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names)), f"<{tag}> repeats an attribute"
        assert not any(name.startswith("on") for name in names)
        table = dict(attrs)
        if "id" in table:
            self.ids.append(table["id"])
        if tag in ("a", "use"):
            self.links.append(table["href"])
        elif tag in ("link", "script", "img"):
            self.resources += [table[name] for name in ("href", "src") if name in table]
        self.labelled += [table[name] for name in ("aria-labelledby",) if name in table]
        if tag == "script":
            self.scripts += 1
        if tag in ("td", "th"):
            self.cells.append("")
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open[-1] == tag, f"</{tag}> closes <{self.open[-1]}> at {self.getpos()}"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "script":
            self.data.append(data)
            return
        self.text.append(data)
        if "td" in self.open or "th" in self.open:
            self.cells[-1] += data


def pages(results: Results) -> dict[str, Page]:
    return {path.relative_to(results.report).as_posix(): Page(path) for path in results.report.rglob("*.html")}


def broken_links(results: Results, known: dict[str, Page], name: str) -> list[str]:
    """Links of a page whose file or anchor does not exist."""
    broken = []
    for link in known[name].links:
        target, _, anchor = link.partition("#")
        path = ((results.report / name).parent / target if target else results.report / name).resolve()
        if link.startswith(
            ("https://doi.org/", "compare.html#a=", "data:application/x-bibtex")
        ):  # these say what the page shows
            continue
        if not path.exists() or (
            anchor and unquote(anchor) not in known[path.relative_to(results.report.resolve()).as_posix()].ids
        ):
            broken.append(link)
    return broken


def strict(text: str) -> dict:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def stamps(results: Results) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in results.report.rglob("*") if path.is_file()}

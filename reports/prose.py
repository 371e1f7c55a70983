"""Markdown as HTML: headings with anchors, code and tables that scroll, links between pages; HTML in a text is shown as text."""

import re
from collections.abc import Callable, MutableMapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from markdown_it.utils import OptionsDict

from .highlight import highlighted
from .parts import Link

LANGUAGES = {"sh": "Shell", "python": "Python", "yaml": "YAML", "csv": "CSV"}
TAKEN = ("content", "provenance")
"""Identifiers of the page around a text."""
NARROW = 3
"""Largest number of columns of a table whose rows are shown as blocks on a narrow screen; wider tables scroll."""
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_FILE = re.compile(r"<!-- file: (\S+) -->")


@dataclass(frozen=True)
class Heading:
    """A heading below the title: `level` is 2 for a section."""

    level: int
    text: str
    anchor: str


@dataclass(frozen=True)
class Prose:
    """A text as HTML.

    Parameters
    ----------
    title : str
        The first heading of level 1, which is not part of `html`.
    headings : tuple of Heading
    links : tuple of Link
        All links that lead somewhere, in their order.
    html : str
    """

    title: str
    headings: tuple[Heading, ...]
    links: tuple[Link, ...]
    html: str


def prose(text: str, target: Callable[[str], str | None]) -> Prose:
    """Convert Markdown, with tables as on GitHub, to HTML.

    Parameters
    ----------
    text : str
    target : callable
        Returns the address that a link or a picture has on the page, or None if it leads nowhere there: of a link its text is left, of
        a picture its description.
    """
    engine = MarkdownIt("commonmark", renderer_cls=_Renderer).enable("table")
    tokens = engine.parse(text)
    links = [link for token in tokens for link in _aim(token, target)]
    _shape_tables(tokens)
    _shape_blocks(tokens)
    title, headings, tokens = _section(tokens)
    return Prose(title, tuple(headings), tuple(links), engine.renderer.render(tokens, engine.options, {}))


def anchor(heading: str) -> str:
    """Convert a heading to its anchor, as GitHub does."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _plain(token: Token) -> str:
    return "".join(child.content for child in token.children or () if child.type in ("text", "code_inline", "text_special"))


def _aim(token: Token, target: Callable[[str], str | None]) -> list[Link]:
    """Give the links and pictures of a passage their addresses on the page, and return the links."""
    links: list[Link] = []
    children = token.children or []
    for k, child in enumerate(children):
        if child.type == "image":
            if (source := target(str(child.attrs["src"]))) is not None:
                child.attrs["src"] = source
            else:
                child.type, child.content = "text", _plain(child) or child.content
        elif child.type == "link_open":
            end = next(n for n in range(k, len(children)) if children[n].type == "link_close")
            if (href := target(str(child.attrs["href"]))) is not None:
                child.attrs["href"] = href
                links.append(Link("".join(part.content for part in children[k:end]), href))
            else:
                child.tag = children[end].tag = "span"
                child.attrs = {}
    return links


def _shape_tables(tokens: Sequence[Token]) -> None:
    """Make empty heads plain cells, and give the cells of narrow tables the heads that they are read by when rows become blocks."""
    heads: list[str] = []
    column = 0
    for k, token in enumerate(tokens):
        if token.type == "table_open":
            heads = [_plain(tokens[n + 1]) for n in _until(tokens, k, "thead_close") if tokens[n].type == "th_open"]
            token.meta["columns"] = len(heads)
        elif token.type == "tr_open":
            column = 0
        elif token.type == "th_open":
            if tokens[k + 1].content:
                token.attrSet("scope", "col")
            else:
                token.tag = tokens[k + 2].tag = "td"
        elif token.type == "td_open":
            if len(heads) == NARROW and column and heads[column]:
                token.attrSet("data-head", heads[column])
            column += 1


def _until(tokens: Sequence[Token], start: int, kind: str) -> range:
    return range(start, next(n for n in range(start, len(tokens)) if tokens[n].type == kind))


def _shape_blocks(tokens: Sequence[Token]) -> None:
    """Give a block of code the name of its file from the comment before it, and let a paragraph that is a picture scroll."""
    for k, token in enumerate(tokens):
        if token.type == "fence" and k and (named := _FILE.search(tokens[k - 1].content)):
            token.meta["file"] = named[1]
        elif token.type == "inline" and [child.type for child in token.children or ()] == ["image"]:
            opening, closing = tokens[k - 1], tokens[k + 1]
            if opening.type == "paragraph_open":
                opening.type, closing.type = "picture_open", "picture_close"


def _section(tokens: Sequence[Token]) -> tuple[str, list[Heading], list[Token]]:
    """Take the title out, give every heading an anchor, and wrap the passage below each heading of level 2 in a section."""
    title, headings, names = "", list[Heading](), set(TAKEN)
    shaped, close = list[Token](), list[Token]()
    remaining = iter(tokens)
    for token in remaining:
        if token.type != "heading_open":
            shaped.append(token)
            continue
        passage, closing = next(remaining), next(remaining)
        level, text = int(token.tag[1:]), _plain(passage)
        if level == 1 and not title:
            title = text
            continue
        heading = Heading(level, text, _unique(anchor(text), names))
        headings.append(heading)
        link = Token("permalink", "a", 0, content=text, attrs={"href": f"#{heading.anchor}"})
        passage.children = [*(passage.children or ()), link]
        if level == 2 and token.level == 0:  # a heading in a list or a quotation cannot begin a section of the page
            shaped += [*close, Token("section_open", "section", 1, attrs={"id": heading.anchor}, block=True)]
            close = [Token("section_close", "section", -1, block=True)]
        else:
            token.attrSet("id", heading.anchor)
        shaped += [token, passage, closing]
    return title, headings, shaped + close


def _unique(name: str, taken: set[str]) -> str:
    numbered, k = name, 0
    while numbered in taken or not numbered:
        k += 1
        numbered = f"{name}-{k}"
    taken.add(numbered)
    return numbered


class _Renderer(RendererHTML):
    """Rules of the tokens that are not rendered as usual; the engine calls a rule by the name of the token."""

    def html_block(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        shown = _COMMENT.sub("", tokens[idx].content).strip()
        return f"<p>{escape(shown)}</p>\n" if shown else ""

    def html_inline(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        return escape(_COMMENT.sub("", tokens[idx].content))

    def fence(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        token, name = tokens[idx], tokens[idx].meta.get("file", "")
        language = LANGUAGES.get(token.info.strip(), "Text")
        head = f'<p class="file">{escape(name)}</p>\n' if name else ""
        region = _region("scroll", f"{name or language}, block {_next(env, 'block')}")
        return f'<div class="code">\n{head}{region}<pre><code>{highlighted(token.content, token.info.strip())}</code></pre></div>\n</div>\n'

    code_block = fence

    def table_open(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        kind = ' class="listed"' if tokens[idx].meta["columns"] <= NARROW else ""
        return _region("scroll", f"Table {_next(env, 'table')}") + f"<table{kind}>\n"

    def table_close(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        return "</table></div>\n"

    def picture_open(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        return _region("scroll picture", f"Picture {_next(env, 'picture')}")

    def picture_close(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        return "</div>\n"

    def permalink(self, tokens: Sequence[Token], idx: int, options: OptionsDict, env: MutableMapping[str, Any]) -> str:
        token = tokens[idx]
        label = escape(f"Link to: {token.content}")
        return f' <a class="permalink" href="{escape(str(token.attrs["href"]))}" aria-label="{label}">#</a>'


def _region(kind: str, label: str) -> str:
    return f'<div class="{kind}" tabindex="0" role="region" aria-label="{escape(label)}">'


def _next(env: MutableMapping[str, Any], kind: str) -> int:
    env[kind] = env.get(kind, 0) + 1
    return int(env[kind])

"""The pages of the handbook, made from its Markdown."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import urlsplit

from .manifest import HANDBOOK_INDEX, handbook_name
from .parts import Link, Origin
from .prose import Heading, Prose, prose

SCHEMES = ("http", "https", "mailto")


@dataclass(frozen=True)
class Section:
    """A section in the table of contents, with the sections in it."""

    link: Link
    parts: tuple[Link, ...]


@dataclass(frozen=True)
class HandbookPage:
    """A page of the handbook.

    Parameters
    ----------
    title, generator, root : str
    navigation : tuple of Link
    kicker : str
        Name of the handbook; "" on its index.
    chapters : tuple of Link
        The pages of the handbook in their order; none on its index, whose text lists them.
    sections : tuple of Section
    body : str
        HTML.
    previous, following : Link or None
        The pages before and after this one.
    origins : tuple of Origin
        None: the handbook is not made of results.
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    kicker: str
    chapters: tuple[Link, ...]
    sections: tuple[Section, ...]
    body: str
    previous: Link | None
    following: Link | None
    origins: tuple[Origin, ...] = ()


def handbook_pages(texts: Mapping[str, str], generator: str) -> dict[str, HandbookPage]:
    """Make the pages of the handbook.

    Parameters
    ----------
    texts : mapping of str to str
        Text of each file of the handbook, by its name; a picture may have any text.
    generator : str
        Name and version of the program.

    Returns
    -------
    dict of str to HandbookPage
        By the name of the page in the report. The order is that in which the index lists them; what it does not list comes last.
    """
    rendered = {
        name: prose(text, lambda address: _target(address, texts.keys()))
        for name, text in texts.items()
        if name.endswith(".md")
    }
    files = {_address(name): name for name in rendered}
    listed = [files[link.href] for link in rendered[HANDBOOK_INDEX].links if link.href in files]
    order = list(dict.fromkeys([HANDBOOK_INDEX, *listed, *rendered]))
    links = [Link(rendered[name].title or name, _address(name)) for name in order]
    return {handbook_name(name): _page(rendered[name], links, k, generator) for k, name in enumerate(order)}


def _page(text: Prose, links: Sequence[Link], k: int, generator: str) -> HandbookPage:
    """Make the page of the text that is the `k`-th of the handbook."""
    index, *chapters = links
    return HandbookPage(
        title=text.title,
        generator=generator,
        root="../",
        navigation=(
            Link("Overview", "../index.html"),
            Link("Solvers", "../solvers.html"),
            Link("Problems", "../problems.html"),
        ),
        kicker=index.text if k else "",
        chapters=tuple(replace(link, current=link == links[k]) for link in chapters) if k else (),
        sections=_sections(text.headings),
        body=text.html,
        previous=links[k - 1] if k else None,
        following=links[k + 1] if k + 1 < len(links) else None,
    )


def _sections(headings: Sequence[Heading]) -> tuple[Section, ...]:
    """Return the table of contents: headings of level 2, each with those of level 3 below it."""
    starts = [k for k, heading in enumerate(headings) if heading.level == 2]
    return tuple(
        Section(_link(headings[start]), tuple(_link(heading) for heading in headings[start:end] if heading.level == 3))
        for start, end in zip(starts, [*starts[1:], len(headings)], strict=False)
    )


def _link(heading: Heading) -> Link:
    return Link(heading.text, f"#{heading.anchor}")


def _address(name: str) -> str:
    return f"{Path(handbook_name(name)).name}.html"


def _target(address: str, names: Collection[str]) -> str | None:
    """Return the address on the page of a link or picture in a text: other sites and files of the handbook, nothing else."""
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return address if parts.scheme in SCHEMES else None
    anchor = f"#{parts.fragment}" if parts.fragment else ""
    if not parts.path:
        return anchor or None
    if parts.path not in names:
        return None
    return (_address(parts.path) if parts.path.endswith(".md") else parts.path) + anchor

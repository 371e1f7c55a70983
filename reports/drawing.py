"""A drawing of the domain of a problem with its bodies, supports and loads, as SVG made from the stored set-up."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from markupsafe import escape

Point = tuple[float, float]

WIDTH, HEIGHT, MARGIN = 320.0, 210.0, 38.0
"""Box of the drawing and the room around the domain for the symbols of the faces."""
THICKNESS, BAR = 26.0, 104.0
"""Height at which a bar is drawn, and of its drawing."""
DEPTH: Point = (0.42, -0.32)
"""Where the third axis points, as a share of its length."""
MEANING = {
    "clamped": "hatched: clamped",
    "slip": "wall on circles: no normal velocity, free to slip",
    "moved": "wall with an arrow: prescribed normal velocity",
    "loaded": "arrows: prescribed traction",
    "free": "",
    "periodic": "dashed: joined to the opposite face",
    "absorbing": "arcs: lets waves out",
    "inflow": "arrows into the domain: prescribed inflow",
    "outflow": "arrows out of the domain: outflow",
}
"""What the symbol of each kind of face means."""


class Body(NamedTuple):
    """A body: a block from `lower` to `upper`, or a disk or ring around `center`."""

    kind: str
    numbers: Mapping[str, tuple[float, ...]]


def drawing(setup: Mapping[str, str]) -> tuple[str, str]:
    """Draw a problem.

    Parameters
    ----------
    setup : mapping of str to str
        Domain, body and faces as the study file states them.

    Returns
    -------
    svg, caption : str
        The caption explains the symbols that occur.
    """
    ranges = [(float(a), float(b)) for a, b in re.findall(r"\[([^,\]]+), ([^\]]+)\]", setup["domain"])]
    place = _Place(ranges)
    faces = {name.removeprefix("face "): _kind(value, len(ranges)) for name, value in setup.items() if name.startswith("face ")}
    parts = [
        *_domain(place, full="body" not in setup),
        *(shape for body in _bodies(setup.get("body", "")) for shape in _body(body, place)),
    ]
    for face, kind in faces.items():
        axis, side = "xyz".index(face[0]), 1 if face[-1] == "+" else -1
        if axis < 2:
            parts += _symbol(kind, *place.face(axis, side))
    parts += _axes(place)
    meanings = dict.fromkeys(MEANING.get(kind, "") for kind in faces.values() if MEANING.get(kind))
    if len(ranges) == 3:
        meanings["the faces along z are in the table"] = None
    caption = "; ".join(meanings)
    label = f"Domain {setup['domain']}; " + ", ".join(f"{face} {kind}" for face, kind in faces.items())
    box = f"0 {HEIGHT / 2 - BAR / 2:g} {WIDTH:g} {BAR:g}" if len(ranges) == 1 else f"0 0 {WIDTH:g} {HEIGHT:g}"
    svg = f'<svg class="drawing" viewBox="{box}" role="img" aria-label="{escape(label)}">{"".join(parts)}</svg>'
    return svg, f"{caption[:1].upper()}{caption[1:]}." if caption else ""


def _kind(condition: str, dimension: int) -> str:
    """Return the kind of a face; a wall that holds the normal velocity clamps a bar and lets a body slip."""
    name = re.split(r"[ ,:\[]", condition, maxsplit=1)[0]
    still = re.fullmatch(r"(velocity|traction) -?0(\.0*)? \S+", condition) is not None
    if name == "velocity":
        return ("clamped" if dimension == 1 else "slip") if still else "moved"
    if name == "traction":
        return "free" if still else "loaded"
    return {"fixed": "clamped"}.get(name, name)


class _Place:
    """Maps positions [m] to the drawing, on one scale for all axes."""

    def __init__(self, ranges: Sequence[tuple[float, float]]) -> None:
        self.ranges, self.dimension = ranges, len(ranges)
        extent = [high - low for low, high in ranges] + [0.0] * (3 - len(ranges))
        across, up = extent[0] + DEPTH[0] * extent[2], extent[1] - DEPTH[1] * extent[2]
        self.scale = min((WIDTH - 2 * MARGIN) / across, (HEIGHT - 2 * MARGIN) / up if up else float("inf"))
        height = THICKNESS if self.dimension == 1 else self.scale * up
        self.left, self.bottom = (WIDTH - self.scale * across) / 2, (HEIGHT + height) / 2

    def __call__(self, x: float, y: float | None = None, z: float | None = None) -> Point:
        depth = 0.0 if z is None else self.scale * (z - self.ranges[2][0])
        up = 0.0 if y is None else self.scale * (y - self.ranges[1][0])
        return self.left + self.scale * (x - self.ranges[0][0]) + DEPTH[0] * depth, self.bottom - up + DEPTH[1] * depth

    def face(self, axis: int, side: int) -> tuple[Point, Point, Point]:
        """Return the ends of a face, in front, and its outward direction."""
        (x0, y0), (x1, y1) = self.box()
        if axis == 0:
            x = x1 if side > 0 else x0
            return (x, y0), (x, y1), (float(side), 0.0)
        y = y1 if side > 0 else y0
        return (x0, y), (x1, y), (0.0, -float(side))

    def box(self) -> tuple[Point, Point]:
        """Return the corners of the domain in front: at the lower ends of the axes, and at the upper ends."""
        x0, y0 = self(self.ranges[0][0])
        if self.dimension == 1:
            return (x0, y0), (self(self.ranges[0][1])[0], y0 - THICKNESS)
        return (x0, y0), self(self.ranges[0][1], self.ranges[1][1])


def _domain(place: _Place, *, full: bool) -> Iterator[str]:
    """Draw the domain, filled if the body fills it."""
    (x0, y0), (x1, y1) = place.box()
    if place.dimension == 3:
        depth = place.scale * (place.ranges[2][1] - place.ranges[2][0])
        dx, dy = DEPTH[0] * depth, DEPTH[1] * depth
        yield f'<path class="behind" d="M{x0 + dx:.1f} {y0 + dy:.1f}H{x1 + dx:.1f}V{y1 + dy:.1f}H{x0 + dx:.1f}Z"/>'
        for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)):
            yield f'<path class="behind" d="M{x:.1f} {y:.1f}l{dx:.1f} {dy:.1f}"/>'
    yield f'<rect class="{"body" if full else "domain"}" x="{x0:.1f}" y="{y1:.1f}" width="{x1 - x0:.1f}" height="{y0 - y1:.1f}"/>'


def _bodies(text: str) -> Iterator[Body]:
    for part in filter(None, text.split(" and ")):
        numbers = {
            name: tuple(float(number) for number in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", value))
            for name, value in re.findall(r"(\w+) = (\([^)]*\)|[^,]+)", part)
        }
        yield Body(part.partition(",")[0], numbers)


def _body(body: Body, place: _Place) -> Iterator[str]:
    n = body.numbers
    if body.kind == "block" and "lower" in n and "upper" in n:
        depths = [n["lower"][2], n["upper"][2]] if place.dimension == 3 else [None]
        for z in reversed(depths):  # the far side first
            (x0, y0), (x1, y1) = (
                place(*n["lower"][:2], *([z] if z is not None else [])),
                place(*n["upper"][:2], *([z] if z is not None else [])),
            )
            if place.dimension == 1:
                y1 = y0 - THICKNESS
            yield f'<rect class="body" x="{x0:.1f}" y="{y1:.1f}" width="{x1 - x0:.1f}" height="{y0 - y1:.1f}"/>'
    elif place.dimension == 2 and body.kind in ("disk", "ring") and "center" in n:
        x, y = place(*n["center"])
        radii = [n[name][0] * place.scale for name in ("radius", "outer", "inner") if name in n]
        circles = "".join(
            f"M{x - r:.1f} {y:.1f}a{r:.1f} {r:.1f} 0 1 0 {2 * r:.1f} 0a{r:.1f} {r:.1f} 0 1 0 {-2 * r:.1f} 0Z" for r in radii
        )
        yield f'<path class="body" fill-rule="evenodd" d="{circles}"/>'


def _symbol(kind: str, begin: Point, end: Point, out: Point) -> Iterator[str]:
    """Draw the symbol of a face from `begin` to `end`, on its side `out`."""

    def at(share: float, away: float) -> Point:
        return (
            begin[0] + share * (end[0] - begin[0]) + away * out[0],
            begin[1] + share * (end[1] - begin[1]) + away * out[1],
        )

    def line(start: Point, stop: Point, style: str = "wall") -> str:
        return f'<path class="{style}" d="M{start[0]:.1f} {start[1]:.1f}L{stop[0]:.1f} {stop[1]:.1f}"/>'

    def arrow(share: float, start: float, stop: float) -> Iterator[str]:
        tip, tail = at(share, stop), at(share, start)
        back = 5.0 if stop > start else -5.0
        yield line(tail, tip, "load")
        x, y = at(share, stop - back)
        sx, sy = 3.0 * out[1], 3.0 * out[0]
        yield f'<path class="head" d="M{tip[0]:.1f} {tip[1]:.1f}L{x + sx:.1f} {y + sy:.1f}L{x - sx:.1f} {y - sy:.1f}Z"/>'

    length = abs(end[0] - begin[0]) + abs(end[1] - begin[1])
    many = [(k + 0.5) / n for n in [max(1, round(length / 28))] for k in range(n)]
    wall = 7.0 if kind == "slip" else 0.0
    if kind in ("clamped", "slip", "moved"):
        yield line(at(0, wall), at(1, wall))
    if kind == "clamped":
        count = max(3, round(length / 8))
        for k in range(count):
            yield line(at((k + 1) / count, 0), at(k / count, 7), "hatch")
    elif kind == "slip":
        for share in many:
            x, y = at(share, wall / 2)
            yield f'<circle class="roller" cx="{x:.1f}" cy="{y:.1f}" r="3"/>'
    elif kind == "moved":
        yield from arrow(0.5, 4, 24)
    elif kind in ("loaded", "outflow"):
        for share in many:
            yield from arrow(share, 2, 22)
    elif kind == "inflow":
        for share in many:
            yield from arrow(share, 24, 3)
    elif kind == "periodic":
        yield line(at(0, 4), at(1, 4), "joined")
    elif kind == "absorbing":
        for away in (5.0, 10.0, 15.0):
            yield line(at(0.15, away), at(0.85, away), "hatch")


def _axes(place: _Place) -> Iterator[str]:
    """Draw the coordinates of the ends of the domain."""
    (x0, y0), (x1, y1) = place.box()
    low, high = place.ranges[0]
    y = min(y0 + 34, HEIGHT - 3)
    yield f'<text x="{x0:.1f}" y="{y:.1f}" text-anchor="middle">{low:g}</text>'
    yield f'<text x="{x1:.1f}" y="{y:.1f}" text-anchor="middle">{high:g} m</text>'
    yield f'<text x="{(x0 + x1) / 2:.1f}" y="{y:.1f}" text-anchor="middle" class="axis">{"X" if place.dimension == 1 else "x"}</text>'
    if place.dimension > 1:
        x = x0 - 27
        yield f'<text x="{x:.1f}" y="{y0:.1f}" text-anchor="end">{place.ranges[1][0]:g}</text>'
        yield f'<text x="{x:.1f}" y="{y1 + 8:.1f}" text-anchor="end">{place.ranges[1][1]:g}</text>'
        yield f'<text x="{x:.1f}" y="{(y0 + y1) / 2 + 4:.1f}" text-anchor="end" class="axis">y</text>'

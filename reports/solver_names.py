"""Names of solvers: the page that each has, the family that it belongs to, and the choices that its text states."""

import ast
import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping
from functools import cache

from .manifest import SOLVER
from .notation import DASH, slug
from .parts import Fact
from .record import Record

FAMILIES: Mapping[str, str] = {
    "MaterialPoint": "Material point methods",
    "Textbook": "Material point methods",
    "FiniteElement": "Finite elements",
    "TaylorGalerkin": "Taylor-Galerkin schemes",
}
"""Families by the class of a shipped solver; every other solver is a stranger's."""
OWN = "Your own solvers"
MEASUREMENT, MEASURED = "Bisection", "limit-"
"""Class of a solver that measures the stability limit of another one, and the beginning of its name."""
WORDS = {"None": "none", "True": "yes", "False": "no"}
LONGEST = 80
"""Largest number of characters of a name in the name of a file, which must have less than 255 bytes."""


def page_of(solver: str, scheme: str) -> str:
    """Return the file of the page of a solver."""
    return file_of(subject(solver, scheme))


def pages_of(record: Record) -> dict[str, str]:
    """Return the file of the page of every solver of a study."""
    return {solver: page_of(solver, scheme) for solver, scheme in record.schemes.items()}


def subject(solver: str, scheme: str) -> str:
    """Return the solver that a series tells about: a measurement of the stability limit belongs to the solver that it measures."""
    measured = scheme.partition("(")[0] == MEASUREMENT and solver.startswith(MEASURED)
    return solver.removeprefix(MEASURED) if measured else solver


def file_of(solver: str) -> str:
    """Return the file of a page by the name of its solver alone.

    A name that is no plain word of a file gets a digest: two names never share a file, and no other solver changes it.
    """
    plain = slug(solver)
    if plain == solver and len(plain) <= LONGEST:
        return f"{SOLVER}{plain}.html"
    return f"{SOLVER}{plain[:LONGEST].strip('-')}-{hashlib.sha256(solver.encode('utf-8', 'replace')).hexdigest()[:8]}.html"


def family(schemes: Iterable[str]) -> str:
    """Return the family of a solver, by the class that begins the text of its scheme."""
    kinds = Counter(FAMILIES.get(plain_scheme(scheme).partition("(")[0], OWN) for scheme in schemes)
    return next((kind for kind, _ in kinds.most_common(1)), OWN)


@cache
def plain_scheme(scheme: str) -> str:
    """Return the scheme of a solver; that of the measured one for a measurement of its stability limit."""
    call = _call(scheme)
    if call is None or ast.unparse(call.func) != MEASUREMENT:
        return scheme if call is None else ast.unparse(call)
    inner = [keyword.value for keyword in call.keywords if keyword.arg == "solver"]
    return ast.unparse(inner[0]) if inner else scheme


@cache
def choices(scheme: str) -> tuple[Fact, ...]:
    """Return the choices of a scheme by name: "MaterialPoint(schedule='USL')" has a schedule.

    A text that is no call with named values is shown as it is.
    """
    call = _call(scheme)
    if call is None or not call.keywords or call.args:
        return (Fact("scheme", scheme),)
    return tuple(Fact((entry.arg or "").replace("_", " "), _value(entry.value)) for entry in call.keywords)


def _call(scheme: str) -> ast.Call | None:
    try:
        body = ast.parse(scheme, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    return body if isinstance(body, ast.Call) else None


def _value(node: ast.expr) -> str:
    """Format a value; a nested choice by its name, followed by its own choices."""
    if isinstance(node, ast.Constant):
        return WORDS.get(str(node.value), str(node.value)) or DASH
    if isinstance(node, ast.Call) and node.keywords and not node.args:
        values = {entry.arg or "": _value(entry.value) for entry in node.keywords}
        name = values.pop("name", ast.unparse(node.func))
        rest = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in values.items())
        return f"{name} ({rest})" if rest else name
    return ast.unparse(node)

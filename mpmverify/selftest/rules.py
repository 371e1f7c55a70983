"""Faults by rule: every place of the numerical functions to which a rule applies, found in the syntax tree, patched in the text.

Notes
-----
A rule is applied wherever it applies, in every function of a solver family but those in which a solver only speaks of itself
(its name, its orders) and but refusals of a problem, messages, clocks and counts of work: none of these changes a result.
Branches of other dimensions are left out as long as every trial has one: the compiler drops them.

`sampled` takes, of every family and every rule, the same number of places: those whose identities have the lowest SHA-256.
An identity is made of the rule, the file and the patch, not of a line: a change elsewhere in the file draws no other sample, and
nobody chooses.
"""

import ast
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from .faults import Fault
from .syntax import Patch, Source, names

COMPILERS: Mapping[str, tuple[str, ...]] = {"mpm": ("tracing",)}
"""Packages beside a family that write its code: a fault of theirs is one of the family."""
TIME_STEPS = {"dt", "leap", "kick"}
END_WORDS = {"held", "loaded", "bounded", "side", "face", "end", "condition", "inwards"}
"""Words by which code of a boundary is known, in the test of a branch, as the variable of a loop or as the table that it reads."""
SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+="}
REVERSED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "!=", "!=": "==", "is": "is not", "is not": "is"}
SYMBOL: dict[type, str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Lt: "<",
    ast.Gt: ">",
    ast.LtE: "<=",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Is: "is",
    ast.IsNot: "is not",
}


Rule = Callable[[Source, ast.AST], Iterator[Patch]]


def operator(source: Source, node: ast.AST) -> Iterator[Patch]:
    """+ and -, * and /, += and -= swapped."""
    if isinstance(node, ast.BinOp) and type(node.op) in SYMBOL:
        yield source.between(node.left, node.right, SYMBOL[type(node.op)], SWAPPED)
    elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
        yield source.between(node.target, node.value, SYMBOL[type(node.op)] + "=", SWAPPED)


def index(source: Source, node: ast.AST) -> Iterator[Patch]:
    """I for i + 1 or i - 1, i + 1 for i, 0 for -1, -1 for 0, one less for another number."""
    if not isinstance(node, ast.Subscript):
        return
    for entry in node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]:
        number = _integer(entry)
        if number is not None:
            yield source.replaced(entry, {0: "-1", -1: "0"}.get(number, str(number - 1)))
        elif isinstance(entry, ast.Name):
            yield source.replaced(entry, f"{entry.id} + 1")
            yield source.replaced(entry, f"{entry.id} - 1")
        elif isinstance(entry, ast.BinOp) and _integer(entry.right) is not None:
            yield source.replaced(entry, source.text(entry.left))


def factor(source: Source, node: ast.AST) -> Iterator[Patch]:
    """A number that multiplies, divides or is a power becomes 1."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div | ast.Pow):
        for side in (node.left, node.right):
            if isinstance(side, ast.Constant) and side.value not in (0, 1):
                yield source.replaced(side, "1")


def sign(source: Source, node: ast.AST) -> Iterator[Patch]:
    """A minus lost, or the value of an array's element negated."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield source.replaced(node, source.wrapped(node.operand))
    elif isinstance(node, ast.Assign) and _elements(node) and not isinstance(node.value, ast.Tuple | ast.List | ast.Constant):
        yield source.replaced(node.value, f"-({source.text(node.value)})")


def time_step(source: Source, node: ast.AST) -> Iterator[Patch]:
    """dt, or a share of it, dropped from a product; dt/2 for dt."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        for mine, other in ((node.left, node.right), (node.right, node.left)):
            if _last_name(mine) in TIME_STEPS:
                yield source.replaced(node, source.wrapped(other))
    operands: list[ast.expr] = []
    if isinstance(node, ast.BinOp):
        operands = [node.left, node.right]
    elif isinstance(node, ast.Call):
        operands = node.args
    for operand in operands:
        if _last_name(operand) in TIME_STEPS:
            yield source.replaced(operand, f"({source.text(operand)} / 2)")


def term(source: Source, node: ast.AST) -> Iterator[Patch]:
    """A term dropped from a sum or a difference."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        yield source.replaced(node, source.wrapped(node.left))
        yield source.replaced(
            node, source.wrapped(node.right) if isinstance(node.op, ast.Add) else f"-({source.text(node.right)})"
        )


def assignment(source: Source, node: ast.AST) -> Iterator[Patch]:
    """An augmented assignment, or one to an array's element, dropped."""
    if isinstance(node, ast.AugAssign) or (isinstance(node, ast.Assign) and _elements(node) and not _resets(node)):
        yield source.replaced(node, "pass")


def stale_array(source: Source, node: ast.AST) -> Iterator[Patch]:
    """An array neither reset nor updated: an assignment of a constant or to all of it, or a call for its effect, dropped."""
    called = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    if called or (isinstance(node, ast.Assign) and _elements(node) and _resets(node)):
        yield source.replaced(node, "pass")


def comparison(source: Source, node: ast.AST) -> Iterator[Patch]:
    """A comparison reversed, by `equal` and `logical_not` in traced code, too."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SYMBOL:
        yield source.between(node.left, node.comparators[0], SYMBOL[type(node.ops[0])], REVERSED)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "equal":
        yield source.replaced(node, f"where({source.text(node)}, False, True)")
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "logical_not":
        yield source.replaced(node, source.wrapped(node.args[0]))


def arguments(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Two neighbouring arguments of the same type swapped in a call of the solver's own functions and records."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        kinds = source.signatures.get(node.func.id, [])
        for (one, kind), (two, other) in pairwise(zip(node.args, kinds, strict=False)):
            if kind == other != "":
                yield source.swapped(one, two)


def transposed(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Two neighbouring indices of an array swapped."""
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
        for one, two in pairwise(node.slice.elts):
            if not isinstance(one, ast.Slice) and not isinstance(two, ast.Slice):
                yield source.swapped(one, two)


def wrong_array(source: Source, node: ast.AST) -> Iterator[Patch]:
    """The next array of the same type in the same record, as in `stencil.gradient` for `stencil.value`."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        for other in source.neighbours(node.value.id, node.attr):
            yield source.replaced(node, f"{node.value.id}.{other}")


def boundary(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Code of the ends of a body dropped, or applied at one end alone: at the first, or in traced code at those after it."""
    if isinstance(node, ast.If) and not source.is_elif(node) and names(node.test) & END_WORDS:
        yield source.replaced(node, "pass")
    elif isinstance(node, ast.For):
        tables = _attributes(node.iter) & END_WORDS
        if names(node.target) & END_WORDS or tables:
            yield source.replaced(node, "pass")
        if source.text(node.iter) == "range(2)" and names(node.target) & END_WORDS:
            yield source.replaced(node.iter, "range(1)")
        elif tables and isinstance(node.iter, ast.Call):
            yield source.replaced(node.iter, f"range(min(1, {source.text(node.iter.args[0])}))")
    elif isinstance(node, ast.With) and _attributes(node.items[0].context_expr) & END_WORDS:
        yield source.replaced(node, "pass")
        if isinstance(loop := node.items[0].context_expr, ast.Call):
            yield source.replaced(loop.args[0], "1")


RULES: Mapping[str, Rule] = {
    "operator": operator,
    "index": index,
    "factor": factor,
    "sign": sign,
    "time-step": time_step,
    "term": term,
    "assignment": assignment,
    "stale-array": stale_array,
    "comparison": comparison,
    "arguments": arguments,
    "transposed": transposed,
    "wrong-array": wrong_array,
    "boundary": boundary,
}


def _integer(node: ast.AST) -> int | None:
    """Value of an integer literal, its sign included."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and (number := _integer(node.operand)) is not None:
        return -number
    return node.value if isinstance(node, ast.Constant) and type(node.value) is int else None


def _last_name(node: ast.AST) -> str:
    """A name, or that of an attribute; nothing of another expression."""
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def _attributes(node: ast.AST) -> set[str]:
    return {entry.attr for entry in ast.walk(node) if isinstance(entry, ast.Attribute)}


def _elements(node: ast.Assign) -> bool:
    return all(isinstance(target, ast.Subscript) for target in node.targets)


def _resets(node: ast.Assign) -> bool:
    return isinstance(node.value, ast.Constant) or any(
        isinstance(target, ast.Subscript) and isinstance(target.slice, ast.Slice) for target in node.targets
    )


def faults(sources: Path, family: str, *, plain: bool = False) -> list[Fault]:
    """All faults by rule of one family and of its compiler, each once, in the order of the files.

    Parameters
    ----------
    sources : Path
        Folder of the solvers.
    family : str
    plain : bool
        Whether no trial has more than one dimension.
    """
    found: dict[str, Fault] = {}
    paths = [path for folder in (family, *COMPILERS.get(family, ())) for path in sorted((sources / folder).glob("*.py"))]
    for path in paths:
        source = Source(path, sources, paths, plain=plain)
        for node in source.numerical():
            for rule, apply in RULES.items():
                for patch in apply(source, node):
                    if source.parses(node, patch):
                        fault = Fault(family, rule, f"{rule} in {source.function(node).name}", (source.edit(patch),))
                        found.setdefault(fault.id, fault)
    return list(found.values())


def sampled(found: Sequence[Fault], each: int) -> list[Fault]:
    """Draw at most `each` faults of every family and rule, those whose identity has the lowest digest."""
    strata: dict[tuple[str, str], list[Fault]] = {}
    for fault in found:
        strata.setdefault((fault.family, fault.rule), []).append(fault)
    return [fault for members in strata.values() for fault in sorted(members, key=_rank)[:each]]


def _rank(fault: Fault) -> str:
    return hashlib.sha256(fault.id.encode()).hexdigest()

"""Faults by rule: each rule patches the source of the numerical functions at every place of the syntax tree where it applies.

Notes
-----
Code that cannot change a result is left out: functions that describe a solver (its name, its orders), the rejection of problems,
messages, timing and counts of work. If all trials are one-dimensional, branches for other dimensions are left out, too, because
the compiler drops them.

`sampled` draws the same number of faults from each family and rule: those whose ids have the lowest SHA-256 digests. The id
depends on the rule, the file and the patch, not on line numbers, so the sample does not change when other parts of the file do,
and nobody can select the faults.
"""

import ast
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from .faults import Fault
from .syntax import Patch, Source, declared_in, names

COMPILERS: Mapping[str, tuple[str, ...]] = {"mpm": ("tracing",)}
"""Packages that generate the code of a family: their faults count as faults of the family."""
TIME_STEPS = {"dt", "leap", "kick"}
BOUNDARY_WORDS = {"held", "loaded", "bounded", "side", "face", "end", "condition", "inwards"}
"""Names that mark boundary code: in the condition of a branch, as the variable of a loop, or as the table that a loop reads."""
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
    """Swap + and -, * and /, += and -=."""
    if isinstance(node, ast.BinOp) and type(node.op) in SYMBOL:
        yield source.between(node.left, node.right, SYMBOL[type(node.op)], SWAPPED)
    elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub):
        yield source.between(node.target, node.value, SYMBOL[type(node.op)] + "=", SWAPPED)


def index(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Shift an index: i to i + 1 and i - 1, i + 1 to i, 0 to -1, -1 to 0, and any other number down by one."""
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
    """Replace a numerical factor, divisor or exponent by 1."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div | ast.Pow):
        for side in (node.left, node.right):
            if isinstance(side, ast.Constant) and side.value not in (0, 1):
                yield source.replaced(side, "1")


def sign(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Drop a minus sign, or negate the value that is assigned to an array element."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield source.replaced(node, source.wrapped(node.operand))
    elif isinstance(node, ast.Assign) and _elements(node) and not isinstance(node.value, ast.Tuple | ast.List | ast.Constant):
        yield source.replaced(node.value, f"-({source.text(node.value)})")


def time_step(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Drop a time step from a product, or halve it."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        for operand, other in ((node.left, node.right), (node.right, node.left)):
            if _last_name(operand) in TIME_STEPS:
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
    """Drop a term from a sum or a difference."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        yield source.replaced(node, source.wrapped(node.left))
        yield source.replaced(
            node, source.wrapped(node.right) if isinstance(node.op, ast.Add) else f"-({source.text(node.right)})"
        )


def assignment(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Drop an augmented assignment, or an assignment to an array element."""
    if isinstance(node, ast.AugAssign) or (isinstance(node, ast.Assign) and _elements(node) and not _resets(node)):
        yield source.replaced(node, "pass")


def stale_array(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Leave an array stale: drop an assignment of a constant or of a whole slice, or a call whose result is unused."""
    called = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    if called or (isinstance(node, ast.Assign) and _elements(node) and _resets(node)):
        yield source.replaced(node, "pass")


def comparison(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Reverse a comparison, including `equal` and `logical_not` in traced code."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SYMBOL:
        yield source.between(node.left, node.comparators[0], SYMBOL[type(node.ops[0])], REVERSED)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "equal":
        yield source.replaced(node, f"where({source.text(node)}, False, True)")
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "logical_not":
        yield source.replaced(node, source.wrapped(node.args[0]))


def arguments(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Swap two adjacent arguments of the same type in a call of a function or record of the family."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        kinds = source.declared.signatures.get(node.func.id, [])
        for (one, kind), (two, other) in pairwise(zip(node.args, kinds, strict=False)):
            if kind == other != "":
                yield source.swapped(one, two)


def transposed(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Swap two adjacent indices of an array."""
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
        for one, two in pairwise(node.slice.elts):
            if not isinstance(one, ast.Slice) and not isinstance(two, ast.Slice):
                yield source.swapped(one, two)


def wrong_array(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Use the next field of the same type in the same record: `stencil.gradient` for `stencil.value`, say."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        for other in source.next_of_same_type(node.value.id, node.attr):
            yield source.replaced(node, f"{node.value.id}.{other}")


def boundary(source: Source, node: ast.AST) -> Iterator[Patch]:
    """Drop boundary code, or apply it at the first end only; in traced code, at all ends except the first."""
    if isinstance(node, ast.If) and not source.is_elif(node) and names(node.test) & BOUNDARY_WORDS:
        yield source.replaced(node, "pass")
    elif isinstance(node, ast.For):
        tables = _attributes(node.iter) & BOUNDARY_WORDS
        if names(node.target) & BOUNDARY_WORDS or tables:
            yield source.replaced(node, "pass")
        if source.text(node.iter) == "range(2)" and names(node.target) & BOUNDARY_WORDS:
            yield source.replaced(node.iter, "range(1)")
        elif tables and isinstance(node.iter, ast.Call):
            yield source.replaced(node.iter, f"range(min(1, {source.text(node.iter.args[0])}))")
    elif isinstance(node, ast.With) and _attributes(node.items[0].context_expr) & BOUNDARY_WORDS:
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
    """Return the value of an integer literal with its sign, or None for any other expression."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and (number := _integer(node.operand)) is not None:
        return -number
    return node.value if isinstance(node, ast.Constant) and type(node.value) is int else None


def _last_name(node: ast.AST) -> str:
    """Return a name or the name of an attribute; "" for any other expression."""
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def _attributes(node: ast.AST) -> set[str]:
    return {entry.attr for entry in ast.walk(node) if isinstance(entry, ast.Attribute)}


def _elements(node: ast.Assign) -> bool:
    return all(isinstance(target, ast.Subscript) for target in node.targets)


def _resets(node: ast.Assign) -> bool:
    return isinstance(node.value, ast.Constant) or any(
        isinstance(target, ast.Subscript) and isinstance(target.slice, ast.Slice) for target in node.targets
    )


def faults(sources: Path, family: str, *, one_dimensional: bool = False) -> list[Fault]:
    """Return all faults by rule of one family and its code generators, without duplicates, in the order of the files.

    Parameters
    ----------
    sources : Path
        Folder of the solvers.
    family : str
    one_dimensional : bool
        Whether all trials are one-dimensional.
    """
    found: dict[str, Fault] = {}
    paths = [path for folder in (family, *COMPILERS.get(family, ())) for path in sorted((sources / folder).glob("*.py"))]
    declared = declared_in(paths)
    for path in paths:
        source = Source(path, sources, declared, one_dimensional=one_dimensional)
        for node in source.numerical():
            for rule, apply in RULES.items():
                for patch in apply(source, node):
                    if source.parses(node, patch):
                        fault = Fault(family, rule, f"{rule} in {source.function(node).name}", (source.edit(patch),))
                        found.setdefault(fault.id, fault)
    return list(found.values())


def sampled(found: Sequence[Fault], count: int) -> list[Fault]:
    """Draw at most `count` faults of each family and rule: those whose ids have the lowest digests."""
    strata: dict[tuple[str, str], list[Fault]] = {}
    for fault in found:
        strata.setdefault((fault.family, fault.rule), []).append(fault)
    return [fault for members in strata.values() for fault in sorted(members, key=_rank)[:count]]


def _rank(fault: Fault) -> str:
    return hashlib.sha256(fault.id.encode()).hexdigest()

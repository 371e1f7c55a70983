"""Source files with their syntax trees: the position of an expression in the text, and patches of it."""

import ast
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from .faults import Edit

DESCRIPTIVE = {"name", "orders", "coarse_orders", "_damped", "space_orders", "conserves", "kernel", "__post_init__"}
"""Functions that describe or set up a solver and compute no results."""
NON_NUMERICAL = {"require", "Work", "perf_counter", "compile", "typeof", "isinstance", "cast"}
"""Calls that reject a problem, measure time and work, or compile: nothing inside them changes a result."""

_IN_ONE_DIMENSION = re.compile(r"len\(\w+\) == 1")


@dataclass(frozen=True)
class Patch:
    """Replacement for a passage of the text, given by its offsets in characters."""

    begin: int
    end: int
    new: str


def names(node: ast.AST) -> set[str]:
    """Return all names and attributes in an expression."""
    found = {entry.id for entry in ast.walk(node) if isinstance(entry, ast.Name)}
    return found | {entry.attr for entry in ast.walk(node) if isinstance(entry, ast.Attribute)}


@dataclass(frozen=True)
class Declarations:
    """Types that the functions and records of a family declare.

    Parameters
    ----------
    records : mapping of str to mapping
        Annotation of each field, by the name of the record.
    signatures : mapping of str to list
        Annotations of the parameters of each function and record; "" for a parameter without one.
    """

    records: Mapping[str, Mapping[str, str]]
    signatures: Mapping[str, list[str]]


def declared_in(paths: Iterable[Path]) -> Declarations:
    """Return what files declare."""
    nodes = [node for path in paths for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    records = {  # `_is_field` accepts annotated names only, which the type checker cannot know
        node.name: {f.target.id: ast.dump(f.annotation) for f in node.body if _is_field(f)}  # type: ignore[attr-defined]
        for node in nodes
        if isinstance(node, ast.ClassDef) and "NamedTuple" in {name for base in node.bases for name in names(base)}
    }
    signatures = {name: list(fields.values()) for name, fields in records.items()} | {
        node.name: [ast.dump(entry.annotation) if entry.annotation else "" for entry in node.args.args]
        for node in nodes
        if isinstance(node, ast.FunctionDef)
    }
    return Declarations(records, signatures)


class Source:
    """One file of a solver family.

    Parameters
    ----------
    path : Path
    root : Path
        Folder of the solvers.
    declared : Declarations
        By all files of the family.
    one_dimensional : bool
        Whether all problems are one-dimensional; code for other dimensions is then not numerical.
    """

    def __init__(self, path: Path, root: Path, declared: Declarations, *, one_dimensional: bool) -> None:
        self.file = path.relative_to(root).as_posix()
        self.whole = path.read_text(encoding="utf-8")
        self.tree = ast.parse(self.whole)
        self.parent = {child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)}
        self._unreached = set(_branches_of_other_dimensions(self.tree)) if one_dimensional else set()
        self._lines = self.whole.splitlines(keepends=True)
        self._starts = [sum(map(len, self._lines[:k])) for k in range(len(self._lines))]
        self.declared = declared

    # Positions of nodes. Only expressions and statements have one; the type `ast.AST` has none, hence the ignored type errors.

    def begin(self, node: ast.AST) -> int:
        return self._offset(node.lineno, node.col_offset)  # type: ignore[attr-defined]

    def end(self, node: ast.AST) -> int:
        return self._offset(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]

    def _offset(self, line: int, column: int) -> int:
        """Return the offset in characters; the tree counts columns in bytes."""
        return self._starts[line - 1] + len(self._lines[line - 1].encode()[:column].decode())

    def text(self, node: ast.AST) -> str:
        return self.whole[self.begin(node) : self.end(node)]

    def wrapped(self, node: ast.AST) -> str:
        """Return the text of an expression, in brackets unless it can be an operand as it is."""
        whole = isinstance(node, ast.Name | ast.Constant | ast.Attribute | ast.Subscript | ast.Call)
        return self.text(node) if whole else f"({self.text(node)})"

    # Patches.

    def replaced(self, node: ast.AST, new: str) -> Patch:
        return Patch(self.begin(node), self.end(node), new)

    def swapped(self, one: ast.AST, two: ast.AST) -> Patch:
        """Swap two expressions."""
        gap = self.whole[self.end(one) : self.begin(two)]
        return Patch(self.begin(one), self.end(two), self.text(two) + gap + self.text(one))

    def between(self, left: ast.AST, right: ast.AST, symbol: str, others: Mapping[str, str]) -> Patch:
        """Replace the operator between two operands; only brackets and white space surround it there."""
        at = self.whole.index(symbol, self.end(left), self.begin(right))
        return Patch(at, at + len(symbol), others[symbol])

    def edit(self, patch: Patch) -> Edit:
        """Return a patch as an edit of whole lines, which still applies when other parts of the file change."""
        begin, end = self.whole.rfind("\n", 0, patch.begin) + 1, self.whole.find("\n", patch.end)
        old = self.whole[begin:end]
        new = self.whole[begin : patch.begin] + patch.new + self.whole[patch.end : end]
        return Edit(self.file, old, new, self.whole.count(old, 0, begin), self.whole.count(old))

    # Numerical code.

    def numerical(self) -> Iterator[ast.AST]:
        """Yield the syntax nodes of the functions that compute results; one that returns a text computes a message."""
        for node in ast.walk(self.tree):
            if (
                not isinstance(node, ast.FunctionDef)
                or isinstance(self.parent[node], ast.FunctionDef)
                or node.name in DESCRIPTIVE
                or (isinstance(node.returns, ast.Name) and node.returns.id == "str")
            ):
                continue
            for statement in node.body:
                yield from self._inside(statement)

    def _inside(self, node: ast.AST) -> Iterator[ast.AST]:
        if (
            node in self._unreached
            or isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr | ast.arguments)
            or _is_non_numerical(node)
        ):
            return
        yield node
        for child in ast.iter_child_nodes(node):
            yield from self._inside(child)

    def is_elif(self, node: ast.If) -> bool:
        above = self.parent[node]
        return isinstance(above, ast.If) and node in above.orelse and self.text(node).startswith("elif")

    def function(self, node: ast.AST) -> ast.FunctionDef:
        """Return the outermost function that contains a node."""
        while not (isinstance(node, ast.FunctionDef) and isinstance(self.parent[node], ast.Module | ast.ClassDef)):
            node = self.parent[node]
        return node

    def parses(self, node: ast.AST, patch: Patch) -> bool:
        """Whether the function that contains a node changes by a patch and is still valid Python."""
        function = self.function(node)
        begin, end = self._starts[function.lineno - 1], self.end(function)
        if self.whole[patch.begin : patch.end] == patch.new:
            return False
        try:
            ast.parse(textwrap.dedent(self.whole[begin : patch.begin] + patch.new + self.whole[patch.end : end]))
        except SyntaxError:
            return False
        return True

    def next_of_same_type(self, variable: str, attribute: str) -> list[str]:
        """Return the next field of the same type in a record, in a list; an empty list if there is none.

        The name of the variable, capitalised, gives the record.
        """
        record = self.declared.records.get(variable.capitalize(), {})
        alike = [name for name, kind in record.items() if kind == record.get(attribute)]
        return [alike[(alike.index(attribute) + 1) % len(alike)]] if len(alike) > 1 else []


def _branches_of_other_dimensions(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements that do not run if `len(x) == 1`: the else branch, and all that follows if the branch returns."""
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if not isinstance(body, list):  # the body of a lambda is an expression
            continue
        for k, statement in enumerate(body):
            if isinstance(statement, ast.If) and _IN_ONE_DIMENSION.fullmatch(ast.unparse(statement.test)):
                yield from statement.orelse
                if isinstance(statement.body[-1], ast.Return):
                    yield from body[k + 1 :]


def _is_non_numerical(node: ast.AST) -> bool:
    """Whether a node is a docstring, or a call or statement that rejects, measures or compiles."""
    if isinstance(node, ast.Expr | ast.Assign | ast.AugAssign):
        return (isinstance(node.value, ast.Constant) and isinstance(node, ast.Expr)) or any(
            isinstance(entry, ast.Call) and names(entry.func) & {"perf_counter", "compile", "require", "_check"}
            for entry in ast.walk(node)
        )
    return isinstance(node, ast.Call) and bool(names(node.func) & NON_NUMERICAL)


def _is_field(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)

"""A source file and its syntax tree: where an expression stands in the text, and what replaces it."""

import ast
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from .faults import Edit

OF_ITSELF = {"name", "orders", "space_orders", "conserves", "kernel", "__post_init__"}
"""Functions in which a solver speaks of itself."""
NO_RESULT = {"require", "Work", "perf_counter", "compile", "typeof", "isinstance", "cast"}
"""Calls that refuse a problem, measure time and work, or compile: nothing inside changes a result."""

_IN_ONE_DIMENSION = re.compile(r"len\(\w+\) == 1")


@dataclass(frozen=True)
class Patch:
    """Offsets of a passage in the text, and what replaces it."""

    begin: int
    end: int
    new: str


def names(node: ast.AST) -> set[str]:
    """Names and attributes that an expression mentions."""
    found = {entry.id for entry in ast.walk(node) if isinstance(entry, ast.Name)}
    return found | {entry.attr for entry in ast.walk(node) if isinstance(entry, ast.Attribute)}


class Source:
    """One file of a solver family.

    Parameters
    ----------
    path : Path
    root : Path
        Folder of the solvers.
    siblings : iterable of Path
        Files of the family: its functions and records tell what is of one type.
    plain : bool
        Whether all problems have one dimension: what branches at the length of a tuple leave to others is no result then.
    """

    def __init__(self, path: Path, root: Path, siblings: Iterable[Path], *, plain: bool) -> None:
        self.file = path.relative_to(root).as_posix()
        self.whole = path.read_text(encoding="utf-8")
        self.tree = ast.parse(self.whole)
        self.parent = {child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)}
        self._spatial = set(_spatial(self.tree)) if plain else set()
        self._lines = self.whole.splitlines(keepends=True)
        self._starts = [sum(map(len, self._lines[:k])) for k in range(len(self._lines))]
        trees = [ast.parse(sibling.read_text(encoding="utf-8")) for sibling in siblings]
        nodes = [node for tree in trees for node in ast.walk(tree)]
        self._records = {  # what `_is_field` lets through is an annotated name, which its type cannot say
            node.name: {f.target.id: ast.dump(f.annotation) for f in node.body if _is_field(f)}  # type: ignore[attr-defined]
            for node in nodes
            if isinstance(node, ast.ClassDef) and "NamedTuple" in {name for base in node.bases for name in names(base)}
        }
        self.signatures = {name: list(fields.values()) for name, fields in self._records.items()} | {
            node.name: [ast.dump(entry.annotation) if entry.annotation else "" for entry in node.args.args]
            for node in nodes
            if isinstance(node, ast.FunctionDef)
        }
        """Types of the parameters of the family's functions and records; nothing for one that is not annotated."""

    # Where nodes stand. Only expressions and statements are asked, which have a place; the type of any node has none.

    def begin(self, node: ast.AST) -> int:
        return self._offset(node.lineno, node.col_offset)  # type: ignore[attr-defined]

    def end(self, node: ast.AST) -> int:
        return self._offset(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]

    def _offset(self, line: int, column: int) -> int:
        """Offset in characters; the tree counts columns in bytes."""
        return self._starts[line - 1] + len(self._lines[line - 1].encode()[:column].decode())

    def text(self, node: ast.AST) -> str:
        return self.whole[self.begin(node) : self.end(node)]

    def wrapped(self, node: ast.AST) -> str:
        """Text of an expression that may stand as an operand."""
        whole = isinstance(node, ast.Name | ast.Constant | ast.Attribute | ast.Subscript | ast.Call)
        return self.text(node) if whole else f"({self.text(node)})"

    # What replaces them.

    def replaced(self, node: ast.AST, new: str) -> Patch:
        return Patch(self.begin(node), self.end(node), new)

    def swapped(self, one: ast.AST, two: ast.AST) -> Patch:
        """Two expressions in each other's place."""
        gap = self.whole[self.end(one) : self.begin(two)]
        return Patch(self.begin(one), self.end(two), self.text(two) + gap + self.text(one))

    def between(self, left: ast.AST, right: ast.AST, symbol: str, others: Mapping[str, str]) -> Patch:
        """Another operator between two operands; nothing but brackets and space stands there beside it."""
        at = self.whole.index(symbol, self.end(left), self.begin(right))
        return Patch(at, at + len(symbol), others[symbol])

    def edit(self, patch: Patch) -> Edit:
        """Patch as an edit of the lines that it touches: they find their place again wherever the file changes elsewhere."""
        begin, end = self.whole.rfind("\n", 0, patch.begin) + 1, self.whole.find("\n", patch.end)
        old = self.whole[begin:end]
        new = self.whole[begin : patch.begin] + patch.new + self.whole[patch.end : end]
        return Edit(self.file, old, new, self.whole.count(old, 0, begin), self.whole.count(old))

    # What is numerical.

    def numerical(self) -> Iterator[ast.AST]:
        """Nodes of the functions that make results."""
        for node in ast.walk(self.tree):
            if (
                not isinstance(node, ast.FunctionDef)
                or isinstance(self.parent[node], ast.FunctionDef)
                or node.name in OF_ITSELF
            ):
                continue
            for statement in node.body:
                yield from self._inside(statement)

    def _inside(self, node: ast.AST) -> Iterator[ast.AST]:
        if (
            node in self._spatial
            or isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr | ast.arguments)
            or _is_silent(node)
        ):
            return
        yield node
        for child in ast.iter_child_nodes(node):
            yield from self._inside(child)

    def is_elif(self, node: ast.If) -> bool:
        above = self.parent[node]
        return isinstance(above, ast.If) and node in above.orelse and self.text(node).startswith("elif")

    def function(self, node: ast.AST) -> ast.FunctionDef:
        """Outermost function that a node stands in."""
        while not (isinstance(node, ast.FunctionDef) and isinstance(self.parent[node], ast.Module | ast.ClassDef)):
            node = self.parent[node]
        return node

    def parses(self, node: ast.AST, patch: Patch) -> bool:
        """Whether the function around a node is Python still, and another one than before."""
        function = self.function(node)
        begin, end = self._starts[function.lineno - 1], self.end(function)
        if self.whole[patch.begin : patch.end] == patch.new:
            return False
        try:
            ast.parse(textwrap.dedent(self.whole[begin : patch.begin] + patch.new + self.whole[patch.end : end]))
        except SyntaxError:
            return False
        return True

    def neighbours(self, variable: str, attribute: str) -> list[str]:
        """Next field of the same type in a record, by the name of a variable that holds one; none where there is no other."""
        record = self._records.get(variable.capitalize(), {})
        alike = [name for name, kind in record.items() if kind == record.get(attribute)]
        return [alike[(alike.index(attribute) + 1) % len(alike)]] if len(alike) > 1 else []


def _spatial(tree: ast.AST) -> Iterator[ast.AST]:
    """Statements that a tuple of length 1 never comes to: the other branches of `len(x) == 1`, and what follows its return."""
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if not isinstance(body, list):  # an expression's, as of a lambda
            continue
        for k, statement in enumerate(body):
            if isinstance(statement, ast.If) and _IN_ONE_DIMENSION.fullmatch(ast.unparse(statement.test)):
                yield from statement.orelse
                if isinstance(statement.body[-1], ast.Return):
                    yield from body[k + 1 :]


def _is_silent(node: ast.AST) -> bool:
    """Whether a node refuses, measures, compiles or documents: a call, or a statement that holds nothing else."""
    if isinstance(node, ast.Expr | ast.Assign | ast.AugAssign):
        return (isinstance(node.value, ast.Constant) and isinstance(node, ast.Expr)) or any(
            isinstance(entry, ast.Call) and names(entry.func) & {"perf_counter", "compile", "require", "_check"}
            for entry in ast.walk(node)
        )
    return isinstance(node, ast.Call) and bool(names(node.func) & NO_RESULT)


def _is_field(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)

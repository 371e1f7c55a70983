"""Nested tuples of values and arrays: taken apart into code, and put together again."""

from collections.abc import Iterator
from typing import Any

from llvmlite import ir

from .arrays import Array
from .values import Value


def flatten(tree: Any) -> list[ir.Value]:
    """Code that the values and arrays of a tree consist of, in order; numbers of Python have none."""
    if isinstance(tree, tuple):
        return [code for item in tree for code in flatten(item)]
    if isinstance(tree, Array):
        return [tree.data, *(length.code for length in tree.shape)]
    return [tree.code] if isinstance(tree, Value) else []


def unflatten(tree: Any, builder: ir.IRBuilder, codes: Iterator[ir.Value]) -> Any:
    """Return a tree of the same structure that consists of other code."""
    if isinstance(tree, tuple):
        items = [unflatten(item, builder, codes) for item in tree]
        return type(tree)(*items) if hasattr(tree, "_fields") else tuple(items)
    if isinstance(tree, Array):
        return Array(builder, tree.kind, next(codes), [next(codes) for _ in tree.shape])
    return Value(builder, next(codes)) if isinstance(tree, Value) else tree


def builder_of(tree: Any) -> Any:
    """Return the builder of the first value or array in a tree; None if there is none."""
    if not isinstance(tree, tuple):
        return getattr(tree, "builder", None)
    return next((found for found in map(builder_of, tree) if found is not None), None)

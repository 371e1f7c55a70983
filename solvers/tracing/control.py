"""The way that compiled code takes: what a traced function has for loops and branches on values."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from llvmlite import ir
from numba.core import cgutils

from .values import KINDS, WHOLE, Memory, Value, code_of, equal, rank


@contextmanager
def each(begin: Any, end: Any, step: int = 1, like: Any = None) -> Iterator[Any]:
    """A loop over begin <= i < end; what is within writes its body, and leaves nothing but what it stores.

    Where both are numbers of Python, `like` is a value or an array of the function that it is a loop of.
    """
    (builder, *_) = (x.builder for x in (begin, end, like) if isinstance(x, Value | Memory))
    first, last, by = (code_of(builder, x, WHOLE) for x in (begin, end, step))
    with cgutils.for_range_slice(builder, first, last, by) as (i, _):
        yield Value(builder, i)


@contextmanager
def as_long_as(builder: ir.IRBuilder, condition: Callable[[], Value]) -> Iterator[None]:
    """A loop that goes on as long as what the function returns is true, which it writes code for."""
    again, body, after = (builder.append_basic_block(name) for name in ("again", "body", "after"))
    builder.branch(again)
    builder.position_at_end(again)
    builder.cbranch(condition().code, body, after)
    builder.position_at_end(body)
    yield
    builder.branch(again)
    builder.position_at_end(after)


@contextmanager
def walk(begin: Any, end: Any) -> Iterator[tuple[Any, Callable[[Any], None]]]:
    """A loop over begin <= p < end whose body calls a function, last, that says by how much it goes on."""
    place = Kept(begin)
    with as_long_as(begin.builder, lambda: place.value < end):
        p = place.value

        def go_on(by: Any) -> None:
            place.value = p + by

        yield p, go_on


@contextmanager
def when(truth: Any) -> Iterator[None]:
    """What is within happens where something is true, and leaves nothing but what it stores."""
    with truth.builder.if_then(truth.code):
        yield


def either(truth: Any, then: Any, otherwise: Any) -> Any:
    """The first where something is true, else the second: values or tuples of these, or functions that return such.

    What one of two functions writes happens, where `where` has both computed. Of two numbers of Python one becomes as the other.
    """
    if not isinstance(truth, Value):
        return _result(then if truth else otherwise)
    builder, found = truth.builder, []
    with builder.if_else(truth.code) as branches:
        for branch, way in zip(branches, (then, otherwise), strict=True):
            with branch:
                found.append((_result(way), builder.block))
    return _merged(builder, *found)


def one_of(number: Any, ways: dict[int, Any], otherwise: Any) -> Any:
    """What one of some ways leads to, by its number, as `either` of many."""
    for k, way in ways.items():
        otherwise = partial(either, equal(number, k), way, otherwise)
    return _result(otherwise)


def _result(way: Any) -> Any:
    return way() if callable(way) else way


def _merged(builder: ir.IRBuilder, a: tuple[Any, ir.Block], b: tuple[Any, ir.Block]) -> Any:
    """One of two values, or tuples of these, by the block that code comes from."""
    (x, from_x), (y, from_y) = a, b
    if isinstance(x, tuple):
        return tuple(_merged(builder, (p, from_x), (q, from_y)) for p, q in zip(x, y, strict=True))
    kind = KINDS[max(rank(x), rank(y))][0]
    phi = builder.phi(kind)
    for value, block in ((x, from_x), (y, from_y)):
        with builder.goto_block(block):
            phi.add_incoming(code_of(builder, value, kind), block)
    return Value(builder, phi)


class Kept:
    """A number that loops and branches may change: of the kind of its first value, or of that of a value `like` it."""

    def __init__(self, first: Any, like: Any = None) -> None:
        kind = first if like is None else like
        self.builder, self.kind = kind.builder, kind.code.type
        self.place = cgutils.alloca_once(self.builder, self.kind)
        self.value = first

    @property
    def value(self) -> Any:
        return Value(self.builder, self.builder.load(self.place))

    @value.setter
    def value(self, x: Any) -> None:
        self.builder.store(code_of(self.builder, x, self.kind), self.place)

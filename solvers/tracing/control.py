"""Control flow at run time: what a traced function has for loops and branches on values.

Loops and branches are context managers whose body emits the code inside. A body leaves nothing but what it stores: to an array, or to
a `Variable`.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from llvmlite import ir

from .arrays import Array
from .selection import equal
from .values import BOOLEAN, INTEGER, KINDS, Value, as_code, on_stack, rank


@contextmanager
def for_range(begin: Any, end: Any, step: int = 1, like: Any = None) -> Iterator[Any]:
    """Loop over begin <= i < end; yields i.

    Parameters
    ----------
    begin, end : int or Value
    step : int
        Positive.
    like : Value or Array, optional
        Any value or array of the enclosing traced function; needed where begin and end are numbers of Python.
    """
    (builder, *_) = (x.builder for x in (begin, end, like) if isinstance(x, Value | Array))
    first, last, by = (as_code(builder, x, INTEGER) for x in (begin, end, step))
    before = builder.block
    check, body, after = (builder.append_basic_block(name) for name in ("check", "body", "after"))
    builder.branch(check)
    builder.position_at_end(check)
    i = builder.phi(INTEGER)
    builder.cbranch(builder.icmp_signed("<", i, last), body, after)
    builder.position_at_end(body)
    yield Value(builder, i)
    i.add_incoming(first, before)
    i.add_incoming(builder.add(i, by), builder.block)
    builder.branch(check)
    builder.position_at_end(after)


@contextmanager
def while_loop(condition: Callable[[], Value], like: Any) -> Iterator[None]:
    """Loop while a condition holds.

    Parameters
    ----------
    condition : callable
        Emits the code of the condition, which is evaluated before each round.
    like : Value or Array
        Any value or array of the enclosing traced function.
    """
    builder = like.builder
    check, body, after = (builder.append_basic_block(name) for name in ("check", "body", "after"))
    builder.branch(check)
    builder.position_at_end(check)
    builder.cbranch(condition().code, body, after)
    builder.position_at_end(body)
    yield
    builder.branch(check)
    builder.position_at_end(after)


@contextmanager
def for_strides(begin: Any, end: Any) -> Iterator[tuple[Any, Callable[[Any], None]]]:
    """Loop over begin <= i < end by strides that the body chooses; yields i and `advance`, and the body ends with `advance(stride)`."""
    place = Variable(begin)
    with while_loop(lambda: place.value < end, begin):
        i = place.value

        def advance(stride: Any) -> None:
            place.value = i + stride

        yield i, advance


@contextmanager
def leavable(like: Any) -> Iterator[Callable[[Any], None]]:
    """Code that can be left before its end; yields `leave`, and `leave(condition)` goes on after the code if the condition holds.

    Parameters
    ----------
    like : Value or Array
        Any value or array of the enclosing traced function.
    """
    builder = like.builder
    after = builder.append_basic_block("after")

    left = False

    def leave(condition: Any) -> None:
        if left:
            raise TypeError("code that has ended cannot be left: call `leave` inside its `with`")
        stays = builder.append_basic_block("stays")
        builder.cbranch(as_code(builder, condition, BOOLEAN), after, stays)
        builder.position_at_end(stays)

    yield leave
    left = True
    builder.branch(after)
    builder.position_at_end(after)


@contextmanager
def when(condition: Any) -> Iterator[None]:
    """Run the body if a condition holds."""
    with condition.builder.if_then(condition.code):
        yield


def cond(condition: Any, then: Any, otherwise: Any) -> Any:
    """Return the first of two results where a condition holds, else the second.

    Parameters
    ----------
    condition : bool or Value
        A single one, not one for each lane.
    then, otherwise : callable, number, Value or tuple of these
        Alike in structure; numbers are promoted to the higher of two kinds. A callable takes no arguments, and only the one that
        is chosen runs, where `where` computes both.
    """
    if not isinstance(condition, Value):
        return _called(then if condition else otherwise)
    builder, found = condition.builder, []
    with builder.if_else(condition.code) as branches:
        for branch, result in zip(branches, (then, otherwise), strict=True):
            with branch:
                found.append((_called(result), builder.block))
    return _merged(builder, *found)


def switch(index: Any, branches: dict[int, Any], default: Any) -> Any:
    """Return the result of the branch that an integer names, or the default; branches as those of `cond`."""
    for k, branch in branches.items():
        default = partial(cond, equal(index, k), branch, default)
    return _called(default)


def _called(result: Any) -> Any:
    return result() if callable(result) else result


def _merged(builder: ir.IRBuilder, a: tuple[Any, ir.Block], b: tuple[Any, ir.Block]) -> Any:
    """One of two results, each given with the block that computes it."""
    (x, from_x), (y, from_y) = a, b
    if isinstance(x, tuple):
        return tuple(_merged(builder, (p, from_x), (q, from_y)) for p, q in zip(x, y, strict=True))
    kind = KINDS[max(rank(x), rank(y))]
    phi = builder.phi(kind)
    for value, block in ((x, from_x), (y, from_y)):
        with builder.goto_block(block):
            phi.add_incoming(as_code(builder, value, kind), block)
    return Value(builder, phi)


class Variable:
    """A number that loops and branches may change: read and assign `value`.

    Parameters
    ----------
    first : float or Value
        Its first value.
    like : Value, optional
        Of the kind that the variable keeps; needed where the first value is a number of Python.
    """

    def __init__(self, first: Any, like: Any = None) -> None:
        kind = first if like is None else like
        self.builder, self.kind = kind.builder, kind.code.type
        self.place = on_stack(self.builder, self.kind)
        self.value = first

    @property
    def value(self) -> Any:
        return Value(self.builder, self.builder.load(self.place, typ=self.kind))

    @value.setter
    def value(self, x: Any) -> None:
        self.builder.store(as_code(self.builder, x, self.kind), self.place)

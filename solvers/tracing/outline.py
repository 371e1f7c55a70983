"""Functions of the compiled module beside the one that is traced: shared by several calls, or run by threads.

Their arguments are stored on the stack in slots of eight bytes, and loaded from there inside.
"""

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any

from llvmlite import ir

from .arrays import Array
from .tracer import traced
from .trees import builder_of, flatten, unflatten
from .values import INTEGER, LANES, VECTOR, Value, as_code, on_stack

BYTES = ir.IntType(8).as_pointer()
"""An address of anything."""
NUMBERS = itertools.count()
"""Counter that makes the names of outlined functions unique."""


def stored(builder: ir.IRBuilder, tree: Any) -> ir.Value:
    """Store what a tree consists of on the stack, and return the address."""
    codes = flatten(tree)
    first, count = _slots(codes)
    data = on_stack(builder, INTEGER, count)
    for k, code in zip(first, codes, strict=True):
        builder.store(code, _slot(builder, data, k, code.type), align=8)
    return builder.bitcast(data, BYTES)


def reloaded(builder: ir.IRBuilder, address: ir.Value, tree: Any) -> Any:
    """Load a tree of the same structure from the address at which one was stored."""
    codes = flatten(tree)
    first, _ = _slots(codes)
    data = builder.bitcast(address, INTEGER.as_pointer())
    found = [
        builder.load(_slot(builder, data, k, code.type), align=8, typ=code.type) for k, code in zip(first, codes, strict=True)
    ]
    return unflatten(tree, builder, iter(found))


def _slots(codes: list[ir.Value]) -> tuple[list[int], int]:
    """Number of the first slot of each code, and of all slots: a vector takes one for each lane, anything else a single one."""
    first = [0, *itertools.accumulate(LANES if code.type == VECTOR else 1 for code in codes)]
    return first[:-1], first[-1]


def _slot(builder: ir.IRBuilder, data: ir.Value, k: int, kind: ir.Type) -> ir.Value:
    """Address of a slot for code of a type."""
    return builder.bitcast(builder.gep(data, [INTEGER(k)], inbounds=True, source_etype=INTEGER), kind.as_pointer())


@contextmanager
def new_function(builder: ir.IRBuilder, kind: ir.FunctionType, name: str) -> Iterator[tuple[ir.Function, ir.IRBuilder]]:
    """Add an internal function to the module; yields it and the builder of its body.

    Raises
    ------
    TypeError
        If the body emits code into the function around it.
    """
    function = ir.Function(builder.module, kind, name)
    function.linkage = "internal"
    around, astray = builder.block, ir.Block(builder.function, "astray")
    builder.position_at_end(astray)
    yield function, ir.IRBuilder(function.append_basic_block())
    builder.position_at_end(around)
    if astray.instructions:
        raise TypeError(
            "the body of another function uses an array or value that is not shared with it: pass it as an argument"
        )


def _types(tree: Any) -> Any:
    """Types of what a tree consists of; TypeError for a number of Python, which would be a constant of the code."""
    if isinstance(tree, tuple):
        return type(tree).__name__, *map(_types, tree)
    if isinstance(tree, Array):
        return tree.kind
    if tree is None:
        return None
    if not isinstance(tree, Value):
        raise TypeError(f"an outlined function takes values of compiled code, not the number of Python {tree!r}")
    return str(tree.code.type)


def outlined(function: Callable[..., int]) -> Any:
    """Trace a function once: all its calls in one compiled function share one internal function.

    Parameters
    ----------
    function : callable
        As of `traced`; returns an integer, and all its calls have arguments of the same types, none of them a number of Python.

    Raises
    ------
    TypeError
        When a call is compiled, for other arguments.
    """
    name = f"{function.__name__}.{next(NUMBERS)}"

    @wraps(function)
    def call(*args: Any) -> Any:
        builder, kinds = builder_of(args), _types(args)
        address, shared = stored(builder, args), builder.module.globals.get(name)
        if shared is None:
            with new_function(builder, ir.FunctionType(INTEGER, [BYTES]), name) as (shared, inside):
                shared.types_of_arguments = kinds
                inside.ret(as_code(inside, function(*reloaded(inside, shared.args[0], args)), INTEGER))
        if shared.types_of_arguments != kinds:
            raise TypeError(
                f"all calls of the outlined {function.__name__} take arguments of the same types: this one has others"
            )
        return Value(builder, builder.call(shared, [address]))

    return traced(call)

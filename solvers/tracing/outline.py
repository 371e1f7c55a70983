"""Functions of compiled code that traced ones write beside that which they are part of: for several calls of it, or for threads.

What both are given is written to memory and read there.
"""

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any

from llvmlite import ir
from numba.core import cgutils

from .tracing import builder_of, traced
from .values import WHOLE, Memory, Value, code_of, leaves, rebuilt

POINTER = ir.IntType(8).as_pointer()
TASK = ir.FunctionType(ir.VoidType(), [POINTER.as_pointer(), WHOLE.as_pointer(), WHOLE.as_pointer(), POINTER])
"""What threads are given to do: where the rounds begin, how many there are, the step from one to the next, and what all share.

The threads are told addresses, no numbers. Rounds begin at the address of what all share, by steps of 1: what that of a thread is more is
the number of its first round.
"""
NUMBERS = itertools.count()
"""Of functions that are written once."""
LAUNCH = ir.FunctionType(ir.VoidType(), [POINTER] * 5 + [WHOLE] * 3)


def _packed(builder: ir.IRBuilder, given: tuple[Any, ...]) -> ir.Value:
    """Address of what values, arrays and tuples of these are made of."""
    code = leaves(given)
    data = cgutils.alloca_once(builder, ir.LiteralStructType([one.type for one in code]))
    for k, one in enumerate(code):
        builder.store(one, cgutils.gep_inbounds(builder, data, 0, k))
    return builder.bitcast(data, POINTER)


def _unpacked(builder: ir.IRBuilder, address: ir.Value, given: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same made of what is at an address."""
    kinds = [one.type for one in leaves(given)]
    data = builder.bitcast(address, ir.LiteralStructType(kinds).as_pointer())
    codes = [builder.load(cgutils.gep_inbounds(builder, data, 0, k)) for k in range(len(kinds))]
    return tuple(rebuilt(given, builder, iter(codes)))


@contextmanager
def _beside(builder: ir.IRBuilder, kind: ir.FunctionType, name: str) -> Iterator[tuple[ir.Function, ir.IRBuilder]]:
    """A new function of the module that is written, and what writes its code; TypeError if more than that is written within."""
    function = ir.Function(builder.module, kind, name)
    function.linkage = "internal"
    around, nowhere = builder.block, ir.Block(builder.function, "nowhere")
    builder.position_at_end(nowhere)
    yield function, ir.IRBuilder(function.append_basic_block())
    builder.position_at_end(around)
    if nowhere.instructions:
        raise TypeError("a function beside another one uses what that one did not share")


def _form(given: Any) -> Any:
    """What values, arrays and tuples are of, by which code for them is told; TypeError for a number of Python, which code would hold."""
    if isinstance(given, tuple):
        return type(given).__name__, *map(_form, given)
    if isinstance(given, Memory):
        return str(given.kind), len(given.shape)
    if not isinstance(given, Value):
        raise TypeError(f"what is written once is given the number of Python {given!r}")
    return str(given.code.type)


def once(function: Callable[..., int]) -> Any:
    """A traced function whose code is written once for all of its calls in a compiled one, which give it values of the same types."""
    name = f"{function.__name__}.{next(NUMBERS)}"

    @wraps(function)
    def call(*args: Any) -> Any:
        builder, form = builder_of(args), _form(args)
        address, written = _packed(builder, args), builder.module.globals.get(name)
        if written is None:
            with _beside(builder, ir.FunctionType(WHOLE, [POINTER]), name) as (written, within):
                written.form = form
                within.ret(code_of(within, function(*_unpacked(within, written.args[0], args)), WHOLE))
        if written.form != form:
            raise TypeError(f"{function.__name__} is written once, and called with values of other types")
        return Value(builder, builder.call(written, [address]))

    return traced(call)


@contextmanager
def in_threads(count: Value, shared: tuple[Any, ...]) -> Iterator[tuple[Value, tuple[Any, ...]]]:
    """Compiled rounds 0 <= k < count in as many threads as numba has; what is within writes one, of k and the `shared` as it is there.

    The threads are started by `numba.get_num_threads()`. They are those of `numba.prange`, which takes a second more to compile.
    """
    builder, data = count.builder, _packed(count.builder, shared)
    with _beside(builder, TASK, builder.module.get_unique_name(f"{builder.function.name}.task")) as (task, within):
        starts, counts, _, address = task.args
        there = _unpacked(within, address, shared)
        first = within.sub(*(within.ptrtoint(one, WHOLE) for one in (within.load(starts), address)))
        with cgutils.for_range_slice(within, first, within.add(first, within.load(counts)), WHOLE(1)) as (k, _):
            yield Value(within, k), there
        within.ret_void()
    start, total, step = (cgutils.alloca_once_value(builder, x) for x in (data, count.code, WHOLE(1)))
    pointers = [builder.bitcast(one, POINTER) for one in (task, start, total, step, data)]
    threads = cgutils.get_or_insert_function(builder.module, ir.FunctionType(WHOLE, []), "get_num_threads")
    launch = cgutils.get_or_insert_function(builder.module, LAUNCH, "numba_parallel_for")
    builder.call(launch, [*pointers, WHOLE(0), WHOLE(1), builder.call(threads, [])])

"""Functions of compiled code that traced ones write beside that which they are part of: for several calls of it, or for threads.

What both are given is written to memory and read there.
"""

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
"""What threads are given to do: the first round, as the distance from the address of what all rounds share, how many, 1, the address."""
LAUNCH = ir.FunctionType(ir.VoidType(), [POINTER] * 5 + [WHOLE] * 3)


def _written(builder: ir.IRBuilder, given: tuple[Any, ...]) -> ir.Value:
    """Address of what values, arrays and tuples of these are made of."""
    code = leaves(given)
    data = cgutils.alloca_once(builder, ir.LiteralStructType([one.type for one in code]))
    for k, one in enumerate(code):
        builder.store(one, cgutils.gep_inbounds(builder, data, 0, k))
    return builder.bitcast(data, POINTER)


def _read(builder: ir.IRBuilder, address: ir.Value, given: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same made of what is at an address."""
    kinds = [one.type for one in leaves(given)]
    data = builder.bitcast(address, ir.LiteralStructType(kinds).as_pointer())
    return tuple(
        rebuilt(given, builder, iter([builder.load(cgutils.gep_inbounds(builder, data, 0, k)) for k in range(len(kinds))]))
    )


def _beside(builder: ir.IRBuilder, kind: ir.FunctionType, name: str) -> tuple[ir.Function, ir.IRBuilder]:
    """A new function of the module that is written, and what writes its code."""
    function = ir.Function(builder.module, kind, name)
    function.linkage = "internal"
    return function, ir.IRBuilder(function.append_basic_block())


def once(function: Callable[..., int]) -> Any:
    """A traced function whose code is written once for all of its calls in a compiled one; it is given no numbers of Python."""

    @wraps(function)
    def call(*args: Any) -> Any:
        builder = builder_of(args)
        address, name = _written(builder, args), f"{function.__name__}.once"
        written = builder.module.globals.get(name)
        if written is None:
            if not _all_compiled(args):
                raise TypeError(f"{function.__name__} is written once, and may be called again with another number of Python")
            written, within = _beside(builder, ir.FunctionType(WHOLE, [POINTER]), name)
            within.ret(code_of(within, function(*_read(within, written.args[0], args)), WHOLE))
        return Value(builder, builder.call(written, [address]))

    return traced(call)


def _all_compiled(given: Any) -> bool:
    return all(map(_all_compiled, given)) if isinstance(given, tuple) else isinstance(given, Value | Memory)


@contextmanager
def in_threads(count: Value, shared: tuple[Any, ...]) -> Iterator[tuple[Value, tuple[Any, ...]]]:
    """Compiled rounds 0 <= k < count in as many threads as numba has; what is within writes one, of k and the `shared` as it is there.

    The threads are started by `numba.get_num_threads()`. They are those of `numba.prange`, which takes a second more to compile.
    """
    builder = count.builder
    data = _written(builder, shared)
    task, within = _beside(builder, TASK, builder.module.get_unique_name(f"{builder.function.name}.task"))
    starts, counts, _, address = task.args
    there = _read(within, address, shared)
    first = within.sub(*(within.ptrtoint(one, WHOLE) for one in (within.load(starts), address)))
    with cgutils.for_range_slice(within, first, within.add(first, within.load(counts)), WHOLE(1)) as (k, _):
        yield Value(within, k), there
    within.ret_void()
    start, total, step = (cgutils.alloca_once_value(builder, x) for x in (data, count.code, WHOLE(1)))
    pointers = [builder.bitcast(one, POINTER) for one in (task, start, total, step, data)]
    threads = cgutils.get_or_insert_function(builder.module, ir.FunctionType(WHOLE, []), "get_num_threads")
    launch = cgutils.get_or_insert_function(builder.module, LAUNCH, "numba_parallel_for")
    builder.call(launch, [*pointers, WHOLE(1), WHOLE(1), builder.call(threads, [])])

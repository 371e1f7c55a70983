"""Loops in threads: the thread pool of `numba.prange`, which itself would take a second more to compile."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir
from numba.core import cgutils

from .outline import BYTES, new_function, reloaded, stored
from .values import INTEGER, Value

TASK = ir.FunctionType(ir.VoidType(), [BYTES.as_pointer(), INTEGER.as_pointer(), INTEGER.as_pointer(), BYTES])
"""What a thread runs: addresses of its first rounds, of their number and of the step, and the shared data.

Threads are given addresses, not numbers. The rounds begin at the address of the shared data, by steps of one byte: what a thread's
address is above it is the number of its first round.
"""
LAUNCH = ir.FunctionType(ir.VoidType(), [BYTES] * 5 + [INTEGER] * 3)


@contextmanager
def parallel_for(count: Value, shared: tuple[Any, ...]) -> Iterator[tuple[Value, tuple[Any, ...]]]:
    """Loop over 0 <= k < count in threads; yields k and what is shared, for the body to use nothing else.

    Parameters
    ----------
    count : Value
        Number of rounds, which run in any order.
    shared : tuple
        Values, arrays and tuples of these.

    Raises
    ------
    TypeError
        If the body uses a value or an array that is not shared.

    Notes
    -----
    As many threads run as `numba.get_num_threads()` says. It also starts them: call it before compiled code is loaded from the disk.
    """
    builder, data = count.builder, stored(count.builder, shared)
    with new_function(builder, TASK, builder.module.get_unique_name(f"{builder.function.name}.task")) as (task, inside):
        starts, counts, _, address = task.args
        there = reloaded(inside, address, shared)
        first = inside.sub(*(inside.ptrtoint(one, INTEGER) for one in (inside.load(starts, typ=BYTES), address)))
        last = inside.add(first, inside.load(counts, typ=INTEGER))
        with cgutils.for_range_slice(inside, first, last, INTEGER(1)) as (k, _):
            yield Value(inside, k), there
        inside.ret_void()
    start, total, step = (cgutils.alloca_once_value(builder, x) for x in (data, count.code, INTEGER(1)))
    pointers = [builder.bitcast(one, BYTES) for one in (task, start, total, step, data)]
    threads = cgutils.get_or_insert_function(builder.module, ir.FunctionType(INTEGER, []), "get_num_threads")
    launch = cgutils.get_or_insert_function(builder.module, LAUNCH, "numba_parallel_for")
    builder.call(launch, [*pointers, INTEGER(0), INTEGER(1), builder.call(threads, [])])

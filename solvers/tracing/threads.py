"""Loops in threads, by the thread pool of `numba.prange`."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import CFUNCTYPE, POINTER, c_int, c_ssize_t, c_void_p, cast
from functools import cache
from typing import Any

import numba
from llvmlite import binding, ir

from .control import for_range
from .outline import BYTES, new_function, reloaded, stored
from .values import INTEGER, NUMBER, Value, external, on_stack

TASK = ir.FunctionType(ir.VoidType(), [BYTES.as_pointer(), INTEGER.as_pointer(), INTEGER.as_pointer(), BYTES])
"""What a thread runs: addresses of its first rounds, of their number and of the step, and the shared data.

Threads are given addresses, not numbers: round k is passed as the address of the shared data plus k bytes.
"""
LAUNCH = ir.FunctionType(ir.VoidType(), [BYTES] * 5 + [INTEGER] * 3)
"""`numba_parallel_for`: the task and its four arguments, number of inner dimensions, number of arrays, number of threads."""
ROUNDS = 257
"""Of the loop that checks the calling convention: more than there are threads, and no multiple of their number."""


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
    As many threads run as `numba.get_num_threads()` says, or one where `start_threads` warns. Whether threads are launched is noted at the
    module, as `in_threads`: code from the disk that launches them is used only where they can be.
    """
    builder, data = count.builder, stored(count.builder, shared)
    with new_function(builder, TASK, builder.module.get_unique_name(f"{builder.function.name}.task")) as (task, inside):
        starts, counts, _, address = task.args
        there = reloaded(inside, address, shared)
        first = inside.sub(*(inside.ptrtoint(one, INTEGER) for one in (inside.load(starts, typ=BYTES), address)))
        last = inside.add(first, inside.load(counts, typ=INTEGER))
        with for_range(Value(inside, first), Value(inside, last)) as k:
            yield k, there
        inside.ret_void()
    start, total, step = (on_stack(builder, kind) for kind in (BYTES, INTEGER, INTEGER))
    for code, place in ((data, start), (count.code, total), (INTEGER(1), step)):
        builder.store(code, place)
    builder.module.in_threads = start_threads()
    if not builder.module.in_threads:
        builder.call(task, [start, total, step, data])
        return
    pointers = [builder.bitcast(one, BYTES) for one in (task, start, total, step, data)]
    threads = external(builder, "get_num_threads", ir.FunctionType(NUMBER, []))
    launch = external(builder, "numba_parallel_for", LAUNCH)
    builder.call(launch, [*pointers, INTEGER(0), INTEGER(1), builder.sext(builder.call(threads, []), INTEGER)])


@cache
def start_threads() -> bool:
    """Start numba's threads and check that they are launched by the convention that `parallel_for` is written for.

    Returns
    -------
    bool
        Whether they are. If not, a RuntimeWarning says so once, and what is compiled runs in one thread.
    """
    numba.get_num_threads()
    as_expected = _launched_as_expected()
    if not as_expected:
        warnings.warn(
            f"loops run in one thread: numba {numba.__version__} launches threads by another convention than expected; "
            "install a version that mpmverify allows",
            RuntimeWarning,
            stacklevel=3,
        )
    return as_expected


def _launched_as_expected() -> bool:
    """Whether a loop whose rounds are recorded runs each of them once, with the shared data, where threads launch it."""
    launch, threads = (binding.address_of_symbol(name) for name in ("numba_parallel_for", "get_num_threads"))
    if not launch or not threads or CFUNCTYPE(c_int)(threads)() != numba.get_num_threads():
        return False
    start, count, step, data = c_void_p(), c_ssize_t(ROUNDS), c_ssize_t(1), c_ssize_t()
    start.value = address = cast(POINTER(c_ssize_t)(data), c_void_p).value
    parts: list[tuple[int, int, int | None]] = []

    @CFUNCTYPE(None, POINTER(c_ssize_t), POINTER(c_ssize_t), c_void_p, c_void_p)
    def task(starts: Any, counts: Any, _: Any, shared: int | None) -> None:
        parts.append((starts[0] - (address or 0), counts[0], shared))

    arguments = (cast(POINTER(type(one))(one), c_void_p) for one in (start, count, step, data))
    prototype = CFUNCTYPE(None, *[c_void_p] * 5, *[c_ssize_t] * 3)
    prototype(launch)(cast(task, c_void_p), *arguments, 0, 1, numba.get_num_threads())
    place = 0
    for first, rounds, shared in sorted(part for part in parts if part[1]):
        if first != place or rounds < 0 or shared != address:
            return False
        place += rounds
    return place == ROUNDS

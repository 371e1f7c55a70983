"""Loops in threads: every round runs once, and threads that are launched in another way are not used."""

from contextlib import contextmanager
from ctypes import CFUNCTYPE, addressof, c_ssize_t, c_void_p, cast

import numba
import numpy as np
import pytest
from llvmlite import binding

from mpmverify.solvers.tracing import Compiled, for_range, parallel_for, start_threads, traced, where


@traced
def in_rounds(count, A, scale, flag):
    with parallel_for(count, (A, (scale, flag))) as (k, (array, (factor, more))), for_range(0, array.shape[1]) as c:
        array[k, c] += factor * k + where(more, 1.0, 0.0)


def after(count):
    """What `in_rounds` makes of zeros (20, 3) with a scale of 0.5 and the flag set."""
    expected = np.where(np.arange(20) < count, 0.5 * np.arange(20) + 1, 0.0)
    return np.repeat(expected[:, None], 3, axis=1)


@pytest.mark.parametrize("threads", [1, numba.config.NUMBA_NUM_THREADS])
@pytest.mark.parametrize("count", [0, 1, 3, 17])
def test_each_round_runs_once_however_many_threads_there_are(count, threads):
    rounds = Compiled(in_rounds)
    numba.set_num_threads(threads)
    try:
        A = np.zeros((20, 3))
        rounds(count, A, 0.5, True)
    finally:
        numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    assert np.array_equal(A, after(count))


TASK = CFUNCTYPE(None, *[c_void_p] * 4)
LAUNCH = CFUNCTYPE(None, *[c_void_p] * 5, *[c_ssize_t] * 3)


def without_arrays(task, starts, counts, step, data, arrays, inner, threads):
    """Another convention gives the number of arrays first, and of no array: no thread is told where its rounds begin."""
    half = c_ssize_t(c_ssize_t.from_address(counts).value // 2)
    rest = c_ssize_t(c_ssize_t.from_address(counts).value - half.value)
    for count in (half, rest):
        TASK(task)(starts, addressof(count), step, data)


def counts_first(task, counts, starts, step, data, inner, arrays, threads):
    """Another convention gives the numbers of rounds before the arrays."""
    TASK(task)(starts, counts, step, data)


def data_last(task, starts, counts, data, step, inner, arrays, threads):
    """Another convention gives the shared data last."""
    TASK(task)(starts, counts, step, data)


def nothing(task, starts, counts, step, data, inner, arrays, threads):
    """Another convention takes the task for something else."""


ORIGINAL = []


@contextmanager
def restored():
    """Launch threads as numba does, within `launched_by`."""
    planted = binding.address_of_symbol("numba_parallel_for")
    binding.add_symbol("numba_parallel_for", ORIGINAL[-1])
    yield
    binding.add_symbol("numba_parallel_for", planted)


@pytest.fixture
def launched_by(request):
    """Launch threads by another convention, as another version of numba might."""
    numba.get_num_threads()
    original, planted = binding.address_of_symbol("numba_parallel_for"), LAUNCH(request.param)
    ORIGINAL.append(original)
    binding.add_symbol("numba_parallel_for", cast(planted, c_void_p).value)
    start_threads.cache_clear()
    yield planted
    binding.add_symbol("numba_parallel_for", original)
    start_threads.cache_clear()


@pytest.mark.parametrize("launched_by", [without_arrays, counts_first, data_last, nothing], indirect=True)
def test_threads_that_are_launched_in_another_way_are_not_used(launched_by):
    rounds = Compiled(in_rounds)
    A = np.zeros((20, 3))
    with pytest.warns(RuntimeWarning, match="loops run in one thread"):
        rounds(17, A, 0.5, True)
    assert np.array_equal(A, after(17))
    assert start_threads() is False, "and the warning is not repeated"


@pytest.mark.parametrize("launched_by", [counts_first], indirect=True)
def test_code_that_launches_threads_is_taken_from_the_disk_only_where_it_can(launched_by, tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def run():
        rounds, A = Compiled(in_rounds, "rounds", tmp_path), np.zeros((20, 3))
        rounds(17, A, 0.5, True)
        assert np.array_equal(A, after(17))
        return rounds.made, rounds.from_disk

    with pytest.warns(RuntimeWarning, match="loops run in one thread"):
        assert run() == (1, 0)
    assert not list(tmp_path.iterdir()), "code for one thread is not for others"
    start_threads.cache_clear()
    with restored():
        assert [run(), run()] == [(1, 0), (0, 1)]
        start_threads.cache_clear()
    with pytest.warns(RuntimeWarning, match="loops run in one thread"):
        assert run() == (1, 0)


def test_threads_that_are_launched_as_expected_are_used():
    start_threads.cache_clear()
    assert start_threads() is True

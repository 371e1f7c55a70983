"""Loops and branches of traced functions, functions that calls share, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.selftest.tripwire import spoil_arrays
from mpmverify.solvers.tracing import (
    Compiled,
    Variable,
    cond,
    equal,
    for_range,
    for_strides,
    leavable,
    logical_not,
    outlined,
    pack,
    parallel_for,
    reduce_sum,
    switch,
    traced,
    valued,
    when,
    where,
    while_loop,
)

whole_numbers = st.integers(-20, 20)


@traced
def collatz(n):
    steps, at = Variable(0, n), Variable(n)
    with while_loop(lambda: at.value > 1, like=n):
        at.value = cond(equal(at.value % 2, 0), lambda: at.value // 2, lambda: 3 * at.value + 1)
        steps.value += 1
    return steps.value


@traced
def strides(begin, end, length, visited):
    with for_strides(begin, end) as (p, advance):
        visited[p] = visited[p] + 1
        with when(logical_not(p < length)):
            visited[p] = -1
        advance(length)


@traced
def first_above(values, limit):
    """Index of the first value above a limit, and how many were looked at."""
    found, seen = Variable(-1, like=values.shape[0]), Variable(0, like=values.shape[0])
    with leavable(values) as leave, for_range(0, values.shape[0]) as k:
        seen.value += 1
        with when(values[k] > limit):
            found.value = k
            leave(values[k] > limit)
        leave(values[k] < -limit)
    return found.value, seen.value


@traced
def of_numbers_of_python(x):
    total = Variable(0.0, x[0])
    with for_range(0, 3, like=x) as i, for_range(0, 2, like=x) as _:
        total.value += x[i]
    return total.value


@traced
def merged(x, n):
    return cond(x > 0, lambda: (x * 2, (n + 1, True), 1), (1.5, (7, x < -1), 2.5))


def test_a_while_loop_ends_when_its_condition_fails():
    count = Compiled(collatz)
    assert [count(n) for n in (1, 2, 3, 6, 7, 27)] == [0, 1, 7, 8, 16, 111]


@given(st.integers(0, 9), st.integers(0, 12), st.integers(1, 4))
def test_a_loop_takes_the_strides_that_its_body_chooses(begin, end, length):
    visited = np.zeros(12, dtype=np.int32)
    compiled_strides(begin, end, length, visited)
    expected = np.zeros(12, dtype=np.int32)
    expected[begin:end:length] = [1 if p < length else -1 for p in range(begin, end, length)]
    assert np.array_equal(visited, expected)


compiled_strides = Compiled(strides)
compiled_merged = Compiled(merged)


@given(st.lists(st.integers(-9, 9), max_size=8), st.integers(1, 8))
def test_code_is_left_before_its_end(values, limit):
    stop = next((k for k, value in enumerate(values) if abs(value) > limit), None)
    expected = (-1, len(values)) if stop is None else (stop if values[stop] > 0 else -1, stop + 1)
    assert compiled_first_above(np.array(values, dtype=float), float(limit)) == expected


compiled_first_above = Compiled(first_above)


@traced
def left_too_late(n):
    with leavable(n) as leave:
        pass
    leave(n > 0)
    return n


def test_code_that_has_ended_is_not_left():
    with pytest.raises(TypeError, match="cannot be left"):
        Compiled(left_too_late)(1)


@traced
def left_at_once(n):
    passed = Variable(0, n)
    with leavable(n) as leave:
        leave(True)
        passed.value = 1
    return passed.value


def test_code_is_left_by_a_condition_of_python():
    assert Compiled(left_at_once)(1) == 0


def test_a_loop_between_numbers_of_python():
    assert Compiled(of_numbers_of_python)(np.array([1.0, 2.0, 4.0, 8.0])) == 14.0


@given(st.floats(-5, 5), whole_numbers)
def test_cond_runs_one_of_two_branches(x, n):
    assert compiled_merged(x, n) == ((x * 2, (n + 1, True), 1.0) if x > 0 else (1.5, (7, x < -1), 2.5))


@traced
def numbered(n, x):
    return switch(n, {1: lambda: (x, n), 4: lambda: (2 * x, n + 1), 0: (0.5, 7)}, lambda: (-x, -n))


@given(st.integers(-2, 6), st.floats(-5, 5))
def test_switch_runs_the_branch_of_a_number(n, x):
    expected = {1: (x, n), 4: (2 * x, n + 1), 0: (0.5, 7)}.get(n, (-x, -n))
    assert compiled_numbered(n, x) == numbered(n, x) == expected


compiled_numbered = Compiled(numbered)


@traced
def of_two_kinds(x, n):
    return cond(x > 0, x, n), cond(n > 0, lambda: reduce_sum(pack((x, x, 1.0, 2.0)) + cond(n > 1, x, pack((x, 1, 2, 3)))), 0)


@pytest.mark.parametrize(("x", "n", "expected"), [(1.5, 2, (1.5, 12.0)), (-1.5, 1, (1.0, 4.5)), (-1.5, 0, (0.0, 0.0))])
def test_branches_of_two_kinds_are_promoted(x, n, expected):
    found = Compiled(of_two_kinds)(x, n)
    assert found == expected
    assert [type(value) for value in found] == [float, float]


@traced
def boolean_or_number(x):
    return cond(x > 0, x > 1, x)


@traced
def out_of_its_branch(x, y):
    inner = []
    with when(x > 0):
        inner.append(x * y[0])
    return inner[0]


@traced
def from_outside(x, y):
    with parallel_for(where(x > 0, 1, 2), (y,)) as (k, (there,)):
        there[k] = x


@traced
def by_a_condition_from_outside(x, y):
    outside = x > 1
    with parallel_for(where(x > 0, 1, 2), (y,)) as (k, (there,)), when((k < 2) & outside):
        there[k] = 1.0


@traced
def into_what_is_not_shared(x, y):
    with parallel_for(where(x > 0, 1, 2), ()) as (_, _):
        y[0] = 1.0


def test_values_that_are_not_there_are_refused():
    """A value of another kind, of a branch that was not taken, or of another function never gets into the code."""
    with pytest.raises(TypeError, match="type i1 cannot become one of type double"):
        Compiled(boolean_or_number)(1.0)
    with pytest.raises(RuntimeError, match="does not dominate"):
        Compiled(out_of_its_branch)(1.0, np.ones(1))
    with pytest.raises(TypeError, match="another function"):
        Compiled(from_outside)(1.0, np.ones(2))
    with pytest.raises(TypeError, match="another function"):
        Compiled(by_a_condition_from_outside)(1.0, np.ones(2))
    with pytest.raises(TypeError, match="not shared with it"):
        Compiled(into_what_is_not_shared)(1.0, np.ones(2))


calls = []


@outlined
def counted(x, pair, array) -> int:
    calls.append(1)
    array[0] += x * pair[0]
    return where(x > pair[1], 1, 0)


def test_an_outlined_function_is_traced_once_and_called_with_the_arguments_of_each_call():
    @Compiled
    def twice(x, y, array, other):
        return counted(x, (y, valued(1.0, x)), array), counted(2 * x, (x, y), other)

    array, other = np.zeros(3), np.zeros(2)
    calls.clear()
    assert twice(2.0, 5.0, array, other) == (1, 0)
    assert (array[0], other[0]) == (10.0, 8.0)
    assert len(calls) == 1


@traced
def with_a_number_of_python(x, array):
    return counted(x, (2.0, x), array)


def test_an_outlined_function_takes_no_number_of_python():
    with pytest.raises(TypeError, match="number of Python"):
        Compiled(with_a_number_of_python)(1.0, np.zeros(1))


def _of_the_same_name():
    @outlined
    def counted(x, pair, array) -> int:
        array[0] = -x
        return 2

    return counted


other = _of_the_same_name()


def test_outlined_functions_of_one_name_are_two_and_calls_of_one_take_the_same_types():
    @Compiled
    def both(x, array):
        return counted(x, (x, x), array), other(x, (x, x), array)

    array = np.ones(1)
    assert both(3.0, array) == (0, 2)
    assert array[0] == -3.0

    @Compiled
    def unlike(x, n, array):
        return counted(x, (x, x), array), counted(n, (x, x), array)

    with pytest.raises(TypeError, match="arguments of the same types"):
        unlike(1.0, 2, np.zeros(1))


@traced
def by_law(number, x):
    def second():
        spoil_arrays(locals())
        return 2 * x

    return switch(number, {1: lambda: x, 2: second}, 0.0)


@traced
def with_arrays_at_hand(number, values, places):
    values[1] = by_law(number, values[1])


@pytest.mark.parametrize(("number", "reached"), [(0, False), (1, False), (2, True)])
def test_spoil_arrays_in_code_that_does_not_run_changes_nothing(number, reached):
    """The self-test finds out in this way whether a trial reaches a passage; without arrays, those of the caller are spoiled."""
    values = np.array([1.0, 2.0, 3.0])
    Compiled(with_arrays_at_hand)(number, values, np.arange(3))
    assert np.isnan(values[[0, 2]]).all() == reached
    assert np.array_equal(values[[0, 2]], [1.0, 3.0]) != reached


def test_spoil_arrays_raises_without_any_array():
    with pytest.raises(ArithmeticError):
        spoil_arrays({"x": 1.0})

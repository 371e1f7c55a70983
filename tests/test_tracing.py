"""Traced functions: compiled and in plain Python they return the same, and what cannot be compiled is refused."""

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.solvers.tracing import (
    LANES,
    Compiled,
    Consecutive,
    Variable,
    acos,
    all_positive,
    as_integer,
    asinh,
    atanh,
    cos,
    exp,
    expm1,
    floor,
    for_range,
    load_rows,
    log,
    maximum,
    minimum,
    pack,
    power,
    reduce_sum,
    traced,
    unpack,
    where,
)

numbers = st.floats(-1e3, 1e3)


class Pair(NamedTuple):
    a: float
    b: float


@traced
def arithmetic(x, y, n, pair, deep):
    a, (b, (c,)) = pair.a, deep
    k = where(n > 2, n - 1, -n) * 3
    there = (x < y) & (n >= 0) | (x <= -1.0)
    return (
        (x + y, x - 2, 2.5 * x, y * n, x / 4, n / 3, 1 / (y + 2e3), 3 - x, -y, a + b - c),
        (k, n % 4, as_integer(x), 7 - n, 5),
        Pair(where(there, x, y), where(x > y, floor(x), maximum(x, minimum(y, 0.5)))),
        (there, all_positive(x)),
        (),
    )


compiled = Compiled(arithmetic)


@given(numbers, numbers, st.integers(0, 9), numbers, numbers)
def test_a_compiled_function_returns_what_python_does(x, y, n, a, b):
    arguments = x, y, n, Pair(a, b), (b, (a,))
    found, expected = compiled(*arguments), arithmetic(*arguments)
    assert found == expected
    assert [type(value) for value in found[1]] == [int] * 5
    assert [type(value) for value in found[2]] == [float] * 2
    assert [type(value) for value in found[3]] == [bool] * 2


@traced
def of_lanes(x, y, n):
    some = where(x > y, x * 2, y - x) + n
    return (some, maximum(some, 0.0), -x / y, 1.5), reduce_sum(some), all_positive(x)


@traced
def one_by_one(values):
    return tuple(zip(*(unpack(value, LANES) for value in values), strict=True))


@Compiled
def each_of_four(x, y, n):
    values, summed, above = of_lanes(pack(x), pack(y), n)
    return one_by_one(values), summed, above


fours = st.tuples(*[numbers.filter(lambda x: abs(x) > 1e-3)] * LANES)


@given(fours, fours, st.integers(0, 5))
def test_lanes_are_four_numbers(x, y, n):
    found, summed, above = each_of_four(x, y, n)
    expected = [of_lanes(a, b, n) for a, b in zip(x, y, strict=True)]
    assert np.array_equal(found, [values for values, _, _ in expected])
    assert summed == pytest.approx(sum(one for _, one, _ in expected), rel=1e-12, abs=1e-9)
    assert above == all(one for _, _, one in expected)


@traced
def elementary_functions(x, y):
    of_both = acos(x), atanh(x), cos(10 * x), asinh(3 * x)
    return *of_both, exp(x), expm1(1e-9 * x), log(2 + x), log(y), power(y, -5 / 3), exp(0.5)


@Compiled
def elementary_functions_of_four(x, y):
    return one_by_one(elementary_functions(pack(x), pack(y))), elementary_functions(x[0], y[0])


unit = st.floats(-0.999, 0.999)
positives = st.floats(1e-3, 1e3)


@given(st.tuples(*[unit] * LANES), st.tuples(*[positives] * LANES))
def test_elementary_functions_are_those_of_python(x, y):
    found, of_the_first = elementary_functions_of_four(x, y)
    expected = [elementary_functions(a, b) for a, b in zip(x, y, strict=True)]
    assert found == pytest.approx(np.array(expected), rel=1e-14)
    assert of_the_first == found[0]


def test_elementary_functions_are_nan_where_they_are_not_defined():
    outside, _ = elementary_functions_of_four((2.0,) * LANES, (-1.0,) * LANES)
    of_x, of_y = outside[0][:2], outside[0][7:9]
    assert np.isnan([*of_x, *of_y]).all()


@traced
def sums(A, places, total, begin, end):
    """Rows of A by their places into one, and four columns at a time twice."""
    with for_range(begin, end) as i:
        with for_range(i, i + 3) as _:
            total[0] += A[places[i], 0]
        with for_range(0, A.shape[1], LANES) as k:
            total[Consecutive(k)] = total[Consecutive(k)] + 2 * A[places[i], Consecutive(k)]


summed = Compiled(sums)


def test_loops_over_arrays():
    A, places = np.random.default_rng(1).normal(size=(5, 8)), np.array([4, 0, 3], dtype=np.int32)
    found, expected = np.zeros(8), 2 * A[[0, 3]].sum(axis=0)
    summed(A, places, found, 1, 3)
    expected[0] += 3 * A[[0, 3], 0].sum()
    assert found == pytest.approx(expected, rel=1e-14)
    before = found.copy()
    summed(A, places, found, 2, 2)
    assert np.array_equal(found, before)


@traced
def branching(x):
    return x if x > 0 else -x


@traced
def comparing(x):
    return 1.0 if x == 0 else x


@traced
def smallest(x):
    return min(x, 0.0)


@traced
def writing(x):
    x[0] = 1.0
    return 0.0


@traced
def writing_four(x):
    x[Consecutive(0)] = 1.0


@traced
def reading_rows(x):
    return load_rows(x, (0, 1, 2, 3), 0, (0.0, 0.0))


@traced
def writing_a_row(x):
    x[0] = 1.0


@traced
def reading_beyond(x):
    return x[0, 0, 0]


@traced
def adding_booleans(x):
    return (x > 0) + (x > 1)


@traced
def remainder(x):
    return x % 2


def read_only(x):
    x.flags.writeable = False
    return x


@pytest.mark.parametrize(
    ("function", "argument"),
    [
        (branching, 1.0),
        (comparing, 1.0),
        (smallest, 1.0),
        (adding_booleans, 1.0),
        (remainder, 1.5),
        (writing, np.zeros(4, dtype=np.int64)),
        (writing, read_only(np.zeros(4))),
        (writing_four, np.zeros(4, dtype=np.int64)),
        (writing_four, read_only(np.zeros(4))),
        (reading_rows, np.zeros((4, 2), dtype=np.int64)),
        (writing_a_row, np.zeros((2, 2))),
        (reading_beyond, np.zeros((2, 2))),
    ],
)
def test_branches_and_wrong_types_are_refused(function, argument):
    """None of them is compiled to one of its branches, or to bits of the wrong type."""
    with pytest.raises(TypeError):
        Compiled(function)(argument)


@pytest.mark.parametrize(
    ("argument", "said"),
    [
        (np.zeros((4, 4))[:, :2], "C-contiguous"),
        (np.zeros(2, dtype=np.float32), "doubles or integers"),
        (np.zeros(2, dtype=bool), "doubles or integers"),
        (np.zeros(2, dtype=">i4"), "byte order"),
        (np.zeros(2, dtype=np.dtype(float).newbyteorder()), "byte order"),
        ([1.0], "numbers, arrays and tuples of these, not list"),
        ((1.0, "a"), "numbers, arrays and tuples of these, not str"),
    ],
)
def test_arguments_that_compiled_code_does_not_take_are_refused(argument, said):
    with pytest.raises(TypeError, match=said):
        Compiled(lambda x: 0)(argument)


def test_an_array_is_no_result():
    with pytest.raises(TypeError, match="not an array"):
        Compiled(lambda x: x)(np.zeros(2))


def test_arguments_of_other_kinds_are_compiled_anew():
    doubled = Compiled(lambda x: x + x)
    assert [doubled(value) for value in (2, 1.5, np.int64(3), np.float64(2.5), 4)] == [4, 3.0, 6, 5.0, 8]
    assert doubled.made == 2


def test_first_arguments_are_given_once_for_all_calls():
    @Compiled
    def add(total, factor, x):
        total[0] += factor * x
        return total[0] + x

    total = np.zeros(1)
    added = add.entry(total, 2.0, 1.0).bound(total, 2.0)
    assert [added(x) for x in (1.0, 3.0)] == [3.0, 11.0]
    assert total[0] == 8.0


def test_arrays_that_are_bound_live_on():
    def bound():
        some = np.ones(10**6)  # a mapping of its own, gone at once when it is freed
        return Compiled(total_of).entry(some, 1.0).bound(some)

    assert bound()(2.0) == 2e6


@traced
def total_of(values, factor):
    total = Variable(0.0, like=factor)
    with for_range(0, values.shape[0]) as k:
        total.value += factor * values[k]
    return total.value


def test_an_entry_takes_arguments_of_its_kinds_alone():
    entry = Compiled(total_of).entry(np.ones(3), 1.0)
    assert entry(np.ones(4), 2.0) == 8.0
    for wrong in ((np.ones(3), 2), (np.ones(3, dtype=int), 2.0), (np.ones(3),), (np.ones(3), 1.0, 1.0)):
        with pytest.raises(TypeError, match="other kinds"):
            entry(*wrong)
    with pytest.raises(TypeError, match="other kinds"):
        entry.bound(np.ones((3, 1)))


def test_threads_of_python_share_what_one_of_them_compiles():
    shared = Compiled(total_of)
    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(lambda k: shared(np.full(5, float(k)), 1.0) / k, range(1, 9))) == {5.0}
    assert shared.made == 1


def test_integers_of_any_width_keep_their_sign():
    @Compiled
    def moved(x, y):
        y[0] = x[0] - 1
        return x[1]

    for kind in (np.int8, np.uint8, np.int32, np.uint32, np.int64):
        x, y = np.array([7, np.iinfo(kind).max], dtype=kind), np.zeros(1, dtype=kind)
        assert moved(x, y) == np.iinfo(kind).max
        assert y[0] == 6
    assert moved(np.array([0, -3], dtype=np.int8), np.zeros(1, dtype=np.int8)) == -3


@traced
def ends_of(x):
    x[-1] = x[0] + 1
    return x[-1], x[-2]


def test_a_number_of_python_counts_from_the_end():
    x = np.arange(3.0)
    assert Compiled(ends_of)(x) == (1.0, 1.0)
    assert np.array_equal(x, [0.0, 1.0, 1.0])

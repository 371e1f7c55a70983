"""The refinement axis of a set of runs does not depend on their order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.convergence.axis import Axis, axis, sizes
from mpmverify.exact.vibration import axial_vibration
from mpmverify.study import design, halving, in_particles, in_time

ONE = np.ones(4)
HALVES = 0.5 ** np.arange(4)
KINDS = [
    (HALVES, ONE, ONE, ("h",), "h"),
    (ONE, HALVES, ONE, ("dt",), "dt"),
    (ONE, ONE, 1 / HALVES, ("1/ppc",), "1/ppc"),
    (HALVES, HALVES / 3, ONE, ("h", "dt"), "h"),
    (HALVES, HALVES**1.5, ONE, ("h", "dt"), "h"),
    (HALVES, ONE, 1 / HALVES, ("h", "1/ppc"), "h"),
    (HALVES, HALVES, 1 / HALVES, ("h", "dt", "1/ppc"), "h"),
    (HALVES, HALVES[::-1], ONE, ("h", "dt"), ""),
    (HALVES[[0, 0, 1, 1]], HALVES[[0, 1, 0, 1]], ONE, ("h", "dt"), ""),
    (HALVES[[0, 0, 1, 2]], HALVES, ONE, ("h", "dt"), ""),
    (HALVES, ONE, [1, 2, 1, 2], ("h", "1/ppc"), ""),
    (ONE, ONE, ONE, ("h",), "h"),
    (HALVES[[0, 1, 2, 0]], HALVES[[0, 1, 2, 0]], ONE, ("h", "dt"), "h"),
    (HALVES, [1, 0.5, np.nan, 0.125], ONE, ("h", "dt"), "h"),
    (HALVES, [np.nan] * 4, ONE, ("h",), "h"),
]


@given(st.sampled_from(KINDS), st.permutations(range(4)))
def test_varied_sizes_and_order_size_of_each_kind_of_refinement(kind, shuffled):
    *columns, varied, size = kind
    found = axis(*(np.asarray(column)[list(shuffled)] for column in columns))
    assert (found.varied, found.size) == (varied, size)


def test_a_time_step_may_fall_faster_than_the_cell_size():
    assert axis(HALVES, HALVES**1.5, ONE).power == pytest.approx(1.5)
    assert axis(HALVES, HALVES**1.5, ONE).note == "h and dt together: min(p, 1.5 q)"
    assert axis(HALVES, 0.3 * HALVES, ONE).note == "h and dt together: min(p, q)"
    assert Axis(("h",)).note == ""


REFINEMENTS = [
    (halving(1.0, 8, quick=3, full=4, courant=0.5), ("h", "dt"), "h"),
    (halving(1.0, 8, quick=3, full=4, courant=0.5, courant_power=0.5), ("h", "dt"), "h"),
    (halving(1.0, 8, quick=3, full=4, courant=0.5, courant_power=-1.0), ("h",), "h"),
    (in_time(1.0, 8, quick=3, full=4, courant=0.5, ppc=2), ("dt",), "dt"),
    (in_particles(1.0, 8, courant=0.5, ppc=(1, 2, 4)), ("1/ppc",), "1/ppc"),
    (design(1.0, cells=(8, 16, 32), courant=(0.2, 0.1)), ("h", "dt"), ""),
    (design(1.0, cells=(8, 16, 32), courant=(0.2,), ppc=(1, 2)), ("h", "1/ppc"), ""),
    (design(1.0, cells=(8, 16), courant=(0.2, 0.1), ppc=(1, 2)), ("h", "dt", "1/ppc"), ""),
]


@pytest.mark.parametrize(("refinement", "varied", "size"), REFINEMENTS)
def test_the_axis_of_a_refinement_agrees_with_its_actual_time_steps(refinement, varied, size):
    assert (refinement.axis.varied, refinement.axis.size) == (varied, size)
    problem = axial_vibration(length=1.0).problem
    dt = [level.time_steps(problem)[1] for level in refinement.levels]
    found = axis([level.h for level in refinement.levels], dt, [level.ppc for level in refinement.levels])
    assert (found.varied, found.size) == (varied, size)


def test_refinements_have_distinct_labels():
    assert len({refinement.label for refinement, _, _ in REFINEMENTS}) == len(REFINEMENTS)


def test_a_design_uses_the_same_time_steps_for_all_cell_sizes():
    levels = design(25.0, cells=(32, 48, 96), courant=(2, 1, 0.5)).levels
    steps = [level.time_steps(axial_vibration().problem)[1] for level in levels]
    assert len(set(steps)) == 3
    assert len({(level.h, step) for level, step in zip(levels, steps, strict=True)}) == len(levels) == 9


def test_a_ladder_in_time_restricted_to_one_courant_number_has_one_level():
    (level,) = in_time(1.0, 8, quick=3, full=4, courant=0.5).with_courant(0.25).levels
    assert level.courant == 0.25
    assert len(halving(1.0, 8, quick=3, full=4, courant=0.5).with_courant(0.25).levels) == 4


def test_sizes_include_the_particle_spacing():
    found = sizes(np.array([0.5]), np.array([0.1]), np.array([4]))
    assert {name: size.item() for name, size in found.items()} == {"h": 0.5, "dt": 0.1, "1/ppc": 0.25, "h/ppc": 0.125}

"""Faults planted in the harness itself (judge, norms, criteria, baseline) break a property that the unmodified harness has.

A copy of a module or package is imported under another name, unmodified or with one edit. Every property below must hold for the
unmodified copy. At least one property of the same module or package must fail for each copy with a fault.
"""

import importlib
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import mpmverify
from mpmverify.criteria import StabilityLimit, Stall, Unstable
from mpmverify.criteria import evidence as stored
from mpmverify.criteria.criterion import Setting
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.judgement.findings import judge_criterion
from mpmverify.problem import Discretisation, LinearElastic, Problem, Traction
from mpmverify.solution import Solution, Work

ROOT = Path(mpmverify.__file__).parent
H = np.array([0.5, 0.1, 0.25, 0.04, 0.02])
"""Sizes with unequal ratios, unsorted, so that orders computed from indices are wrong."""
FINEST, COARSEST = H == 0.02, H == 0.5
BAND = (1.8, 2.2)


# Properties of the convergence package.


def same(found: Any, expected: Any, **tolerance: float) -> None:
    np.testing.assert_allclose(found, expected, **({"rtol": 1e-9} | tolerance))


def orders_use_the_sizes(c: ModuleType) -> None:
    for order in (-1.5, 0.7, 2.0):
        series = c.analyse(H, 3e-3 * H**order)
        same(series.pairwise, order)
        same(series.fit.order, order)
        same(series.fit.constant, 3e-3)
        fit = c.fit_order(H, 3e-3 * H**order)
        same([fit.order, fit.constant], [order, 3e-3])
        same(series.h, np.sort(H)[::-1])
        same(series.error, 3e-3 * np.sort(H)[::-1] ** order)


def scattered_errors_are_fitted_by_least_squares(c: ModuleType) -> None:
    error = 0.1 * H**2 * [1, 1.3, 0.8, 1.1, 0.9]
    fit = c.fit_order(H, error)
    same(fit.order, np.polyfit(np.log(H), np.log(error), 1)[0])
    same((fit.low + fit.high) / 2, fit.order)
    (slope, _), covariance = np.polyfit(np.log(H), np.log(error), 1, cov=True)
    # polyfit scales by n - 2 as well; 3.182 is the 97.5 % point of Student's t with three degrees of freedom.
    same(fit.high - slope, 3.182446305 * np.sqrt(covariance[0, 0]))


def intervals_cover_the_order_with_their_nominal_probability(c: ModuleType) -> None:
    generator = np.random.default_rng(0)
    h = H[:3]
    fits = [c.fit_order(h, h**2 * np.exp(0.1 * generator.standard_normal(3))) for _ in range(600)]
    assert 0.92 < np.mean([fit.low <= 2 <= fit.high for fit in fits]) < 0.98


def verdicts_of_series_are_right(c: ModuleType) -> None:
    for error, expected in (
        (H**2, "PASS"),
        (H**2.15, "PASS"),
        (H**1, "FAIL"),
        (H**3, "FAIL"),
        (H**-2, "FAIL"),
        (0 * H + 0.1, "FAIL"),
        (0.1 + H**3, "FAIL"),
        (np.where(FINEST, 1.0, H**2), "FAIL"),
        (np.where(FINEST, 1e-9, H**2), "INCONCLUSIVE"),
        (np.where(FINEST, 0, H**2), "INCONCLUSIVE"),
        (np.where(H < 0.2, 1e-14, H**2), "INCONCLUSIVE"),
        (np.where(FINEST, np.nan, H**2), "ERROR"),
        (np.where(COARSEST, np.inf, H**2), "ERROR"),
        (H**1.82 * [1, 1.05, 0.95, 1, 0.97], "INCONCLUSIVE"),
        (H**2.18 * [1, 1.05, 0.95, 1, 0.97], "INCONCLUSIVE"),
        (H**2.14 * [1, 1.05, 0.95, 1, 0.97], "INCONCLUSIVE"),
        (H**2 * [1, 2, 1, 2, 1], "INCONCLUSIVE"),
    ):
        assert c.verdict(H, error, band=BAND)[0] == expected, (error, expected)
    found, reason = c.verdict(H[:2], H[:2] ** 2, band=BAND)
    assert found == "INCONCLUSIVE"
    assert "an order needs three" in reason
    assert c.verdict(H, H**2)[0] == "INCONCLUSIVE"
    assert c.verdict(H, np.ma.masked_array(H**2, mask=H == 0.1), band=BAND)[0] == "ERROR"


def the_finest_levels_of_a_long_ladder_count(c: ModuleType) -> None:
    h = 0.5 ** np.arange(9.0)

    def after(*orders: float) -> str:
        verdict: str = c.verdict(h[: len(orders) + 1], 0.1 * 0.5 ** np.cumsum([0.0, *orders]), band=BAND)[0]
        return verdict

    assert after(2, 2, 2, 2, 2, 2, 1.6) == "INCONCLUSIVE"
    assert after(2, 2, 2, 2, 2, 2, -0.5) == "FAIL"
    assert after(2.1, 2.08, 2, 1.85, 1.7) == "FAIL"
    assert after(3.6, 3.4, 3.2, 3.0, 2.6) == "INCONCLUSIVE"
    assert after(3.9, 3.9, 3.9, 3.9, 3.9, 3.7, 3.0) == "INCONCLUSIVE"
    assert after(4.6, -0.6, 4.6, -0.6, 4.6, -0.6) == "INCONCLUSIVE"
    assert after(2.6, 1.4, 2.6, 1.4, 2.6, 1.4) == "PASS"
    assert after(2.6, 2.6, 2.6, 2.5, 2.3, 1.9) == "INCONCLUSIVE"
    assert after(2.9, 2.8, 2.65, 2.5, 2.37, 2.27) == "INCONCLUSIVE"
    assert after(2.6, 2.4, 2.23, 2.13, 2.07, 2.03) == "PASS"
    assert after(0.45, 1.82, 2, 2, 2, 2, 2) == "PASS"


def the_finest_levels_tell_where_an_order_goes(c: ModuleType) -> None:
    h = 0.5 ** np.arange(8.0)
    for error, expected in (
        (h**2 * [20, 8, 1, 1, 1, 1, 1, 1], "PASS"),
        (h**2 * (1 + 4 * h), "PASS"),
        (h[:5] ** 2 * (1 + 6 * h[:5]), "INCONCLUSIVE"),
        (h[:7] ** 2 + 0.5 * h[6] ** 0.5 * h[:7] ** 1.5, "INCONCLUSIVE"),
        (np.array([1, 0.25, 0.3]), "FAIL"),
    ):
        assert c.verdict(h[: len(error)], error, band=BAND)[0] == expected, (error, expected)
    three = np.array([1, 1 / 1.4, 1 / 3.92])
    assert c.verdict(three, [1, 1.4**-1.37, 1.4**-1.37 * 2.8**-0.87], band=(0.69, 1.31))[0] == "INCONCLUSIVE"
    fine = 1.1 ** -np.arange(12.0)
    scattered = fine**2 * [1, 1.01, 0.99, 1, 1.01, 0.99, 1, 1.005, 0.995, 1.01, 1, 1.06]
    assert c.verdict(fine, scattered, band=BAND)[0] == "INCONCLUSIVE"


def levels_on_both_sides_of_a_change_of_sign_tell_the_order(c: ModuleType) -> None:
    x = 2.0 ** np.arange(9, -1, -1)
    for more, at in ((1.1, 12.0), (2.6, 11.0), (2.6, 8 * 0.98 ** (-1 / 2.6))):  # the last one is next to the change at x = 8
        law = x**1.5 * np.abs(1 - (x / at) ** more)
        error = 1e-4 * law * np.exp(0.01 * np.random.default_rng(1).standard_normal(len(x)))
        assert c.verdict(x, error, band=(1.34, 1.66))[0] == "PASS"


def an_estimate_agrees_with_least_squares(c: ModuleType) -> None:
    h = 0.5 ** np.arange(8.0)
    error = 0.1 * h**2 * [1, 1.04, 0.97, 0.96, 1.05, 1.02, 0.95, 1.01]
    found, fit = c.analyse(h, error).fit, c.fit_order(h, error)
    same(found.order, fit.order, rtol=1e-6)
    assert 0.7 < (found.high - found.low) / (fit.high - fit.low) < 1.3


def the_floor_and_the_order_above_it_are_found(c: ModuleType) -> None:
    series = c.analyse(H, 1e-4 + H**3)
    assert series.classification == "other-error floor"
    same([series.floor.floor, series.floor.order], [1e-4, 3], rtol=0.02)


def errors_below_ten_times_the_uncertainty_of_a_reference_are_not_judged(c: ModuleType) -> None:
    h, error = np.sort(H)[::-1], np.sort(H)[::-1] ** 2
    assert c.verdict(h, error, band=BAND, uncertainty=error[2] / 11)[0] == "PASS"
    assert c.verdict(h, error, band=BAND, uncertainty=error[2] / 9)[0] == "INCONCLUSIVE"
    reference = c.qualify(h, 5 + error, formal=2)
    same(reference.uncertainty, 1.25 * error[-1] / (5 + error[-1]), rtol=1e-6)
    assert not c.qualify(h, 5 + h**0.1, formal=2).qualified
    assert not c.qualify(h[:2], error[:2], formal=2).qualified


def grid_convergence_is_exact_on_power_laws(c: ModuleType) -> None:
    for order in (0.8, 2.0, 3.1):
        for sign in (-1, 1):
            found = c.grid_convergence(H, 2 + sign * H**order, formal=2)
            same([found.order, found.limit], [order, 2], rtol=1e-7)
            assert found.factor == (1.25 if order == 2 else 3)
            assert found.uncertainty >= H.min() ** order * 0.999
            assert found.uncertainty <= 3.1 * H.min() ** min(order, 2) * (1 if order <= 2 else 10)
    assert c.grid_convergence(H, 2 - H**-1, formal=2).behaviour == "divergent"
    alternating = 2 + H**2 * [1, -1, -1, 1, -1]
    assert c.grid_convergence(H, alternating, formal=2).behaviour == "oscillatory"


# Properties of norms, evidence and baseline.


def norms_are_means_over_the_body(n: ModuleType) -> None:
    weight = np.array([[0.5, 1.0, 2.5]])
    field = np.full((1, 3, 1), -3.0)
    same(n.norms(field, weight), 3)
    field[0, :, 0] = [1, -2, 0]
    same(n.norms(field, weight), [2.5 / 4, np.sqrt(4.5 / 4), 2, np.sqrt(4.5 / 4)])
    same(n.norms(7 * field, weight), 7 * n.norms(field, weight))
    early = np.concatenate([5 * field, field])
    twice = np.repeat(weight, 2, axis=0)
    same(n.norms(early, twice), [2.5 / 4, np.sqrt(4.5 / 4), 2, 5 * np.sqrt(4.5 / 4)])
    for bad in (np.nan, np.inf):
        spoiled = field.copy()
        spoiled[0, 2, 0] = bad
        assert not np.any(np.isfinite(n.norms(spoiled, weight)))
    same(n.norms(np.array([[[3.0, 4.0]]]), np.ones((1, 1))), 5)


def errors_are_relative_to_the_exact_field_over_the_run(n: ModuleType) -> None:
    """A solution three times too large is wrong by twice the exact field, which vanishes at the final time here."""

    def exact(X: Any, t: Any) -> Any:
        return np.cos(0.5 * np.pi * t)[:, None, None] * (1 + X[None])

    sound = sampled()
    wrong = replace(sound, fields={"u": 3 * exact(sound.reference, sound.time)})
    error, size = n.errors(wrong, ExactSolution({"u": exact}, ""))["u"]
    same(error[3] / size[3], 2)
    start = replace(wrong, time=wrong.time[:1], weight=wrong.weight[:1], fields={"u": wrong.fields["u"][:1]})
    error, size = n.errors(start, ExactSolution({"u": exact}, ""))["u"]
    same(error / size, 2)
    assert np.all(n.errors(wrong, ExactSolution({"u": exact}, ""))["u"][1] >= size), "the size at the start is part of the run"


def evidence(g: ModuleType, error: Any, h: Any = H, size: float = 1.0) -> Any:
    table = np.repeat(np.asarray(error, dtype=float)[:, None], 4, axis=1)
    one = np.ones(len(h))
    outcomes = ("completed",) * len(h)
    return g.Evidence(h, h, one, one.astype(int), outcomes, {"u": table}, {"u": np.full_like(table, size)})


def evidence_is_relative(g: ModuleType) -> None:
    same(evidence(g, 3 * H, size=2).relative("u", "L2"), 1.5 * H)
    same(evidence(g, 3 * H, size=0).relative("u", "L2"), 3 * H)
    assert not np.any(np.isfinite(evidence(g, 3 * H, size=np.inf).relative("u", "L2")))


def the_worst_verdict_decides(g: ModuleType) -> None:
    statuses = {"PASS": 0, "INCONCLUSIVE": 0, "FAIL": 1, "ERROR": 3}
    for verdict, status in statuses.items():
        assert g.exit_status([g.Verdict(verdict)]) == status
        assert g.exit_status([g.Verdict("PASS"), g.Verdict(verdict)]) == status
        assert g.exit_status([g.Verdict(verdict), g.Verdict("PASS")], strict=True) == (
            4 if verdict == "INCONCLUSIVE" else status
        )
    assert g.exit_status([g.Verdict("FAIL"), g.Verdict("ERROR"), g.Verdict("INCONCLUSIVE")]) == 3
    assert g.exit_status([]) == g.exit_status([], strict=True) == 3, "nothing was judged"


class Passing:
    """A criterion that always passes."""

    title = source = "made so"

    def judge(self, evidence: Any) -> tuple[str, str]:
        return "PASS", "made so"


def incomplete_runs_are_judged_by_their_outcome_alone(g: ModuleType) -> None:
    class OnOutcomes(Passing, g.OnOutcomes):
        pass

    for outcome in ("unstable; at step 3", "crashed; it raised", "timed out"):
        seen = replace(evidence(stored, H), outcomes=("completed",) * 4 + (outcome,))
        verdict, reason = g.judge_criterion(Passing(), seen)
        assert verdict == "ERROR"
        assert outcome in reason
        assert g.judge_criterion(OnOutcomes(), seen)[0] == "PASS"
    assert g.judge_criterion(OnOutcomes(), evidence(stored, [], h=H[:0]))[0] == "ERROR", "no level was run"


def judging_compares_with_the_accepted_errors(b: ModuleType) -> None:
    where = ("study", "solver", "case", "ladder")
    baseline = b.Baseline(Path("unused"))
    assert baseline.judge(*where, evidence(stored, H))[0] == "INCONCLUSIVE"
    baseline.accept_series(*where, evidence(stored, H))
    assert baseline.judge(*where, evidence(stored, H))[0] == "PASS"
    assert baseline.judge(*where, evidence(stored, 1.02 * H))[0] == "FAIL"
    assert baseline.judge(*where, evidence(stored, 1.02 * H))[0] == "FAIL", "judging accepts nothing"
    assert baseline.judge(*where, evidence(stored, 0.9 * H))[0] == "FAIL", "a change for the better is accepted first"
    assert baseline.judge(*where, evidence(stored, np.where(H == 0.1, np.nan, H)))[0] == "ERROR"
    assert baseline.judge(*where[:3], "another", evidence(stored, H))[0] == "INCONCLUSIVE"
    assert baseline.judge(*where, evidence(stored, H, h=H * 0.9))[0] == "INCONCLUSIVE"


def limits_say_what_is_compared_with_the_baseline(b: ModuleType) -> None:
    """A stall its errors, by the change that it states; an unstable run its number of steps; a stability limit itself."""
    where = ("study", "solver", "case", "ladder")
    stall = Stall("u", "L2", 0.5, 0.0, 9.0, "", change=0.2)
    unstable, limit = Unstable(1.0, ""), StabilityLimit("mpm-tl-linear-usl-flip", 0.01, "")
    for criterion, seen, same_still, changed in (
        (stall, evidence(stored, H), evidence(stored, 1.1 * H), evidence(stored, 0.7 * H)),
        (
            unstable,
            *(replace(evidence(stored, H), outcomes=("unstable",) * 5, error={}, steps=np.full(5, n)) for n in (100, 103, 110)),
        ),
        (limit, *(replace(evidence(stored, H * n), metrics={"stability_limit": np.full(5, n)}) for n in (0.7, 0.702, 0.71))),
    ):
        baseline = b.Baseline(Path("unused"))
        baseline.accept_study(
            "study",
            {stored.SeriesId("case", "solver", "ladder"): (criterion,)},
            {stored.SeriesId("case", "solver", "ladder"): seen},
        )
        assert baseline.judge(*where, seen, (criterion,))[0] == "PASS"
        assert baseline.judge(*where, same_still, (criterion,))[0] == "PASS"
        assert baseline.judge(*where, changed, (criterion,))[0] == "FAIL"
    assert baseline.judge(*where, replace(evidence(stored, H), outcomes=("crashed",) * 5), (stall,))[0] == "ERROR"


# Properties of the criteria on histories and outcomes.

MATERIAL = LinearElastic(3.0, 2.0)
BAR = Problem("bar", (0.0,), (1.0,), MATERIAL, {"x-": Traction(), "x+": Traction()}, 1.0)
SETTING = Setting(VerificationProblem(BAR, ExactSolution({}, ""), "", ()), Discretisation(0.5, 0.5))
STOCKS = ("mass", "momentum", "kinetic_energy", "strain_energy")


def sampled() -> Solution:
    """Solution with three points of different and changing volumes, three output times, and histories that equal its sums."""
    rng = np.random.default_rng(2)
    time, steps = np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.2, 0.5, 0.7, 1.0])
    weight = np.array([[0.2, 0.5, 0.3], [0.25, 0.4, 0.35], [0.1, 0.6, 0.3]])
    v, stress = rng.uniform(0.5, 1.5, (2, 3, 3))
    m = 2.0 * weight[0]
    sums = {
        "mass": [m.sum() for _ in time],
        "momentum": [m @ v[k] for k in range(3)],
        "kinetic_energy": [0.5 * m @ (v[k] * v[k]) for k in range(3)],
        "strain_energy": [weight[k] @ (stress[k] * stress[k]) / 6.0 for k in range(3)],
    }
    histories = {name: np.interp(steps, time, values) for name, values in sums.items()}
    fields = {"velocity": v[:, :, None], "stress": stress[:, :, None]}
    points = np.array([[0.1], [0.5], [0.9]])
    positions, histories = np.repeat(points[None], 3, axis=0), histories | {"time": steps, "impulse": np.zeros(5)}
    return Solution(time, 0.2, points, positions, weight, fields, histories, Work())


def verdict_on(criterion: Any, *solutions: Solution) -> tuple[str, str]:
    """Verdict and reason on a series of solutions, one for each level."""
    return verdict_on_metrics(criterion, *(criterion.measure(solution, SETTING) for solution in solutions))


def verdict_on_metrics(criterion: Any, *measured: Mapping[str, float]) -> tuple[str, str]:
    names = {name for metrics in measured for name in metrics}
    metrics = {name: np.array([entry.get(name, np.nan) for entry in measured]) for name in names}
    h = 0.5 ** np.arange(len(measured))
    levels = stored.Evidence(h, h, h, np.ones(len(h), int), ("completed",) * len(h), metrics=metrics)
    verdict, reason = judge_criterion(criterion, levels)
    return verdict.value, reason


def with_history(solution: Solution, **histories: Any) -> Solution:
    return replace(solution, histories=dict(solution.histories) | histories)


def histories_are_sums_of_the_fields(c: ModuleType) -> None:
    sound, criterion = sampled(), c.FieldSums(STOCKS, "")
    assert verdict_on(criterion, sound)[0] == "PASS"
    for stock in STOCKS:
        wrong = with_history(sound, **{stock: sound.histories[stock] * (1 + 1e-9)})
        assert verdict_on(criterion, wrong)[0] == "FAIL"
        assert verdict_on(criterion, sound, wrong)[0] == "FAIL"
        nothing = with_history(sound, **{stock: np.zeros(5)})
        assert verdict_on(criterion, nothing)[0] == "FAIL"
    later = replace(sound, fields=dict(sound.fields) | {"velocity": sound.fields["velocity"][[1, 1, 2]]})
    assert verdict_on(criterion, later)[0] == "FAIL"
    part = c.FieldSums(STOCKS[:1], "").measure(sound, SETTING)
    assert verdict_on_metrics(criterion, part)[0] == "ERROR", "measured before another stock was declared"


def a_zero_momentum_with_zero_impulse_is_detected(c: ModuleType) -> None:
    empty = with_history(sampled(), momentum=np.zeros(5), impulse=np.zeros(5))
    assert verdict_on(c.Balance("momentum", "impulse", ""), empty)[0] == "FAIL"
    verdict, reason = verdict_on(c.FieldSums(("mass", "momentum"), ""), empty)
    assert verdict == "FAIL"
    assert "of momentum" in reason


def round_off_of_the_momentum_scales_with_what_moves(c: ModuleType) -> None:
    """Momenta that cancel leave round-off of their own size, whatever histories are there, and a defect of 1e-9 of it is none."""
    sound, v = sampled(), np.array([[3.0, -3.0, 0.0]] * 3)[:, :, None]
    sound = replace(sound, weight=np.full((3, 3), 1 / 3), fields={"velocity": v})
    moved = sound.reference + sound.time[:, None, None] * v
    for fields in ({"velocity": v}, {}):
        for defect, expected in ((1e-16, "PASS"), (1e-9, "FAIL")):
            balanced = replace(
                sound, position=moved, fields=fields, histories={"time": sound.histories["time"], "impulse": np.zeros(5)}
            )
            off = with_history(balanced, momentum=np.array([0.0, 0.0, defect, 0.0, 0.0]))
            size = MATERIAL.density * (3.0 + 3.0) / 3
            same(c.Balance("momentum", "impulse", "").measure(off, SETTING)["momentum_defect"], defect / size, rtol=1e-12)
            assert verdict_on(c.Balance("momentum", "impulse", ""), off)[0] == expected


def missing_fields_and_histories_are_named_and_do_not_pass(c: ModuleType) -> None:
    sound, criterion = sampled(), c.FieldSums(STOCKS, "")
    for quantity in ("velocity", "stress"):
        poorer = replace(sound, fields={name: values for name, values in sound.fields.items() if name != quantity})
        for solutions in ([poorer], [sound, poorer]):
            verdict, reason = verdict_on(criterion, *solutions)
            assert verdict == "ERROR"
            assert reason.endswith(f"the solver does not return the {quantity}")
    for stock in STOCKS:
        verdict, reason = verdict_on(
            criterion, replace(sound, histories={k: h for k, h in sound.histories.items() if k != stock})
        )
        assert verdict == "ERROR"
        assert reason.startswith(f"{stock} cannot be compared")
        assert "does not return this history" in reason
    verdict, reason = verdict_on(criterion, replace(sound, time=np.array([0.0, 0.6, 1.0])))
    assert verdict == "ERROR"
    assert "output time" in reason
    rest = replace(sound, fields={name: 0 * values for name, values in sound.fields.items()})
    verdict, reason = verdict_on(criterion, with_history(rest, **{stock: np.zeros(5) for stock in STOCKS[1:]}))
    assert verdict == "ERROR"
    assert "zero throughout" in reason


def energy_that_increases_again_does_not_decay(c: ModuleType) -> None:
    def falling(*total: float) -> Solution:
        return with_history(sampled(), kinetic_energy=np.array(total), strain_energy=np.ones(5), external_work=np.zeros(5))

    assert verdict_on(c.EnergyDecays(""), falling(5, 4, 3, 3, 1))[0] == "PASS"
    assert verdict_on(c.EnergyDecays(""), falling(5, 2, 3, 3, 1))[0] == "FAIL"
    assert verdict_on(c.EnergyDecays(""), falling(5, 4, 3, 3, 3.1))[0] == "FAIL"


def a_stall_has_a_known_size(c: ModuleType) -> None:
    """A body that never moves stalls at the error 1; of the two finest levels both count, and of a size the finest one alone."""
    stall, size = c.Stall("u", "L2", 0.5, 0.05, 0.2, ""), c.Size("u", "L2", 0.05, 0.2, "")
    for error, expected in ((0.1, "PASS"), (1.0, "FAIL"), (0.01, "FAIL")):
        assert stall.judge(evidence(stored, 0 * H + error))[0] == expected
        assert size.judge(evidence(stored, np.where(FINEST, error, 0.1 + H)))[0] == expected
        assert stall.judge(evidence(stored, np.where(H == 0.04, error, 0.1)))[0] != ("FAIL" if expected == "PASS" else "PASS")
    assert c.Size("u", "L2", 0.05, 0.2, "", 0.5).judge(evidence(stored, np.where(COARSEST, 0.1, 1.0)))[0] == "PASS"
    assert c.Size("u", "L2", 0.05, 0.2, "", 0.3).judge(evidence(stored, 0 * H + 0.1))[0] == "INCONCLUSIVE"


def unstable_runs_must_be_reported_as_unstable(c: ModuleType) -> None:
    def ended(*outcomes: str) -> str:
        nu = np.full(len(outcomes), 1.1)
        return c.Unstable(1.0, "").judge(stored.Evidence(nu, nu, nu, nu.astype(int), outcomes))[0].value

    assert ended("unstable; at step 2", "unstable; at step 5") == "PASS"
    assert ended("unstable; at step 2", "completed") == "FAIL"
    assert ended("unstable; at step 2", "crashed; it raised") == "ERROR"
    assert ended("non-finite; at step 2") == "ERROR"


def totals_are_exact_at_every_step(c: ModuleType) -> None:
    exact = ExactSolution({}, "", totals={"momentum": lambda t: 3.0 * t[:, None]})
    setting = Setting(VerificationProblem(BAR, exact, "", ()), Discretisation(0.5, 0.5))
    criterion, sound = c.ExactTotal("momentum", ""), sampled()
    for k in range(6):
        momentum = 3.0 * sound.histories["time"] + 1e-9 * (np.arange(5) == k)
        measured = criterion.measure(with_history(sound, momentum=momentum), setting)
        assert verdict_on_metrics(criterion, measured)[0] == ("FAIL" if k < 5 else "PASS")


PROPERTIES: dict[str, tuple[Callable[[ModuleType], None], ...]] = {
    "convergence": (
        orders_use_the_sizes,
        scattered_errors_are_fitted_by_least_squares,
        intervals_cover_the_order_with_their_nominal_probability,
        verdicts_of_series_are_right,
        the_finest_levels_of_a_long_ladder_count,
        an_estimate_agrees_with_least_squares,
        the_finest_levels_tell_where_an_order_goes,
        levels_on_both_sides_of_a_change_of_sign_tell_the_order,
        the_floor_and_the_order_above_it_are_found,
        errors_below_ten_times_the_uncertainty_of_a_reference_are_not_judged,
        grid_convergence_is_exact_on_power_laws,
    ),
    "criteria/norms": (norms_are_means_over_the_body, errors_are_relative_to_the_exact_field_over_the_run),
    "criteria/evidence": (evidence_is_relative,),
    "convergence/verdict": (the_worst_verdict_decides,),
    "criteria": (
        histories_are_sums_of_the_fields,
        a_zero_momentum_with_zero_impulse_is_detected,
        round_off_of_the_momentum_scales_with_what_moves,
        totals_are_exact_at_every_step,
        missing_fields_and_histories_are_named_and_do_not_pass,
        energy_that_increases_again_does_not_decay,
        a_stall_has_a_known_size,
        unstable_runs_must_be_reported_as_unstable,
    ),
    "judgement/findings": (incomplete_runs_are_judged_by_their_outcome_alone,),
    "judgement/baseline": (judging_compares_with_the_accepted_errors, limits_say_what_is_compared_with_the_baseline),
}


@dataclass(frozen=True)
class Fault:
    """Replaces a passage that must occur exactly once in a file below mpmverify/."""

    file: str
    old: str
    new: str

    @property
    def part(self) -> str:
        """Module or package that is copied."""
        module = self.file.removesuffix(".py")
        return module if module in PROPERTIES else module.partition("/")[0]


FITS, SERIES, JUDGING = "convergence/fits.py", "convergence/series.py", "convergence/order_verdict.py"
ESTIMATE, PRIOR = "convergence/estimate.py", "STRAIGHT, FURTHER_TERM, ALTERNATING = 0.6, 0.3, 0.1"
GCI, LEVELS, REFERENCE = "convergence/gci.py", "convergence/levels.py", "convergence/reference.py"
FIT_LOGARITHMS = "x, y = np.log(h), np.log(error)\n    dx"
STUDENT = "student_quantile(len(h) - 2, confidence)"
SUMS, HISTORIES, OUTCOMES = "criteria/field_sums.py", "criteria/histories.py", "criteria/outcomes.py"
ERRORS = "criteria/errors.py"
NORMS, EVIDENCE, VERDICT = "criteria/norms.py", "criteria/evidence.py", "convergence/verdict.py"
FINDINGS, BASELINE = "judgement/findings.py", "judgement/baseline.py"
IN_BAND = "if not (below.step <= edge and above.step <= edge):"
FAULTS = {
    "order by index": Fault(FITS, FIT_LOGARITHMS, "x, y = -0.7 * np.arange(len(h)), np.log(error)\n    dx"),
    "pairwise order by index": Fault(FITS, "/ np.diff(np.log(-sizes))", "/ np.log(0.5)"),
    "log10 of sizes": Fault(FITS, FIT_LOGARITHMS, "x, y = np.log10(h), np.log(error)\n    dx"),
    "log10 of errors": Fault(FITS, FIT_LOGARITHMS, "x, y = np.log(h), np.log10(error)\n    dx"),
    "log10 of sizes, pairwise": Fault(FITS, "/ np.diff(np.log(-sizes))", "/ np.diff(np.log10(-sizes))"),
    "power of ten of a natural logarithm": Fault(FITS, "math.exp(intercept)", "10**intercept"),
    "mean of pairwise orders": Fault(FITS, "order = float(dx @ y) / sxx", "order = float(pairwise_orders(h, error).mean())"),
    "order of the first and the last level": Fault(
        FITS, "order = float(dx @ y) / sxx", "order = float((y[-1] - y[0]) / (x[-1] - x[0]))"
    ),
    "absolute value of an order": Fault(FITS, "order = float(dx @ y) / sxx", "order = abs(float(dx @ y)) / sxx"),
    "absolute value of a pairwise order": Fault(FITS, "np.append(np.nan, np.diff(log_error)", "np.append(np.nan, -abs(np.diff(log_error))"),
    "fit through the origin": Fault(FITS, "dx = x - x.mean()", "dx = x"),
    "normal distribution": Fault(FITS, STUDENT, "1.959964"),
    "one-sided interval": Fault(FITS, STUDENT, "student_quantile(len(h) - 2, 2 * confidence - 1)"),
    "one degree of freedom too many": Fault(FITS, "/ (len(h) - 2) / sxx", "/ (len(h) - 1) / sxx"),
    "standard error of the residual": Fault(FITS, "/ (len(h) - 2) / sxx", "/ (len(h) - 2)"),
    "interval of half the width": Fault(FITS, "order + half_width, constant)", "order, constant)"),
    "floor not detected": Fault(FITS, "    if len(h) < 4:\n", "    if len(h) < 40:\n"),
    "NaN masked": Fault(
        SERIES,
        "    h, error = levels(h, error, replicates=True)\n",
        "    h, error = levels(h, error, replicates=True)\n    h, error = h[~np.isnan(error)], error[~np.isnan(error)]\n",
    ),
    "infinity taken for a large number": Fault(SERIES, "levels(h, error, replicates=True)", "levels(h, np.nan_to_num(error), replicates=True)"),
    "NaN taken for zero": Fault(SERIES, "if not np.all(np.isfinite(error)):", "if not np.all(np.isfinite(error := np.nan_to_num(error))):"),
    "round-off kept": Fault(SERIES, "kept = error > limit", "kept = error > 0"),
    "uncertainty ignored": Fault(SERIES, "max(round_off, REFERENCE_MARGIN * uncertainty)", "round_off"),
    "no margin above the uncertainty": Fault(SERIES, "max(round_off, REFERENCE_MARGIN * uncertainty)", "max(round_off, uncertainty)"),
    "rough start kept": Fault(ESTIMATE, "np.arange(max(1, level[0] + 2 - LEAST_RUN))", "np.arange(1)"),
    "growth not detected": Fault(SERIES, "or grows:", "or False:"),
    "coarsest steps for the finest": Fault(SERIES, "pairwise_orders(h, error)[-2:]", "pairwise_orders(h, error)[:2]"),
    "order at the coarsest level": Fault(ESTIMATE, "deviation[:, level == 1][:, 0] - deviation[:, -1]", "deviation[:, 0] - deviation[:, 1]"),
    "one step taken for two": Fault(SERIES, "error[-3] / error[-1]", "error[-2] / error[-1]"),
    "limit not looked at": Fault(ESTIMATE, "np.minimum(probability[1], probability[2])", "probability[1]"),
    "no further term": Fault(ESTIMATE, PRIOR, PRIOR.replace("0.3", "1e-300")),
    "no alternating part": Fault(ESTIMATE, PRIOR, PRIOR.replace("0.1", "1e-300")),
    "sign change not followed": Fault(ESTIMATE, "np.all(term[:, level < LEAST_RUN]", "np.all(term"),
    "level next to a change of sign is used": Fault(ESTIMATE, "NEAR_ZERO = 0.1", "NEAR_ZERO = 1e-9"),
    "as many degrees of freedom as levels": Fault(ESTIMATE, "freedom = SCATTER_WEIGHT + n - 2", "freedom = SCATTER_WEIGHT + n"),
    "scatter of the mean": Fault(ESTIMATE, "np.sqrt(squares / freedom / sxx)", "np.sqrt(squares / freedom / sxx / n)"),
    "plunge not detected": Fault(SERIES, "if self.error[k + 1] <= self.limit and", "if False and"),
    "three levels are too few": Fault(SERIES, "if sizes < 3:", "if sizes < 4:"),
    "estimate for interval": Fault(JUDGING, IN_BAND, "if not (below.step <= 0.5 and above.step <= 0.5):"),
    "lower edge alone": Fault(JUDGING, IN_BAND, "if not below.step <= edge:"),
    "upper edge alone": Fault(JUDGING, IN_BAND, "if not above.step <= edge:"),
    "outside above does not fail": Fault(JUDGING, "if too_slow or too_fast or grows:", "if too_slow or grows:"),
    "finest steps may leave the band": Fault(JUDGING, "if max(steps) < low or min(steps) > high or not in_band:", "if False:"),
    "finest level may leave the band": Fault(JUDGING, "if max(below.finest, above.finest) > DOUBTFUL or", "if"),
    "limit may leave the band": Fault(JUDGING, "or max(below.limit, above.limit) > LEAVING:", "or False:"),
    "no expectation passes": Fault(JUDGING, "if band is None and", "if False and"),
    "not finite is inconclusive": Fault(JUDGING, "ERROR, NOT_FINITE\n    if kind", "INCONCLUSIVE, NOT_FINITE\n    if kind"),
    "growth does not fail": Fault(JUDGING, "if too_slow or too_fast or grows:", "if too_slow or too_fast:"),
    "levels sorted from fine to coarse": Fault(LEVELS, "np.argsort(-h)", "np.argsort(h)"),
    "sizes sorted alone": Fault(LEVELS, "h, value = h[coarse_first], value[coarse_first]", "h = h[coarse_first]"),
    "levels not sorted": Fault(LEVELS, "np.argsort(-h)", "np.arange(len(h))"),
    "mask ignored": Fault(LEVELS, "if isinstance(values, np.ma.MaskedArray):", "if False:"),
    "ratios exchanged": Fault(GCI, "observed_order(h[-3] / h[-2], h[-2] / h[-1]", "observed_order(h[-2] / h[-1], h[-3] / h[-2]"),
    "equal ratios assumed": Fault(GCI, "observed_order(h[-3] / h[-2],", "observed_order(h[-2] / h[-1],"),
    "absolute value of an observed order": Fault(GCI, "    if not order > 0:\n", "    order = abs(order)\n    if not order > 0:\n"),
    "sign of the steps lost": Fault(GCI, "if steps[-2] * steps[-1] < 0:", "if False:"),
    "always the small factor": Fault(GCI, "UNCONFIRMED = 1.25, 3.0", "UNCONFIRMED = 1.25, 1.25"),
    "the greater order": Fault(GCI, "min(order, formal)", "max(order, formal)"),
    "extrapolation the wrong way": Fault(GCI, "value[-1] + rest", "value[-1] - rest"),
    "uncertainty not relative": Fault(REFERENCE, "self.convergence.uncertainty / self.size if", "self.convergence.uncertainty if"),
    "a reference without an order qualifies": Fault(REFERENCE, "FLAT < self.convergence.order < math.inf", "not self.convergence.order <= FLAT"),
    "a stagnant reference qualifies": Fault(REFERENCE, "FLAT < self.convergence.order", "0 < self.convergence.order"),
    "weight inside the power, L2": Fault(NORMS, "np.sqrt(np.sum(weight * np.sum(values**2", "np.sqrt(np.sum(weight**2 * np.sum(values**2"),
    "no weight, L1": Fault(NORMS, "np.sum(weight * np.linalg.norm", "np.mean(np.linalg.norm"),
    "sum for mean": Fault(NORMS, "weight = weight / measure[0]", "weight = weight + 0"),
    "NaN masked in L1": Fault(NORMS, "return np.sum(weight * np.linalg", "return np.nansum(weight * np.linalg"),
    "NaN masked in L2": Fault(NORMS, "np.sqrt(np.sum(weight *", "np.sqrt(np.nansum(weight *"),
    "NaN masked in Linf": Fault(NORMS, "return np.max(np.linalg", "return np.nanmax(np.linalg"),
    "first time for last": Fault(NORMS, "[one[-1], two[-1], largest[-1], ", "[one[0], two[0], largest[0], "),
    "size of the numerical field": Fault(NORMS, "sizes(expected * entries", "sizes(solution.fields[quantity] * entries"),
    "size at the final time": Fault(NORMS, "np.max(_over_time(values, weight), axis=1)", "_over_time(values, weight)[:, -1]"),
    "errors not squared": Fault(NORMS, "np.sum(values**2, axis=-1)", "np.sum(np.abs(values), axis=-1)"),
    "error times the exact norm": Fault(EVIDENCE, "return self.error[quantity][:, k] /", "return self.error[quantity][:, k] *"),
    "an infinite exact norm is accepted": Fault(EVIDENCE, "np.where(np.isfinite(self.reference[quantity][:, k]), ", "np.where(True, "),
    "inconclusive is an error": Fault(VERDICT, "return 4 if strict else 0", "return 4"),
    "an error is a failure": Fault(VERDICT, "Verdict.ERROR: 3", "Verdict.ERROR: 1"),
    "fields compared with themselves": Fault(SUMS, "np.sum(terms, axis=1) - history", "np.sum(terms, axis=1) - np.sum(terms, axis=1)"),
    "history compared with itself": Fault(SUMS, "np.sum(terms, axis=1) - history", "0 * history"),
    "mass from the current volume": Fault(SUMS, "* _reference_volume(solution, problem))", "* solution.weight[-1])"),
    "energy from the reference volume": Fault(SUMS, "weight * _energy(", "weight[0] * _energy("),
    "rows counted from the start": Fault(SUMS, "np.searchsorted((instants[1:] + instants[:-1]) / 2, solution.time)", "np.arange(len(solution.time))"),
    "output times not compared": Fault(SUMS, "<= 1e-9 * problem.end_time", "<= problem.end_time"),
    "missing field not named": Fault(SUMS, "if _lacks(stock, what) in evidence.metrics:", "if False:"),
    "missing history skipped": Fault(SUMS, "for stock in self.stocks}", "for stock in self.stocks if _defect(stock) in evidence.metrics}"),
    "first history alone": Fault(SUMS, "np.concatenate(list(defects.values()))", "list(defects.values())[0]"),
    "drift for rise": Fault(HISTORIES, "np.minimum.accumulate(total)", "total[0]"),
    "last rise alone": Fault(HISTORIES, "np.minimum.accumulate(total)", "np.minimum(total, total[-1])"),
    "scale of the net momentum alone": Fault(HISTORIES, "defect, max(scale, moved))", "defect, scale)"),
    "speed of what moves for its momentum": Fault(HISTORIES, "return float(density * np.max(", "return float(np.max("),
    "total at the last step alone": Fault(
        HISTORIES, "for name in names]).T - exact\n", "for name in names]).T - exact\n        defect = defect[-1:]\n"
    ),
    "momentum of the last point": Fault(HISTORIES, "axis=2) @ solution.weight[0]", "axis=2)[:, -1:]"),
    "any size stalls": Fault(ERRORS, "if not (self.low <= min(before, finest) and max(before, finest) <= self.high):", "if False:"),
    "small errors stall": Fault(ERRORS, "if not (self.low <= min(before, finest) and max", "if not (max"),
    "large errors have the size": Fault(ERRORS, "self.low <= judged.min() and judged.max() <= self.high", "self.low <= judged.min()"),
    "size of every level": Fault(ERRORS, "self.h or size.min(), rtol=1e-9", "size, rtol=1e-9"),
    "completion above the limit passes": Fault(OUTCOMES, "if status != Status.UNSTABLE}", "if status not in (Status.UNSTABLE, Status.COMPLETED)}"),
    "crash above the limit passes": Fault(OUTCOMES, "if status != Status.UNSTABLE}", "if status == Status.COMPLETED}"),
    "completion above the limit is an error": Fault(OUTCOMES, "Verdict.FAIL if", "Verdict.ERROR if"),
    "incomplete runs are judged": Fault(FINDINGS, "if evidence.incomplete and not isinstance(criterion, OnOutcomes):", "if False:"),
    "errors compared with themselves": Fault(BASELINE, "then = known.get(name, 0.0)", "then = now"),
    "judged errors used as baseline": Fault(
        BASELINE, "known = accepted.get(level, {})", "known = accepted.get(level, {n: v[0] for n, v in values.items()})"
    ),
    "judging accepts": Fault(BASELINE, "                compared += 1\n", "                compared += 1\n                known[name] = now\n"),
    "series mixed up": Fault(
        BASELINE,
        'self.entries.get(study, {}).get(solver, {}).get(f"{case} | {refinement}", {})',
        "next(iter(self.entries.get(study, {}).get(solver, {}).values()), {})",
    ),
    "levels mixed up": Fault(BASELINE, 'yield f"h={h:.9g} nu_C', 'yield f"{k} nu_C'),
    "smaller errors pass": Fault(BASELINE, "elif rose(now, then, size, change):", "elif False:"),
    "errors larger by half pass": Fault(BASELINE, "RELATIVE = 0.01", "RELATIVE = 0.5"),
    "any change of a limit passes": Fault(BASELINE, "change = _change(criteria)", "change = 9.0"),
    "limits ignored": Fault(BASELINE, "if isinstance(criterion, OnLimits)), errors_of_level)", "if False), errors_of_level)"),
    "NaN not detected": Fault(BASELINE, "if not np.all(np.isfinite([now, then, size])):", "if False:"),
}  # fmt: skip


@pytest.fixture
def planted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str, Fault | None], ModuleType]]:
    """Import a copy of a part of the harness, with a fault or none."""
    monkeypatch.syspath_prepend(str(tmp_path))
    name = f"harness_{tmp_path.name}"

    def copy(part: str, fault: Fault | None) -> ModuleType:
        target = tmp_path / name
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            target.mkdir()
            shutil.copy(ROOT / f"{part}.py", target / "__init__.py")
        for path in target.glob("*.py"):
            path.write_text(
                path.read_text(encoding="utf-8").replace(f"mpmverify.{part.replace('/', '.')}.", f"{name}."), encoding="utf-8"
            )
        if fault:
            path = target / ("__init__.py" if fault.file == f"{part}.py" else Path(fault.file).name)
            text = path.read_text(encoding="utf-8")
            assert text.count(fault.old) == 1, f"{fault.file} holds {fault.old!r} {text.count(fault.old)} times"
            path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
        importlib.invalidate_caches()
        return importlib.import_module(name)

    yield copy
    for module in [module for module in sys.modules if module.partition(".")[0] == name]:
        del sys.modules[module]


def broken(module: ModuleType, part: str) -> list[str]:
    """Names of the properties that do not hold for a module."""
    names = []
    for holds in PROPERTIES[part]:
        try:
            holds(module)
        except AssertionError:
            names.append(holds.__name__)
    return names


@pytest.mark.parametrize("part", PROPERTIES)
def test_every_property_holds_for_the_unmodified_copy(part: str, planted: Any) -> None:
    module = planted(part, None)
    for holds in PROPERTIES[part]:
        holds(module)


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_every_fault_breaks_a_property(fault: Fault, planted: Any) -> None:
    assert broken(planted(fault.part, fault), fault.part)

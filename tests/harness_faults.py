"""Faults of the harness, and the properties of the part in which they are planted."""

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

from convergence_properties import (
    an_estimate_agrees_with_least_squares,
    errors_below_ten_times_the_uncertainty_of_a_reference_are_not_judged,
    grid_convergence_is_exact_on_power_laws,
    intervals_cover_the_order_with_their_nominal_probability,
    levels_on_both_sides_of_a_change_of_sign_tell_the_order,
    orders_use_the_sizes,
    scattered_errors_are_fitted_by_least_squares,
    the_finest_levels_of_a_long_ladder_count,
    the_finest_levels_tell_where_an_order_goes,
    the_floor_and_the_order_above_it_are_found,
    verdicts_of_series_are_right,
)
from criteria_properties import (
    a_stall_has_a_known_size,
    a_zero_momentum_with_zero_impulse_is_detected,
    energies_that_are_made_up_do_not_balance,
    energy_that_increases_again_does_not_decay,
    histories_are_sums_of_the_fields,
    missing_fields_and_histories_are_named_and_do_not_pass,
    round_off_of_the_momentum_scales_with_what_moves,
    totals_are_exact_at_every_step,
    unstable_runs_must_be_reported_as_unstable,
)
from judgement_properties import (
    errors_are_relative_to_the_exact_field_over_the_run,
    evidence_is_relative,
    incomplete_runs_are_judged_by_their_outcome_alone,
    judging_compares_with_the_accepted_errors,
    limits_say_what_is_compared_with_the_baseline,
    norms_are_means_over_the_body,
    the_worst_verdict_decides,
)

PROPERTIES: dict[str, tuple[Callable[[ModuleType], None], ...]] = {
    "convergence": (
        orders_use_the_sizes,
        scattered_errors_are_fitted_by_least_squares,
        verdicts_of_series_are_right,
        the_finest_levels_of_a_long_ladder_count,
        an_estimate_agrees_with_least_squares,
        the_finest_levels_tell_where_an_order_goes,
        levels_on_both_sides_of_a_change_of_sign_tell_the_order,
        the_floor_and_the_order_above_it_are_found,
        errors_below_ten_times_the_uncertainty_of_a_reference_are_not_judged,
        grid_convergence_is_exact_on_power_laws,
        intervals_cover_the_order_with_their_nominal_probability,  # last, as it takes the longest
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
        energies_that_are_made_up_do_not_balance,
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
SUMS, HISTORIES, ENERGIES, OUTCOMES = (f"criteria/{name}.py" for name in ("field_sums", "histories", "energies", "outcomes"))
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
    "weight inside the power, L2": Fault(NORMS, "np.sum(weight * size**2", "np.sum(weight**2 * size**2"),
    "no weight, L1": Fault(NORMS, "np.sum(weight * size,", "np.mean(size,"),
    "sum for mean": Fault(NORMS, "return weight / measure[0]", "return weight + 0"),
    "NaN masked in L1": Fault(NORMS, "return np.sum(weight * size,", "return np.nansum(weight * size,"),
    "NaN masked in L2": Fault(NORMS, "np.sqrt(np.sum(weight *", "np.sqrt(np.nansum(weight *"),
    "NaN masked in Linf": Fault(NORMS, "return np.max(size", "return np.nanmax(size"),
    "first time for last": Fault(NORMS, "[one[-1], two[-1], largest[-1], ", "[one[0], two[0], largest[0], "),
    "size of the numerical field": Fault(NORMS, "(difference, expected * entries)", "(difference, solution.fields[quantity][some] * entries)"),
    "size at the final time": Fault(NORMS, "np.max(over_time, axis=1)", "over_time[:, -1]"),
    "errors not squared": Fault(NORMS, "weight * size**2", "weight * size"),
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
    "drift for rise": Fault(ENERGIES, "np.minimum.accumulate(total, axis=0)", "total[0]"),
    "last rise alone": Fault(ENERGIES, "np.minimum.accumulate(total, axis=0)", "np.minimum(total, total[-1])"),
    "kinetic energies of any motion": Fault(ENERGIES, "if apart > FAR", "if False"),
    "kinetic energy without the half": Fault(ENERGIES, "sums = 0.5 * ", "sums = "),
    "kinetic energies beside a large strain energy": Fault(ENERGIES, "np.ptp(history", "np.max(history"),
    "work of a body without loads that is not looked at": Fault(ENERGIES, "[energy - history[\"external_work\"], *", "[energy, *"),
    "work of a body without loads": Fault(ENERGIES, "[] if _loaded(problem) else [energy]", "[]"),
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

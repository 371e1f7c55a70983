"""Properties of norms, evidence, findings and baseline, each a function of a copy of the module."""

from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from convergence_properties import H, same

from mpmverify.criteria import StabilityLimit, Stall, Unstable
from mpmverify.criteria import evidence as stored
from mpmverify.exact import ExactSolution
from mpmverify.solution import Solution, Work

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

"""Verdicts: what must hold of a series of runs, judged from stored numbers alone."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from mpmverify import axis as refined
from mpmverify.convergence import Convergence, analyse
from mpmverify.exact import VerificationProblem
from mpmverify.norms import NORMS
from mpmverify.problem import Array, Discretisation
from mpmverify.solution import ADVICE, Solution
from mpmverify.verdict import Judgement, Verdict, worst


@dataclass(frozen=True)
class Evidence:
    """What one series of runs, n levels of one solver, left behind.

    Parameters
    ----------
    h, dt, courant, ppc : Array
        Levels (n,).
    outcomes : tuple of str
        "completed", or what happened, by level.
    error, reference : mapping of str to Array
        Norms of the error and of the exact field by quantity, (n, norms) in the order of `norms.NORMS`.
    metrics : mapping of str to Array
        Whatever the criteria measured on the solutions, (n,) by name.
    jitter, seed : Array, optional
        Of the particles, (n,); None where all stand at their places.
    """

    h: Array
    dt: Array
    courant: Array
    ppc: Array
    outcomes: tuple[str, ...]
    error: Mapping[str, Array] = field(default_factory=dict)
    reference: Mapping[str, Array] = field(default_factory=dict)
    metrics: Mapping[str, Array] = field(default_factory=dict)
    jitter: Array | None = None
    seed: Array | None = None

    @property
    def axis(self) -> refined.Axis:
        """What the levels refine."""
        return refined.axis(self.h, self.dt, self.ppc)

    @property
    def names(self) -> tuple[str, ...]:
        """Each level by its cell size, and by its Courant number and particles per cell where several share that."""
        if len(np.unique(self.h)) == len(self.h):
            return tuple(f"h={h:g}" for h in self.h)
        return tuple(f"h={h:g} nu_C={c:g} ppc={ppc}" for h, c, ppc in zip(self.h, self.courant, self.ppc, strict=True))

    @property
    def incomplete(self) -> str:
        """What became of the runs that did not complete, each outcome and each advice once; "" where every run did."""
        levels: dict[tuple[str, str], list[int]] = {}
        for k, outcome in enumerate(self.outcomes):
            advice = next((known for known in ADVICE.values() if known and outcome.endswith(f"; {known}")), "")
            levels.setdefault((advice, outcome.removesuffix(f"; {advice}")), []).append(k)
        sentences: dict[str, list[str]] = {}
        for (advice, outcome), members in levels.items():
            if outcome != "completed":
                sentences.setdefault(advice, []).append(f"{self._which(members)}: {outcome}")
        return "; ".join(part for advice, told in sentences.items() for part in (*told, advice) if part)

    def _which(self, levels: Sequence[int]) -> str:
        """Name some levels, in ascending order: neighbours by the first and the last of them."""
        if len(levels) == len(self.outcomes) > 1:
            return "every level"
        spans: list[list[int]] = []
        for k in levels:
            if spans and k == spans[-1][-1] + 1:
                spans[-1].append(k)
            else:
                spans.append([k])
        first_to_last = (dict.fromkeys((self.names[span[0]], self.names[span[-1]])) for span in spans)
        return ", ".join(" to ".join(ends) for ends in first_to_last)

    @property
    def sizes(self) -> Mapping[str, Array]:
        """Every size that an error may vanish with, by its name (n,)."""
        return refined.sizes(self.h, self.dt, self.ppc)

    def relative(self, quantity: str, norm: str) -> Array:
        """Error over the exact norm (n,); absolute where the exact field vanishes, NaN where its norm is not finite."""
        k = NORMS.index(norm)
        size = np.where(np.isfinite(self.reference[quantity][:, k]), self.reference[quantity][:, k], np.nan)
        return self.error[quantity][:, k] / np.where(size == 0, 1.0, size)

    def convergence(self, quantity: str, norm: str, expected: tuple[float, float] | None = None) -> Convergence | None:
        """Analyse one relative error over the size that the levels refine; None for a design, which has no single order."""
        size = self.axis.size
        if not size:
            return None
        series = analyse(self.sizes[size], self.relative(quantity, norm), expected=expected)
        return replace(series, dropped=tuple(re.sub(r"^h=", f"{size}=", sentence) for sentence in series.dropped))


@dataclass(frozen=True)
class Setting:
    """What a run was to solve: the problem with its exact solution, and on which level."""

    problem: VerificationProblem
    discretisation: Discretisation


class Criterion(Protocol):
    """What must hold."""

    @property
    def source(self) -> str:
        """Where the expectation comes from."""

    @property
    def title(self) -> str:
        """What is judged, in a few words."""

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        """Numbers that the judgement needs and only the solution can give, by name."""

    def judge(self, evidence: Evidence) -> Judgement:
        """Verdict on completed runs, with the reason in one sentence."""


class OnOutcomes:
    """Base of a criterion on how runs end: it is asked of runs with any outcome, every other one of completed runs alone."""


@dataclass(frozen=True)
class Finding:
    """One verdict with everything that a reader needs to act on it.

    Parameters
    ----------
    study, case, solver, refinement : str
        What was judged.
    gate : str
        "verification" or "regression".
    criterion : str
        Title of the criterion.
    verdict : Verdict
    reason : str
        What was measured.
    source : str
        Where the expectation comes from.
    """

    study: str
    case: str
    solver: str
    refinement: str
    gate: str
    criterion: str
    verdict: Verdict
    reason: str
    source: str

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> "Finding":
        """Make a finding of its fields as a file holds them; an unknown verdict is a `ValueError`."""
        return cls(**(dict(fields) | {"verdict": Verdict(fields["verdict"])}))

    def __str__(self) -> str:
        return f"{self.verdict} {self.study}/{self.case}/{self.solver} ({self.refinement}): {self.criterion}: {self.reason}"


def judge(criterion: Criterion, evidence: Evidence) -> Judgement:
    """Judge one criterion; a run that did not complete is an ERROR with its outcome, before any number is looked at.

    Save for a criterion on outcomes.
    """
    if evidence.incomplete and not isinstance(criterion, OnOutcomes):
        return Verdict.ERROR, evidence.incomplete
    if not evidence.outcomes:
        return Verdict.ERROR, "no level was run"
    try:
        return criterion.judge(evidence)
    except KeyError as missing:
        return (
            Verdict.ERROR,
            f"{missing} was not measured on this series: the solver does not return it, or the results are old",
        )


def exit_status(verdicts: Sequence[Verdict], *, strict: bool = False) -> int:
    """Exit status of a gate: 0 pass, 1 a gate failed, 3 a run erred or nothing was judged, 4 inconclusive under `strict`."""
    verdict = worst(verdicts) if verdicts else Verdict.ERROR
    if verdict is Verdict.INCONCLUSIVE:
        return 4 if strict else 0
    return {Verdict.PASS: 0, Verdict.FAIL: 1, Verdict.ERROR: 3}[verdict]

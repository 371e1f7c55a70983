"""How far to trust the verdicts: the faults that were planted in the solvers, and the runs of the unmodified ones."""

from collections.abc import Sequence

from mpmverify.judgement.kill_table import Fate, PlantedFault, Rate, SelfTest, total

from .notation import count
from .pages import TrustPage
from .parts import Fact, Fates, FaultRow, Link, Mark, Origin, Plain, RateTable

MEANING = {
    Fate.KILLED: "A criterion of a study failed, a run did not complete, or its solution breaks the contract.",
    Fate.REGRESSION: "Every criterion passed, and an error grew beyond the baseline.",
    Fate.BROKEN: "It does not compile, raises, hangs or refuses the problem: the run is an ERROR, whatever the criteria.",
    Fate.EQUIVALENT: "Its results agree with the original's to 1e-11 on every trial, fields and histories.",
    Fate.NOT_EXERCISED: "No trial comes to its passage.",
    Fate.UNDECIDED: "The machine was too busy to tell: the self-test, run again, tries it again.",
    Fate.SURVIVED: "Its results differ, and everything passed.",
}
SHOWN = 160
"""Characters of a passage that are shown."""


def trust_page(test: SelfTest, file: str, facts: Sequence[tuple[str, str]], pages: Sequence[Link], generator: str) -> TrustPage:
    """Make the page of a self-test.

    Parameters
    ----------
    test : SelfTest
    file : str
        Its file, without suffix, below the results folder.
    facts : sequence of (str, str)
        Provenance.
    pages : sequence of Link
        The other pages.
    generator : str
    """
    table = test.table()
    changing = sum(count for fates in table.values() for fate, count in fates.items() if fate in CHANGING)
    caught = changing - len(_of(test, Fate.SURVIVED))
    kind, word = ("pass", "PASS") if test.passed else ("fail", "FAIL")
    rules = tuple(Fates(rule, str(sum(fates.values())), tuple(map(str, fates.values()))) for rule, fates in table.items())
    totals = [sum(fates[fate] for fates in table.values()) for fate in Fate]
    return TrustPage(
        title="How far to trust this",
        generator=generator,
        navigation=(*pages, Link("How far to trust this", "trust.html", True)),
        mark=Mark(kind, word, f"{caught} of {changing}"),
        sample=f"{len(test.faults)} faults were planted one at a time, in copies of the shipped solvers: those of a list, "
        + ("and a sample of" if test.tier == "full" else "and none of")
        + f" the {test.sites} that the rules make.",
        fates=tuple(fate.value for fate in Fate),
        rules=rules,
        total=Fates("all", str(sum(totals)), tuple(map(str, totals))),
        meanings=tuple(Fact(fate.value, meaning) for fate, meaning in MEANING.items()),
        survivors=tuple(
            _row(fault) for fate in (Fate.SURVIVED, Fate.UNDECIDED, Fate.NOT_EXERCISED) for fault in _of(test, fate)
        ),
        named=tuple(_row(fault) for fault in test.faults if fault.rule == "named"),
        by_rule=tuple(_row(fault) for fault in test.faults if fault.rule != "named"),
        runs=tuple(
            Plain(
                Mark(run.verdict.lower(), run.verdict),
                (str(run.jobs), str(run.threads), f"{run.jitter:g}", str(run.seed) if run.jitter else "–", str(run.judged)),
                run.reason,
            )
            for run in test.runs
        ),
        alarms=f"{len(test.false_alarms)} of {len(test.runs)} runs of the unmodified solvers raised a false alarm.",
        judge=_judge(test.rates.series),
        rates=tuple(
            RateTable(caption, tuple(_rate(rate) for rate in rates))
            for caption, rates in (
                ("Error series, by kind", test.rates.series),
                ("Sources of error told apart over a design", test.rates.designs),
                ("At the limits of what a finite ladder shows: wrong verdicts here are inherent", test.rates.limits),
            )
            if rates
        ),
        command=f"mpmverify selftest --tier {test.tier}",
        origins=(Origin(file, f"../{file}.nc", tuple(Fact(name, value) for name, value in facts)),),
    )


CHANGING = (Fate.KILLED, Fate.REGRESSION, Fate.BROKEN, Fate.SURVIVED)
"""Fates of faults that change results."""


def _of(test: SelfTest, fate: Fate) -> list[PlantedFault]:
    return [fault for fault in test.faults if fault.fate is fate]


def _row(fault: PlantedFault) -> FaultRow:
    explained = fault.fate is Fate.SURVIVED and bool(fault.explanation)
    kind = {
        Fate.SURVIVED: "inconclusive" if explained else "fail",
        Fate.UNDECIDED: "inconclusive",
        Fate.NOT_EXERCISED: "inconclusive",
        Fate.EQUIVALENT: "inconclusive",
    }.get(fault.fate, "pass")
    where = f"{fault.study} / {fault.case} / {fault.solver}" if fault.study else ""
    return FaultRow(
        mark=Mark(kind, f"{fault.fate}, explained" if explained else fault.fate.value),
        name=fault.name,
        place=f"{fault.file}:{fault.line}",
        before=_short(fault.before),
        after=_short(fault.after),
        by=f"{fault.verdict} {fault.criterion}".strip(),
        where=where,
        reason=fault.explanation or fault.reason or f"largest deviation {fault.deviation:.1e} over {fault.trials} trials",
    )


def _judge(rates: Sequence[Rate]) -> str:
    if not rates:
        return "The judge was not asked about random series: the unmodified solvers did not pass."
    every = total(rates)
    return (
        f"Of {count(every.series)} random error series of known truth the judge passed {every.wrong_pass / every.series:.3%} wrongly and failed "
        f"{every.wrong_fail / every.series:.3%} wrongly; on {every.inconclusive / every.series:.0%} it says that they decide nothing yet."
    )


def _rate(rate: Rate) -> tuple[str, str, tuple[str, ...]]:
    shares = (rate.right, rate.inconclusive, rate.wrong_pass, rate.wrong_fail)
    cells = tuple(f"{count / rate.series:.2%}" if count else "0" for count in shares) if rate.series else ("–",) * len(shares)
    return rate.kind, rate.truth, (str(rate.series), *cells)


def _short(text: str) -> str:
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"

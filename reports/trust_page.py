"""The trust page: planted faults, runs of the unmodified solvers, and verdicts on random series."""

from collections.abc import Sequence

from mpmverify.judgement.kill_table import Fate, PlantedFault, Rate, SelfTest, total

from .notation import count
from .pages import TrustPage
from .parts import Fact, Link, Mark, Origin
from .trust_parts import FateCounts, FaultRow, KillRow, RateTable, StudyKillsRow, UnmodifiedRow

MEANING = {
    Fate.KILLED: "A verification criterion failed, a run did not complete, or the solution was invalid.",
    Fate.REGRESSION: "Every verification criterion passed, but an error exceeded its baseline.",
    Fate.BROKEN: "The solver does not compile, raises an exception, hangs or refuses the problem: its run is an ERROR under any criterion.",
    Fate.EQUIVALENT: "All fields and histories agree with those of the unmodified solver to 1e-11 on every trial.",
    Fate.NOT_EXERCISED: "No trial reaches the changed passage.",
    Fate.UNDECIDED: "The machine was too busy to decide: run the self-test again to judge this fault.",
    Fate.SURVIVED: "The results differ, but every criterion passed.",
}
SHOWN = 160
"""Largest number of characters shown of a passage."""


def trust_page(test: SelfTest, file: str, facts: Sequence[tuple[str, str]], pages: Sequence[Link], generator: str) -> TrustPage:
    """Make the trust page of a self-test.

    Parameters
    ----------
    test : SelfTest
    file : str
        Path of the self-test file relative to the results folder, without suffix.
    facts : sequence of (str, str)
        Provenance, as labels and values.
    pages : sequence of Link
        Links to the other pages.
    generator : str
        Name and version of the program.
    """
    table = test.table()
    changing = sum(count for fates in table.values() for fate, count in fates.items() if fate in CHANGING)
    caught = changing - len(_of(test, Fate.SURVIVED))
    kind, word = ("pass", "PASS") if test.passed else ("fail", "FAIL")
    rules = tuple(FateCounts(rule, str(sum(fates.values())), tuple(map(str, fates.values()))) for rule, fates in table.items())
    totals = [sum(fates[fate] for fates in table.values()) for fate in Fate]
    return TrustPage(
        title="How far to trust this",
        generator=generator,
        root="",
        navigation=(*pages, Link("How far to trust this", "trust.html", True)),
        mark=Mark(kind, word, f"{caught} of {changing}"),
        sample=f"{len(test.faults)} faults were planted one at a time in copies of the shipped solvers: the named faults and "
        + ("a sample of" if test.tier == "full" else "none of")
        + f" the {test.sites} faults by rule.",
        fates=tuple(fate.value for fate in Fate),
        rules=rules,
        total=FateCounts("all", str(sum(totals)), tuple(map(str, totals))),
        meanings=tuple(Fact(fate.value, meaning) for fate, meaning in MEANING.items()),
        studies=tuple(StudyKillsRow(s.study, str(s.ran), str(s.killed), str(s.alone)) for s in test.studies()),
        kills=_kills(test),
        survivors=tuple(
            _row(fault) for fate in (Fate.SURVIVED, Fate.UNDECIDED, Fate.NOT_EXERCISED) for fault in _of(test, fate)
        ),
        named=tuple(_row(fault) for fault in test.faults if fault.rule == "named"),
        by_rule=tuple(_row(fault) for fault in test.faults if fault.rule != "named"),
        runs=tuple(
            UnmodifiedRow(
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
                ("Sources of error separated over a design", test.rates.designs),
                ("Series that a finite ladder cannot resolve: some wrong verdicts are unavoidable", test.rates.limits),
            )
            if rates
        ),
        command=f"mpmverify selftest --tier {test.tier}" + " --every-study" * test.every_study,
        origins=(Origin(file, f"../{file}.nc", tuple(Fact(name, value) for name, value in facts)),),
    )


CHANGING = (Fate.KILLED, Fate.REGRESSION, Fate.BROKEN, Fate.SURVIVED)
"""Fates of the faults that change results."""


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


def _kills(test: SelfTest) -> tuple[KillRow, ...]:
    """Return a row for each fault that changes results and runs; the faults that the fewest studies kill come first."""
    studies = [seen.study for seen in test.studies()]
    rows = []
    for fault in test.faults:
        if studies and fault.fate in (Fate.KILLED, Fate.REGRESSION, Fate.SURVIVED):
            killed, passed = fault.killed_by.split(","), fault.passed.split(",")
            cells = ["killed" if study in killed else "passed" if study in passed else "" for study in studies]
            rows.append(KillRow(fault.name, fault.rule, tuple(cells)))
    return tuple(sorted(rows, key=lambda row: row.cells.count("killed")))


def _judge(rates: Sequence[Rate]) -> str:
    if not rates:
        return "Verdicts on random series were not measured, because the unmodified solvers did not pass."
    every = total(rates)
    return (
        f"Of {count(every.series)} random error series of known truth, {every.wrong_pass / every.series:.3%} received a wrong PASS, "
        f"{every.wrong_fail / every.series:.3%} a wrong FAIL and {every.inconclusive / every.series:.0%} INCONCLUSIVE."
    )


def _rate(rate: Rate) -> tuple[str, str, tuple[str, ...]]:
    shares = (rate.right, rate.inconclusive, rate.wrong_pass, rate.wrong_fail)
    cells = tuple(f"{count / rate.series:.2%}" if count else "0" for count in shares) if rate.series else ("–",) * len(shares)
    return rate.kind, rate.truth, (str(rate.series), *cells)


def _short(text: str) -> str:
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"

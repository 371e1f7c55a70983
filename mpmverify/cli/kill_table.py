"""What the command line shows of a self-test."""

from rich.markup import escape
from rich.table import Table

from mpmverify.cli.console import console
from mpmverify.convergence.synthetic import total
from mpmverify.judgement.kill_table import Fate, SelfTest


def show_selftest(test: SelfTest, *, explain: bool = False) -> None:
    """Print the kill table, then every survivor and every false alarm (with `explain`, every fault)."""
    output = console()
    table = Table("rule", "planted", *Fate)
    rows = test.table()
    for rule, fates in rows.items():
        table.add_row(rule, *(str(count) for count in (sum(fates.values()), *fates.values())))
    totals = [sum(fates[fate] for fates in rows.values()) for fate in Fate]
    table.add_row("all", *(f"[bold]{count}[/]" for count in (sum(totals), *totals)))
    output.print(table)
    if test.every_study:
        by_study = Table("study", "ran", "killed", "killed by it alone")
        for study in test.studies():
            by_study.add_row(study.study, str(study.ran), str(study.killed), str(study.alone))
        output.print(by_study)
    for fault in test.faults:
        if explain or fault.fate in (Fate.SURVIVED, Fate.UNDECIDED, Fate.NOT_EXERCISED):
            said = f"{fault.verdict} {fault.study}/{fault.case}/{fault.solver}: {fault.criterion}: " if fault.verdict else ""
            reason = fault.explanation or f"{said}{fault.reason}" or f"results differ by {fault.deviation:.1e} of their size"
            place = f"{fault.id} {fault.name} ({fault.file}:{fault.line})"
            output.print(f"[bold]{fault.fate.value}[/]", escape(f"{place}: {reason}"), highlight=False)
    for run in test.false_alarms:
        where = f"{run.jobs} processes, {run.threads} threads, jitter {run.jitter:g}, seed {run.seed}"
        output.print("[bold red]false alarm[/]", escape(f"{where}: {run.reason}"), highlight=False)
    output.print(
        f"{len(test.faults)} faults of {test.sites} by rule and by name, {len(test.unexplained)} unexplained survivors; "
        f"{len(test.runs)} unmodified runs, {len(test.false_alarms)} false alarms.",
        highlight=False,
    )
    for name, rates in (("series", test.rates.series), ("designs", test.rates.designs)):
        if rates:
            every = total(rates)
            shares = (
                f"{every.wrong_pass / every.series:.2%} passed wrongly, {every.wrong_fail / every.series:.2%} failed wrongly"
            )
            output.print(f"{every.series} random {name} of known truth: {shares}.", highlight=False)

"""Commands that solve: list the studies, run them, plant faults in their solvers."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mpmverify.cli.options import (
    EPILOG,
    baseline_option,
    explain_option,
    jobs_option,
    open_option,
    out_option,
    positive,
    studies_argument,
)
from mpmverify.cli.results import accepted, show_report
from mpmverify.errors import UsageError

if TYPE_CHECKING:
    from mpmverify.execution.runner import Plan
    from mpmverify.judgement.findings import Finding
    from mpmverify.solution import Solver
    from mpmverify.study import Study


@click.command("list")
@studies_argument
def list_(studies: tuple[str, ...]) -> None:
    """List the studies, their cases and solvers; of a STUDY that is named, what each case asks of a solver."""
    from mpmverify.cli.cases import described

    for study in _chosen(studies, (), None):
        click.echo(f"{study.name}: {study.title}")
        if not studies:
            click.echo(f"  cases    {'; '.join(case.name for case in study.cases)}")
        click.echo(f"  solvers  {', '.join(study.solvers())}")
        for case in study.cases if studies else ():
            click.echo(f"\n{study.name}, {case.name}")
            for name, text in described(case):
                click.echo(f"  {name:<12} {text}")


@click.command(epilog=EPILOG)
@studies_argument
@out_option
@baseline_option
@jobs_option
@click.option("--scheduler", default="", metavar="ADDRESS", help="Run on a dask.distributed scheduler.")
@click.option("--tier", type=click.Choice(["quick", "full"]), default="quick", show_default=True, help="How many levels.")
@click.option("--solver", "solvers", multiple=True, metavar="NAME", help="Run this solver alone; may be repeated.")
@click.option(
    "--with",
    "own",
    default="",
    metavar="FILE.py:NAME",
    help="Judge this solver of yours by what it declares; or a file bench.toml that describes a program or its results.",
)
@click.option("--courant", type=float, callback=positive, help="Run every level at this Courant number instead.")
@click.option("--timeout", type=float, callback=positive, default=600.0, show_default=True, help="Limit for one run [s].")
@click.option("--no-cache", is_flag=True, help="Solve again what is already solved.")
@explain_option
@open_option
def run(
    studies: tuple[str, ...],
    out: Path,
    baseline: Path | None,
    jobs: int | None,
    scheduler: str,
    tier: str,
    solvers: tuple[str, ...],
    own: str,
    courant: float | None,
    timeout: float,
    no_cache: bool,
    explain: bool,
    open_: bool,
) -> None:
    """Solve what is not solved yet, judge it, and write datasets and the report.

    Without STUDY, all studies run. A study of your own is given as FILE.py:NAME or MODULE:NAME.
    """
    from mpmverify.cli.console import console
    from mpmverify.cli.findings import StudyTable, show, show_diagnosis
    from mpmverify.cli.progress import Progress
    from mpmverify.convergence.verdict import exit_status
    from mpmverify.dataset.files import Results
    from mpmverify.execution.processes import processors
    from mpmverify.execution.runner import Plan
    from mpmverify.execution.runner import run as run_studies
    from mpmverify.reports import render_study

    plan = Plan(
        results=Results(out),
        baseline=accepted(baseline),
        tier=tier,
        jobs=jobs or processors(),
        timeout=timeout,
        reuse=not no_cache,
        scheduler=scheduler,
    )
    chosen = _judging(own, studies, solvers, courant, plan) if own else _chosen(studies, solvers, courant)
    names = [study.name for study in chosen]
    findings: list[Finding] = []
    pages = {}
    solved = reused = 0
    output = console()
    table = StudyTable(output, names, timed=True)
    with Progress(output) as progress:
        for judged in run_studies(chosen, plan, progress.update, render_study):
            table.add(judged.study, judged.findings, judged.seconds)
            findings += judged.findings
            pages[judged.study] = judged.shown
            solved, reused = solved + judged.solved, reused + judged.reused
    findings.sort(key=lambda finding: names.index(finding.study))
    show(output, findings, explain=explain)
    if own:
        show_diagnosis(output, chosen, findings, plan.results)
    click.echo(f"{solved} runs solved, {reused} already at hand.")
    show_report(plan.results, opened=open_, pages=pages)  # last: the verdicts are shown even when no report can be written
    sys.exit(exit_status([finding.verdict for finding in findings]))


@click.command(epilog="Exit status: 0 every fault was caught or is explained and nothing passed wrongly, 1 otherwise, 2 usage.")
@out_option
@baseline_option
@click.option("--jobs", type=click.IntRange(min=1), help="Faults at a time  [default: one a processor]")
@click.option(
    "--tier",
    type=click.Choice(["quick", "full"]),
    default="quick",
    show_default=True,
    help="The named faults alone, or those by rule, too.",
)
@click.option("--every-study", is_flag=True, help="Try a fault on every study, not only up to its first kill: takes hours.")
@click.option("--explain", is_flag=True, help="Print what killed every fault.")
@click.option(
    "--signatures",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the table by which failures are diagnosed, and do nothing else: takes half an hour of processor time.",
)
def selftest(
    out: Path, baseline: Path | None, jobs: int | None, tier: str, every_study: bool, explain: bool, signatures: Path | None
) -> None:
    """Plant faults in the shipped solvers and see that the studies catch them; and that they pass the unmodified ones.

    What is known of a fault is kept: an interrupted self-test goes on where it was.
    """
    from rich.console import Console

    from mpmverify import solvers, studies
    from mpmverify.cli.kill_table import show_selftest
    from mpmverify.cli.progress import Progress
    from mpmverify.dataset.files import Results
    from mpmverify.dataset.selftest import write_selftest
    from mpmverify.execution.processes import processors
    from mpmverify.selftest.session import Session

    sources = Path(solvers.__file__).parent
    if signatures:
        from mpmverify.selftest.signatures import make_signatures
        from mpmverify.solvers.textbook import Textbook

        if not signatures.absolute().parent.is_dir():
            raise UsageError(f"'{signatures.parent}' is no folder: make it first, or choose another place for the table")
        with Progress(Console(stderr=True)) as progress:
            table = make_signatures(studies.get, sources, Textbook, jobs or processors(), progress.update)
        table.write(signatures)
        return
    results, known = Results(out), accepted(baseline)
    results.create()
    with Progress(Console(stderr=True)) as progress:
        session = Session(results, studies.get, sources, known, tier, jobs or processors(), every_study)
        test = session.run(progress.update)
    write_selftest(results.selftest, test)
    show_selftest(test, explain=explain)
    show_report(results)
    sys.exit(0 if test.passed else 1)


def _chosen(names: Sequence[str], solvers: tuple[str, ...], courant: float | None) -> "list[Study]":
    from mpmverify import studies

    found = [declared(name) for name in dict.fromkeys(names or studies.NAMES)]
    known = {solver for study in found for solver in study.solvers()}
    for solver in solvers:
        if solver not in known:
            raise UsageError(f"unknown solver {solver!r}: choose from {', '.join(sorted(known))}")
    restricted = [study.restricted(solvers, courant) for study in found]
    return [study for study in restricted if study.cases]


def _judging(name: str, studies: Sequence[str], solvers: tuple[str, ...], courant: float | None, plan: "Plan") -> "list[Study]":
    """Studies that judge a solver by what it declares; says which cases are left out, and why."""
    from mpmverify.adapters.files import Files
    from mpmverify.adapters.names import own_solver
    from mpmverify.cli.console import say_left_out
    from mpmverify.execution.refusals import without_refused

    solver, chosen = own_solver(name), []
    if isinstance(solver, Files):
        if studies or solvers or courant is not None:
            raise UsageError(f"'{name}' says what was exported: leave out studies, --solver and --courant")
        wanted = [solver.study(declared)]
    else:
        wanted = _chosen(studies, solvers, courant)
    left_out: list[tuple[str, str]] = []
    for study in wanted:
        try:
            kept, refused = without_refused(study.with_solver(solver), solver, plan)
        except UsageError as error:
            kept, refused = None, {"": str(error)}
        refused = {**refused, **_unable(study, solver)} if kept else refused
        left_out += [(f"{study.name}{case and f', {case}'}", reason) for case, reason in refused.items()]
        if kept:
            chosen.append(kept)
    say_left_out(left_out)
    if not chosen:
        raise UsageError(left_out[-1][1] if left_out else f"no study can judge {solver.name!r}")
    return chosen


def _unable(study: "Study", solver: "Solver") -> dict[str, str]:
    """Return the cases of a study that cannot judge what a solver declares, with the reasons."""
    reasons = {}
    for case in study.cases:
        try:
            case.with_solver(solver)
        except UsageError as error:
            reasons[case.name] = str(error)
    return reasons


def declared(name: str) -> "Study":
    """Return a shipped study, or one of own code, by name."""
    from mpmverify import studies
    from mpmverify.adapters.names import is_own, own_study

    return own_study(name) if is_own(name) else studies.get(name)

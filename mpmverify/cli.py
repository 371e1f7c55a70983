"""Command line: every command parses, calls the library, displays or aborts; heavy imports stay inside."""

import math
import os
import sys
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from mpmverify import __version__
from mpmverify.command import Group
from mpmverify.errors import UsageError
from mpmverify.judge import judge

if TYPE_CHECKING:
    from mpmverify.gate import Finding
    from mpmverify.study import Study

EPILOG = "Exit status: 0 pass, 1 a gate failed, 2 usage, 3 a run erred, 4 inconclusive under --strict."


def positive(_ctx: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Accept a positive finite number or nothing."""
    if value is not None and not (math.isfinite(value) and value > 0):
        raise click.BadParameter(f"must be positive and finite, not {value:g}", param=parameter)
    return value


out_option = click.option(
    "--out", type=click.Path(path_type=Path), default=Path("results"), show_default=True, help="Results folder."
)
baseline_option = click.option(
    "--baseline", type=click.Path(path_type=Path), help="Baseline of the regression gate  [default: the shipped one]"
)
studies_argument = click.argument("studies", metavar="[STUDY]...", nargs=-1)


@click.group(cls=Group, epilog=EPILOG, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mpmverify")
def cli() -> None:
    """Prove that a wave solver is right: convergence studies, accuracy gates and reports."""


@cli.command("list")
def list_() -> None:
    """List the studies, their cases and solvers."""
    from mpmverify import studies

    for name in studies.NAMES:
        study = studies.get(name)
        click.echo(f"{name}: {study.title}")
        click.echo(f"  cases    {', '.join(case.name for case in study.cases)}")
        click.echo(f"  solvers  {', '.join(study.solver_names())}")


@cli.command(epilog=EPILOG)
@studies_argument
@out_option
@baseline_option
@click.option("--jobs", type=click.IntRange(min=1), help="Worker processes  [default: one a processor]")
@click.option("--scheduler", default="", metavar="ADDRESS", help="Run on a dask.distributed scheduler.")
@click.option("--tier", type=click.Choice(["quick", "full"]), default="quick", show_default=True, help="How many levels.")
@click.option("--solver", "solvers", multiple=True, metavar="NAME", help="Run this solver alone; may be repeated.")
@click.option("--courant", type=float, callback=positive, help="Run every level at this Courant number instead.")
@click.option("--timeout", type=float, callback=positive, default=600.0, show_default=True, help="Limit for one run [s].")
@click.option("--no-cache", is_flag=True, help="Solve again what is already solved.")
@click.option("--explain", is_flag=True, help="Print the reason of every verdict, and where its expectation comes from.")
@click.option("--open", "open_", is_flag=True, help="Open the report in the browser.")
def run(
    studies: tuple[str, ...],
    out: Path,
    baseline: Path | None,
    jobs: int | None,
    scheduler: str,
    tier: str,
    solvers: tuple[str, ...],
    courant: float | None,
    timeout: float,
    no_cache: bool,
    explain: bool,
    open_: bool,
) -> None:
    """Solve what is not solved yet, judge it, and write datasets and the report.

    Without STUDY, all studies run.
    """
    from mpmverify.baseline import read_baseline
    from mpmverify.dataset.files import Results
    from mpmverify.display import Progress, show
    from mpmverify.gate import exit_status
    from mpmverify.pool import processors
    from mpmverify.runner import Plan
    from mpmverify.runner import run as run_studies

    plan = Plan(
        results=Results(out),
        baseline=read_baseline(baseline or _shipped_baseline()),
        tier=tier,
        jobs=jobs or processors(),
        timeout=timeout,
        reuse=not no_cache,
        scheduler=scheduler,
    )
    chosen = _chosen(studies, solvers, courant)
    names = [study.name for study in chosen]
    findings: list[Finding] = []
    solved = reused = 0
    with Progress() as progress:
        for judged in run_studies(chosen, plan, progress.update):
            findings += judged.findings
            solved, reused = solved + judged.solved, reused + judged.reused
    findings.sort(key=lambda finding: names.index(finding.study))
    page = _render(plan.results)
    show(findings, explain=explain)
    click.echo(f"{solved} runs solved, {reused} already at hand.")
    click.echo(f"Report: {page}")
    if open_:
        webbrowser.open(page.resolve().as_uri())
    sys.exit(exit_status([finding.verdict for finding in findings]))


@cli.command(epilog=EPILOG)
@studies_argument
@out_option
@baseline_option
@click.option("--junit", type=click.Path(path_type=Path, dir_okay=False), help="Write JUnit XML here.")
@click.option(
    "--summary",
    type=click.Path(path_type=Path, dir_okay=False),
    envvar="GITHUB_STEP_SUMMARY",
    help="Append a Markdown summary here  [default: $GITHUB_STEP_SUMMARY]",
)
@click.option("--strict", is_flag=True, help="Exit with 4 when a verdict is inconclusive.")
@click.option("--explain", is_flag=True, help="Print the reason of every verdict, and where its expectation comes from.")
def gate(
    studies: tuple[str, ...],
    out: Path,
    baseline: Path | None,
    junit: Path | None,
    summary: Path | None,
    strict: bool,
    explain: bool,
) -> None:
    """Judge stored results; nothing is run and nothing is changed.

    On GitHub ($GITHUB_ACTIONS is "true") the worst ten findings become annotations.
    """
    from mpmverify import summary as summaries
    from mpmverify.baseline import read_baseline
    from mpmverify.dataset.study import read_study
    from mpmverify.dataset.verdicts import findings as findings_of
    from mpmverify.dataset.verdicts import judged
    from mpmverify.display import show
    from mpmverify.gate import exit_status

    accepted = read_baseline(baseline or _shipped_baseline())
    findings = [f for path in _stored(out, studies) for f in findings_of(judged(read_study(path), accepted))]
    if junit:
        with _opened(junit, "wb") as file:
            file.write(summaries.junit(findings))
    if summary:
        with _opened(summary, "ab") as file:
            text = summaries.markdown(findings, summaries.STEP_SUMMARY - (file.tell() if file.seekable() else 0))
            file.write(text.encode())
        if not text:
            click.echo(f"'{summary}' is full: no verdicts were added to it.", err=True)
    show(findings, explain=explain)
    if os.environ.get("GITHUB_ACTIONS") == "true":
        for command in summaries.annotations(findings, out):
            click.echo(command)
    sys.exit(exit_status([finding.verdict for finding in findings], strict=strict))


cli.add_command(judge)


@cli.command()
@out_option
@click.option("--open", "open_", is_flag=True, help="Open the report in the browser.")
def report(out: Path, open_: bool) -> None:
    """Render the report anew from the stored results alone."""
    from mpmverify.dataset.files import Results

    _stored(out, ())
    page = _render(Results(out), fresh=True)
    click.echo(f"Report: {page}")
    if open_:
        webbrowser.open(page.resolve().as_uri())


@cli.command(epilog="Exit status: 0 nothing is worse or lost, 1 something is, 2 usage.")
@click.argument("before", metavar="A", type=click.Path(path_type=Path))
@click.argument("after", metavar="B", type=click.Path(path_type=Path))
@click.option("--explain", is_flag=True, help="Print every change.")
def compare(before: Path, after: Path, explain: bool) -> None:
    """Say what became worse, slower, lost, new, faster or better from the results in A to those in B.

    Nothing is run: verdicts, errors, orders, steps and seconds are those in the files.
    """
    from mpmverify import comparison
    from mpmverify.dataset.tables import read_tables
    from mpmverify.display import show_comparison

    if before.resolve() == after.resolve():
        raise UsageError(f"A and B are both '{before}': name two results folders")
    a, b = (read_tables(_stored(path, ())) for path in (before, after))
    compared = comparison.compare(a, b)
    show_comparison(compared, explain=explain)
    sys.exit(compared.exit_status)


@cli.command(epilog="Exit status: 0 every fault was caught or is explained and nothing passed wrongly, 1 otherwise, 2 usage.")
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
@click.option("--explain", is_flag=True, help="Print what killed every fault.")
def selftest(out: Path, baseline: Path | None, jobs: int | None, tier: str, explain: bool) -> None:
    """Plant faults in the shipped solvers and see that the studies catch them; and that they pass the unmodified ones.

    What is known of a fault is kept: an interrupted self-test goes on where it was.
    """
    from mpmverify import solvers, studies
    from mpmverify.baseline import read_baseline
    from mpmverify.dataset.files import Results
    from mpmverify.dataset.selftest import write_selftest
    from mpmverify.display import Progress, show_selftest
    from mpmverify.selftest.session import Session

    results, accepted = Results(out), read_baseline(baseline or _shipped_baseline())
    results.create()
    sources = Path(solvers.__file__).parent
    with Progress() as progress:
        test = Session(results, studies.get, sources, accepted, tier, jobs or _processors()).run(progress.update)
    write_selftest(results.selftest, test)
    show_selftest(test, explain=explain)
    click.echo(f"Report: {_render(results)}")
    sys.exit(0 if test.passed else 1)


@cli.group(cls=Group)
def baseline() -> None:
    """Manage the baseline of the regression gate."""


@baseline.command()
@studies_argument
@out_option
@baseline_option
@click.option("--reason", required=True, help="Why the errors may change; kept in the baseline.")
def accept(studies: tuple[str, ...], out: Path, baseline: Path | None, reason: str) -> None:
    """Take the stored errors over into the baseline."""
    from mpmverify.baseline import read_baseline
    from mpmverify.dataset.study import read_study
    from mpmverify.dataset.verdicts import accepted

    if not reason.strip():
        raise UsageError("--reason must say why the errors may change")
    known = read_baseline(baseline or _shipped_baseline())
    trees = [read_study(path) for path in _stored(out, studies)]
    count = accepted(known, trees, reason.strip())
    known.write()
    click.echo(f"Accepted {count} series into {known.path}")


def _shipped_baseline() -> Path:
    from mpmverify import studies

    return studies.BASELINE


def _chosen(names: Sequence[str], solvers: tuple[str, ...], courant: float | None) -> "list[Study]":
    from mpmverify import studies

    declared = [studies.get(name) for name in dict.fromkeys(names or studies.NAMES)]
    known = {solver for study in declared for solver in study.solver_names()}
    for solver in solvers:
        if solver not in known:
            raise UsageError(f"unknown solver {solver!r}: choose from {', '.join(sorted(known))}")
    restricted = [study.restricted(solvers, courant) for study in declared]
    return [study for study in restricted if study.cases]


def _stored(out: Path, names: Sequence[str]) -> list[Path]:
    from mpmverify.dataset.files import Results

    results = Results(out)
    paths = [results.study(name) for name in dict.fromkeys(names)] if names else results.studies()
    for path in paths:
        if not path.exists():
            raise UsageError(f"no results of {path.stem!r} in '{out}': run `mpmverify run {path.stem} --out {out}` first")
    if not paths:
        raise UsageError(f"no results in '{out}': run `mpmverify run --out {out}` first")
    return paths


def _render(results: Any, *, fresh: bool = False) -> Path:
    from mpmverify.reports import render

    return render(results, fresh=fresh)


@contextmanager
def _opened(path: Path, mode: str) -> Iterator[Any]:
    try:
        with path.open(mode) as file:
            yield file
    except OSError as error:
        raise UsageError(f"cannot write '{path}' ({error.strerror}): choose another file") from error


def main() -> NoReturn:
    """Run the command line."""
    cli(prog_name="mpmverify")
    raise AssertionError("click exits by itself")

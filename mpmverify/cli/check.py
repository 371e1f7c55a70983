"""The command `check`: a first look at a solver."""

import sys
from typing import TYPE_CHECKING

import click

from mpmverify.errors import UsageError

if TYPE_CHECKING:
    from mpmverify.adapters.mistakes import Remark

CASES = 3
"""Number of cases that are tried unless studies are named."""


@click.command(epilog="Exit status: 0 nothing found, 1 something is wrong, 2 usage, 3 a run failed.")
@click.argument("what", metavar="SOLVER|PROBLEM")
@click.argument("studies", metavar="[STUDY]...", nargs=-1)
def check(what: str, studies: tuple[str, ...]) -> None:
    """Say what is wrong with the solutions of a SOLVER before any order is measured, and the likely cause; or with a PROBLEM.

    A SOLVER is FILE.py:NAME, MODULE:NAME, or a file bench.toml. Two coarse levels are solved of each case of the STUDY, or of the first
    cases that it takes. A PROBLEM is a VerificationProblem of yours by such a name: its closed form has to solve its equations.
    """
    from mpmverify import studies as shipped
    from mpmverify.adapters.check import check as found_in
    from mpmverify.adapters.check_problem import check_problem, not_looked_at
    from mpmverify.adapters.files import Files
    from mpmverify.adapters.names import own_object, own_solver
    from mpmverify.cli.console import say_left_out
    from mpmverify.cli.solving import declared
    from mpmverify.exact import VerificationProblem

    if isinstance(problem := own_object(what), VerificationProblem):
        found = check_problem(problem)
        for remark in found:
            _say(remark)
        for missing in not_looked_at(problem):
            click.echo(f"  NOT LOOKED AT: {missing}.")
        click.echo(
            f"{problem.problem.name}: {_count(len(found), 'remark') if found else 'every equation that was looked at holds'}."
        )
        sys.exit(1 if found else 0)
    own = own_solver(what)
    wanted = [own.study(declared)] if isinstance(own, Files) else [declared(name) for name in studies or shipped.NAMES]
    looked = wrong = crashed = 0
    refused: list[tuple[str, str]] = []
    for study in wanted:
        for case in study.cases:
            if crashed or (looked == CASES and not studies):
                break
            try:
                remarks = found_in(own, case)
            except UsageError as error:
                refused.append((f"{study.name}, {case.name}", str(error)))
                continue
            looked += 1
            click.echo(f"{study.name}, {case.name}: {'nothing found' if not remarks else ''}")
            for remark in remarks:
                _say(remark)
            wrong, crashed = wrong + len(remarks), crashed + sum(remark.crashed for remark in remarks)
    if not looked:
        raise UsageError(refused[-1][1])
    if studies:
        say_left_out(refused)
    click.echo(
        f"{_count(looked, 'case')} looked at, {_count(wrong, 'remark')}."
        + ("" if wrong else f" Next: mpmverify run --with {what}")
    )
    sys.exit(3 if crashed else 1 if wrong else 0)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _say(remark: "Remark") -> None:
    click.echo(f"  WRONG: {remark.what}." + (f"\n         Likely cause: {remark.cause}." if remark.cause else ""))

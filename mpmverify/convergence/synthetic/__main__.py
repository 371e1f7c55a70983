"""`python -m mpmverify.convergence.synthetic`: measure how often verdicts are right."""

import click
from rich.console import Console
from rich.table import Table

from mpmverify.convergence.synthetic.designs import measure_designs
from mpmverify.convergence.synthetic.kinds import Truth
from mpmverify.convergence.synthetic.rates import Rate, measure, measure_limits, total

COLUMNS = ("right", "inconclusive", "wrong_pass", "wrong_fail")


def table(title: str, rates: list[Rate]) -> Table:
    """Return a table of the rates, in percent of the series of each kind."""
    shown = Table("kind", "truth", "series", *(name.replace("_", " ") for name in COLUMNS), title=title)
    for row in (row for row in rates if row.series):
        shown.add_row(
            row.kind, row.truth, str(row.series), *(f"{100 * getattr(row, name) / row.series:.3g} %" for name in COLUMNS)
        )
    return shown


@click.command()
@click.option("--count", type=click.IntRange(min=1), default=20_000, show_default=True, help="Number of series.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the random numbers.")
def main(count: int, seed: int) -> None:
    """Judge random error series of known truth and print how often the verdict is right."""
    rates = measure(count, seed)
    console = Console(width=110)
    console.print(table("Verdicts on series of known truth", [*rates, *(total(rates, truth) for truth in Truth), total(rates)]))
    console.print(table("Separation of error sources on designs of known truth", measure_designs(max(1, count // 90), seed)))
    console.print(table("Series that are hard to decide", measure_limits(max(1, count // 4), seed)))


if __name__ == "__main__":
    main(prog_name="python -m mpmverify.convergence.synthetic")

"""`python -m mpmverify.convergence.synthetic`: measure how often verdicts are right."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import click
from rich.console import Console
from rich.table import Table

from mpmverify.convergence.synthetic.designs import measure_designs
from mpmverify.convergence.synthetic.ideal import ideal_rates
from mpmverify.convergence.synthetic.kinds import Truth
from mpmverify.convergence.synthetic.rates import Rate, measure, measure_limits, total

COLUMNS = ("right", "inconclusive", "wrong_pass", "wrong_fail")


def table(title: str, rates: Sequence[Rate], ideal: Mapping[str, float] = MappingProxyType({})) -> Table:
    """Return a table of the rates, in percent of the series of each kind, beside what the ideal judge decides rightly."""
    shown = Table("kind", "truth", "series", *(name.replace("_", " ") for name in COLUMNS), title=title)
    if ideal:
        shown.add_column("ideal judge")
    for row in (row for row in rates if row.series):
        shares = [f"{100 * getattr(row, name) / row.series:.3g} %" for name in COLUMNS]
        known = [f"{100 * ideal[row.kind]:.1f} %"] if row.kind in ideal else []
        shown.add_row(row.kind, row.truth, str(row.series), *shares, *known)
    return shown


@click.command()
@click.option("--count", type=click.IntRange(min=1), default=20_000, show_default=True, help="Number of series.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the random numbers.")
def main(count: int, seed: int) -> None:
    """Judge random error series of known truth and print how often the verdict is right.

    Beside the series, a fiftieth as many designs and a quarter as many series that are hard to decide are judged.
    """
    rates = measure(count, seed)
    console = Console(width=140)
    ideal = ideal_rates(max(20, count // 500), seed)
    console.print(
        table("Verdicts on series of known truth", [*rates, *(total(rates, truth) for truth in Truth), total(rates)], ideal)
    )
    decided = {truth: [rate for rate in rates if rate.truth is truth] for truth in (Truth.INSIDE, Truth.OUTSIDE)}
    for truth, kinds in decided.items():
        share = sum(rate.right / rate.series for rate in kinds) / sum(ideal[rate.kind] for rate in kinds)
        console.print(f"{truth}: {share:.1%} of what the ideal judge decides rightly are decided rightly.", highlight=False)
    console.print(table("Separation of error sources on designs of known truth", measure_designs(max(1, count // 50), seed)))
    console.print(table("Series that are hard to decide", measure_limits(max(1, count // 4), seed)))


if __name__ == "__main__":
    main(prog_name="python -m mpmverify.convergence.synthetic")

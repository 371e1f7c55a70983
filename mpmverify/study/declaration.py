"""Declarations of a study: verification problems, solvers, refinements and criteria, as values."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mpmverify.criteria import Order, Separated
from mpmverify.criteria.criterion import Criterion, misdeclared
from mpmverify.criteria.evidence import SeriesId
from mpmverify.criteria.expectations import MARGIN, expectations
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.solution import Solver
from mpmverify.study.refinement import Refinement


@dataclass(frozen=True)
class Series:
    """One solver on one ladder, with the criteria that its results must meet.

    Raises
    ------
    UsageError
        If a field of a criterion has a value that it cannot have.
    """

    solver: Solver
    refinement: Refinement
    criteria: tuple[Criterion, ...]

    def __post_init__(self) -> None:
        for criterion in self.criteria:
            if wrong := misdeclared(criterion):
                raise UsageError(wrong)


@dataclass(frozen=True)
class Case:
    """One verification problem and the series that are run on it.

    Parameters
    ----------
    name : str
        Name of the case within its study.
    problem : VerificationProblem
        The problem.
    series : tuple of Series
        Series on the problem.
    shown : str
        Quantity that the report plots first.
    norm : str
        Norm in which a solver of any origin is judged by the orders that it declares. By default L1 where the exact fields have finitely
        many derivatives, as in the theory of their orders, and else L2-max, since a field may vanish at the final time.
    ladder : Refinement, optional
        Ladder on which such a solver is judged. By default the first ladder in h at one Courant number among the series.

    margin : float
        Accepted difference between its observed and its declared orders: greater where surfaces cut cells, so that orders scatter.

    Raises
    ------
    UsageError
        If the norm is unknown, or another than L1 where that is the default.
    """

    name: str
    problem: VerificationProblem
    series: tuple[Series, ...]
    shown: str
    norm: str = ""
    ladder: Refinement | None = None
    margin: float = MARGIN

    def __post_init__(self) -> None:
        possible = NORMS[::-1] if np.isinf(self.problem.exact.derivatives) else ("L1",)
        object.__setattr__(self, "norm", self.norm or possible[0])
        if self.norm not in possible:
            raise UsageError(f"case {self.name!r} cannot be judged in the norm {self.norm!r}: choose {' or '.join(possible)}")

    def ladder_in_h(self) -> Refinement:
        """Return the ladder on which a solver of any origin is judged.

        Raises
        ------
        UsageError
            If no ladder of the case has dt proportional to h: declared orders hold on such a ladder alone.
        """
        ladders = [self.ladder] if self.ladder else [series.refinement for series in self.series]
        for ladder in ladders:
            if len({(level.courant, level.ppc) for level in ladder.levels}) == 1:
                return ladder
        raise UsageError(
            f"{ladders[0].label!r} on case {self.name!r} is not a ladder in h at one Courant number, on which declared orders "
            "hold: give such a ladder by refinement=, or give criteria="
        )

    def converging(self) -> list[Solver]:
        """Return the solvers of which the case expects an order.

        Raises
        ------
        UsageError
            If there is none: what a solver declares cannot be judged on the case then.
        """
        found = [s.solver for s in self.series if any(isinstance(criterion, Order | Separated) for criterion in s.criteria)]
        if not found:
            raise UsageError(f"case {self.name!r} expects an order of no solver: choose another case, or give criteria")
        return found

    def with_solver(self, solver: Solver) -> "Case":
        """Return the case with a solver of any origin, judged by what it declares, beside the one of the case that declares most alike.

        Raises
        ------
        UsageError
            If no order is expected on the case, no ladder shows the declared ones, or a declaration is invalid; see `expectations`.
        """
        converging, ladder = self.converging(), self.ladder_in_h()
        expectations(solver, self.problem, self.norm, self.margin)  # refuses what is no declaration
        beside = sorted(converging, key=lambda other: len(set(other.orders.items()) ^ set(solver.orders.items())))[:1]
        series = (
            Series(one, ladder, expectations(one, self.problem, self.norm, self.margin))
            for one in (solver, *(other for other in beside if other.name != solver.name))
        )
        return dataclasses.replace(self, series=tuple(series))


@dataclass(frozen=True)
class Study:
    """A set of cases that are run together and shown on one page.

    Parameters
    ----------
    name : str
        Name on the command line and in file names.
    title, summary : str
        Of the page.
    cases : tuple of Case
        The cases.
    restricted_to : str
        The solvers and the Courant number to which the declared study was restricted; "" if it is complete.

    Raises
    ------
    UsageError
        If two series have the same case, solver and refinement, two different solvers have the same name, or a name cannot be used
        for a file.
    """

    name: str
    title: str
    summary: str
    cases: tuple[Case, ...]
    restricted_to: str = ""

    def __post_init__(self) -> None:
        seen = set()
        named: dict[str, Solver] = {}
        for case, series in self.series():
            if (identity := (case.name, series.solver.name, series.refinement.label)) in seen:
                raise UsageError(f"study {self.name!r} declares {' / '.join(identity)} twice: remove one or rename its ladder")
            seen.add(identity)
            if named.setdefault(series.solver.name, series.solver) != series.solver:
                raise UsageError(f"study {self.name!r} has two solvers with the name {series.solver.name!r}: rename one")
        for name in (self.name, *named):
            if not name or "/" in name or name.startswith("."):
                raise UsageError(f"{name!r} cannot name a file: use a name without '/' that does not start with '.'")

    def series(self) -> Iterator[tuple[Case, Series]]:
        """Yield each case and series, in the order of declaration."""
        for case in self.cases:
            for series in case.series:
                yield case, series

    def criteria(self) -> dict[SeriesId, tuple[Criterion, ...]]:
        """Return the criteria of every series."""
        return {
            SeriesId(case.name, series.solver.name, series.refinement.label): series.criteria for case, series in self.series()
        }

    def in_tier(self, tier: str) -> "Study":
        """Return the study with only the series that have levels in a tier, and the cases that have such series.

        Parameters
        ----------
        tier : str
            "quick" or "full".

        Raises
        ------
        UsageError
            If there is no such tier, or no series has levels in it.
        """
        chosen = [(case, tuple(series for series in case.series if series.refinement.tier(tier))) for case in self.cases]
        cases = tuple(dataclasses.replace(case, series=series) for case, series in chosen if series)
        if not cases:
            raise UsageError(f"study {self.name!r} has no series in the {tier} tier: run the full tier")
        return dataclasses.replace(self, cases=cases)

    def with_solver(self, solver: Solver) -> "Study":
        """Return a study of its own that judges a solver of any origin by what it declares, on every case that can show that.

        Beside it runs the solver of each case that declares most alike. See `Case.with_solver`.

        Raises
        ------
        UsageError
            If no case can show what it declares.
        """
        cases, reasons = [], []
        for case in self.cases:
            try:
                cases.append(case.with_solver(solver))
            except UsageError as error:
                reasons.append(error)
        if not cases:
            raise reasons[0]
        name, title = f"{self.name}-with-{solver.name}", f"{self.title}: {solver.name}"
        return dataclasses.replace(self, name=name, title=title, cases=tuple(cases))

    def solvers(self) -> dict[str, Solver]:
        """Return the solvers by name, in the order of declaration."""
        return {series.solver.name: series.solver for _, series in self.series()}

    def restricted(self, solvers: tuple[str, ...] = (), courant: float | None = None) -> "Study":
        """Return the study with only the named solvers, or all if none is named, and with one Courant number [1] if it is given.

        `restricted_to` of the returned study states the restriction.
        """
        cases = []
        for case in self.cases:
            chosen: dict[tuple[str, str], Series] = {}
            for series in case.series:
                if solvers and series.solver.name not in solvers:
                    continue
                if courant is not None:
                    series = dataclasses.replace(series, refinement=series.refinement.with_courant(courant))
                chosen.setdefault((series.solver.name, series.refinement.label), series)
            if chosen:
                cases.append(dataclasses.replace(case, series=tuple(chosen.values())))
        kept = dataclasses.replace(self, cases=tuple(cases))
        parts = [", ".join(kept.solvers())] * (kept.solvers() != self.solvers())
        parts += [] if courant is None else [f"Courant number {courant:g}"]
        return dataclasses.replace(kept, restricted_to="; ".join(parts) or self.restricted_to)

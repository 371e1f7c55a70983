"""Measurement of the stability limit of a solver, by bisection of the Courant number."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace

from mpmverify.problem import Discretisation, Problem
from mpmverify.solution import Outcome, Solution, Solver, Status

GROWTH = 100.0
"""A run is unstable if its final energy exceeds this multiple of its initial energy."""
HALVINGS = 10
"""Number of times that the Courant number is halved in search of a stable run."""
UNSTABLE = (Status.UNSTABLE, Status.NON_FINITE)


@dataclass(frozen=True)
class Bisection:
    """A solver that runs another one at the largest Courant number, up to that of the level, at which its energy does not grow.

    The problem must have no external work, and its initial data must contain every mode of the grid. The solution is the stable run
    with the largest Courant number, and its `dt` is the measured limit. If no run is stable, the solution is the last unstable run; if
    a run ends in another way, for example by a crash, the solution is that run.

    Parameters
    ----------
    solver : Solver
        Solver whose limit is measured.
    resolution : float
        Relative difference at which the bisection between a stable and an unstable Courant number stops.
    """

    solver: Solver
    resolution: float = 1e-3

    @property
    def name(self) -> str:
        return f"limit-{self.solver.name}"

    @property
    def orders(self) -> Mapping[str, float]:
        """Empty: the levels do not converge."""
        return {}

    @property
    def conserves(self) -> frozenset[str]:
        return self.solver.conserves

    def kernel(self, problem: Problem) -> Hashable:
        """Return the `kernel` of the solver, or None if it has none."""
        kernel = getattr(self.solver, "kernel", None)
        return kernel(problem) if callable(kernel) else None

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Halve the Courant number until a run is stable, then bisect between it and the unstable one above."""

        def solved(courant: float) -> Solution:
            return self.solver.solve(problem, replace(discretisation, courant=courant))

        above = discretisation.courant
        found = solved(above)
        if not grows(found):
            return found
        for _ in range(HALVINGS):
            found, below = solved(above / 2), above / 2
            if not grows(found):
                break
            above = below
        else:
            return replace(found, outcome=Outcome(Status.UNSTABLE, f"still unstable at nu_C = {above:.3g}"))
        while found.outcome.completed and above > (1 + self.resolution) * below:
            middle = (below + above) / 2
            tried = solved(middle)
            if grows(tried):
                above = middle
            else:
                found, below = tried, middle
        return found


def grows(solution: Solution) -> bool:
    """Whether a run is unstable, by its status or by its energy; an energy of NaN counts as growth."""
    if solution.outcome.status in UNSTABLE:
        return True
    parts = [solution.histories[name] for name in ("kinetic_energy", "strain_energy") if name in solution.histories]
    return bool(parts) and not sum(part[-1] for part in parts) <= GROWTH * sum(part[0] for part in parts)

"""The limit of stability of any solver, measured: a solver that searches for its own largest time step."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace

from mpmverify.problem import Discretisation, Problem
from mpmverify.solution import Outcome, Solution, Solver, Status

GROWTH = 100.0
"""A run has grown when it holds so many times the energy that it began with."""
HALVINGS = 10
"""Courant numbers below that of the level at which a stable run is looked for."""
UNSTABLE = (Status.UNSTABLE, Status.NON_FINITE)


@dataclass(frozen=True)
class Bisection:
    """A solver at the largest Courant number, up to that of the level, at which its energy does not grow.

    For a problem without external work whose initial data hold every mode of the grid. What it returns is the last stable run, of
    which `dt` is the limit; a run that grows where none is stable, or that ends in any other way.

    Parameters
    ----------
    solver : Solver
    resolution : float
        Relative distance between the last stable and the first unstable Courant number.
    """

    solver: Solver
    resolution: float = 1e-3

    @property
    def name(self) -> str:
        return f"limit-{self.solver.name}"

    @property
    def orders(self) -> Mapping[str, float]:
        """None: the levels do not converge."""
        return {}

    @property
    def conserves(self) -> frozenset[str]:
        return self.solver.conserves

    def kernel(self, problem: Problem) -> Hashable:
        """What its solver compiles."""
        says = getattr(self.solver, "kernel", None)
        return says(problem) if callable(says) else None

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve at half the Courant number until that is stable, then between stable and unstable ones."""

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
            return replace(found, outcome=Outcome(Status.UNSTABLE, f"it grows at nu_C = {above:.3g} still"))
        while found.outcome.completed and above > (1 + self.resolution) * below:
            middle = (below + above) / 2
            tried = solved(middle)
            if grows(tried):
                above = middle
            else:
                found, below = tried, middle
        return found


def grows(solution: Solution) -> bool:
    """Whether a run is unstable, by its own word or by its energy, which NaN never keeps."""
    if solution.outcome.status in UNSTABLE:
        return True
    parts = [solution.histories[name] for name in ("kinetic_energy", "strain_energy") if name in solution.histories]
    return bool(parts) and not sum(part[-1] for part in parts) <= GROWTH * sum(part[0] for part in parts)

"""Numerical references: a numerical solution may replace the exact one only if it converges on its own refinement ladder."""

import math
from dataclasses import dataclass

from mpmverify.convergence.gci import Behaviour, GridConvergence, grid_convergence, grid_convergence_of_differences
from mpmverify.convergence.levels import Numbers, levels
from mpmverify.convergence.series import FLAT
from mpmverify.errors import UsageError


@dataclass(frozen=True)
class Reference:
    """The finest level of a numerical solution, as a replacement for the exact solution.

    Parameters
    ----------
    convergence : GridConvergence
        Grid convergence on the ladder of the reference.
    size : float
        Scale of the relative uncertainty, in the unit of the quantity.
    """

    convergence: GridConvergence
    size: float

    @property
    def qualified(self) -> bool:
        """Whether the three finest levels converge monotonically, at a finite order above `FLAT`, and the size is not zero."""
        return FLAT < self.convergence.order < math.inf and self.size > 0

    @property
    def uncertainty(self) -> float:
        """Relative uncertainty [1]; infinite if the reference is not qualified, so that no error can be judged against it."""
        return self.convergence.uncertainty / self.size if self.qualified else math.inf

    @property
    def reason(self) -> str:
        """Why it is qualified or not, in one sentence."""
        found = self.convergence
        if self.qualified:
            return (
                f"qualified: it converges at order {found.order:.2f}, with a relative uncertainty of {self.uncertainty:.1e} "
                f"(factor of safety {found.factor:g})"
            )
        if not self.size > 0:
            return f"not qualified: a size of {self.size:g} has no relative uncertainty"
        if found.behaviour is Behaviour.MONOTONE:
            return f"not qualified: order {found.order:.2f} does not show convergence"
        return f"not qualified: its finest levels are {found.behaviour}" + (
            "; three are needed" if found.behaviour is Behaviour.TOO_SHORT else ""
        )


def qualify(h: Numbers, value: Numbers | None = None, *, formal: float) -> Reference:
    """Qualify a reference by a scalar quantity on its own ladder; the uncertainty is relative to the finest value.

    Parameters
    ----------
    h, value, formal
        As in `grid_convergence`.

    Raises
    ------
    UsageError
        As in `grid_convergence`.
    """
    h, value = levels(h, value)
    return Reference(grid_convergence(h, value, formal=formal), abs(float(value[-1])))


def qualify_by_differences(h: Numbers, difference: Numbers, *, formal: float, size: float) -> Reference:
    """Qualify a reference by the differences of its solutions on neighbouring levels.

    Parameters
    ----------
    h, difference, formal
        As in `grid_convergence_of_differences`.
    size : float
        Norm of the finest solution: the same norm as that of the differences.

    Raises
    ------
    UsageError
        If the size is negative or not finite, and as in `grid_convergence_of_differences`.
    """
    if not (math.isfinite(size) and size >= 0):
        raise UsageError(f"the norm of the finest solution must be finite and not negative, not {size:g}")
    return Reference(grid_convergence_of_differences(h, difference, formal=formal), float(size))

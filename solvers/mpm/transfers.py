"""Transfers of velocity between particles and grid, as values."""

from dataclasses import dataclass

from mpmverify.errors import UsageError

from .passes import APIC as WITH_MOMENT
from .passes import NO_AFFINE
from .passes import TPIC as WITH_GRADIENT


@dataclass(frozen=True)
class Transfer:
    """How the velocity of the grid becomes that of the particles.

    Parameters
    ----------
    name : str
    flip : float
        Share of the increment of velocity (FLIP), the rest is the velocity itself (PIC) [1].
    affine : int
        What of the velocity's variation about a particle it keeps: nothing, its moment or its gradient.

    Raises
    ------
    UsageError
        If the share of FLIP is not between 0 and 1.
    """

    name: str
    flip: float
    affine: int = NO_AFFINE

    def __post_init__(self) -> None:
        if not 0 <= self.flip <= 1:
            raise UsageError(f"the share of FLIP lies between 0 (PIC) and 1 (FLIP), not {self.flip!r}")


FLIP = Transfer("flip", 1.0)
PIC = Transfer("pic", 0.0)
APIC = Transfer("apic", 0.0, WITH_MOMENT)
TPIC = Transfer("tpic", 0.0, WITH_GRADIENT)


def blend(flip: float) -> Transfer:
    """FLIP and PIC in shares.

    Parameters
    ----------
    flip : float
        Share of FLIP [1].

    Raises
    ------
    UsageError
        If the share is not between 0 and 1.
    """
    return Transfer(f"blend{100 * flip:.12g}", float(flip))

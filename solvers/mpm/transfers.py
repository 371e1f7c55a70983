"""Transfers of velocity between particles and grid: a value for each, and the table of those without a parameter.

To add a transfer that is a new choice of parameters, make a `Transfer` and enter it in `TRANSFERS`. New arithmetic goes into `affine`,
for what particles keep of the variation of velocity about them, or into `passes`.
"""

from dataclasses import dataclass

from mpmverify.errors import UsageError

from .affine import AFFINE


@dataclass(frozen=True)
class Transfer:
    """Transfer of velocity from the grid to the particles and back.

    Parameters
    ----------
    name : str
    flip : float
        Share of the particle's own velocity and its increment (FLIP); the rest is the velocity of the grid (PIC) [1].
    affine : {None, "moment", "gradient"}
        What particles keep of the variation of velocity about them, see `affine`.
    terms : int
        k of the series sum_{j < k} (I - S^+ S)^j that undoes the smoothing of PIC; S maps nodes to particles, and S^+ back.
    full_mass : bool
        Whether the series replaces velocity and acceleration of the nodes (FMPM), or its correction goes to the particles (XPIC).

    Raises
    ------
    UsageError
        If the share of FLIP is not between 0 and 1, the affine part does not exist, or the series has no term.
    """

    name: str
    flip: float
    affine: str | None = None
    terms: int = 1
    full_mass: bool = False

    def __post_init__(self) -> None:
        if not 0 <= self.flip <= 1:
            raise UsageError(f"the share of FLIP lies between 0 (PIC) and 1 (FLIP), not {self.flip!r}")
        if self.affine not in AFFINE:
            raise UsageError(f"the affine part of a transfer is one of {', '.join(map(repr, AFFINE))}, not {self.affine!r}")
        if not (isinstance(self.terms, int) and self.terms >= 1):
            raise UsageError(f"a series of XPIC or FMPM has one term or more, not {self.terms!r}")


FLIP = Transfer("flip", 1.0)
PIC = Transfer("pic", 0.0)
APIC = Transfer("apic", 0.0, affine="moment")
TPIC = Transfer("tpic", 0.0, affine="gradient")
AFLIP = Transfer("aflip", 1.0, affine="moment")
"""FLIP with the affine part of APIC: v_p += dt sum_I N_Ip a_I and B_p = sum_I v_I N_Ip (x_I - x_p)^T.

It conserves linear momentum, but not angular momentum: that changes as the affine parts do when v_I of the old velocities is projected
back on the particles, and since particles move by sum_I v_I N_Ip and not by v_p. It damps less than APIC. Fei and others, 2021,
doi:10.1145/3450626.3459678, without their separation, and with all of the increment, where they take 0.99 of it.
"""
TRANSFERS = (FLIP, PIC, APIC, TPIC, AFLIP)
"""Transfers without a parameter; `blend`, `xpic` and `fmpm` make others."""


def blend(flip: float) -> Transfer:
    """Blend of FLIP and PIC.

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


def xpic(order: int) -> Transfer:
    """Extended PIC of order m, XPIC(m); XPIC(1) is PIC.

    v_p = sum_I N_Ip (sum_{j < m} (I - S^+ S)^j v + dt a)_I, which smooths at order m in h^2.

    Parameters
    ----------
    order : int
        m.

    Raises
    ------
    UsageError
        If it is not positive.

    References
    ----------
    Hammerquist and Nairn, 2017, doi:10.1016/j.cma.2017.01.035.
    """
    return Transfer(f"xpic{order}", 0.0, terms=order)


def fmpm(order: int) -> Transfer:
    """Full-mass MPM of order k, FMPM(k); FMPM(1) is PIC.

    The velocity of the grid is sum_{j < k} (I - S^+ S)^j (v + dt a), which converges to that of the full mass matrix; particles take
    their velocity, motion and strain from it.

    Parameters
    ----------
    order : int
        k.

    Raises
    ------
    UsageError
        If it is not positive.

    References
    ----------
    Nairn and Hammerquist, 2021, doi:10.1016/j.cma.2021.113667.
    """
    return Transfer(f"fmpm{order}", 0.0, terms=order, full_mass=True)

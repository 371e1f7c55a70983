"""Orders of the material point method in h while no particle crosses a cell, by basis and transfer."""

from collections.abc import Mapping

from .basis import Basis
from .splines import MovingLeastSquares
from .transfers import Transfer


def orders(basis: Basis, transfer: Transfer) -> Mapping[str, float]:
    """Return the formal order in h of each quantity.

    - PIC damps at first order. Affine transfers, and XPIC and FMPM with two terms, damp at second order.
    - The gradient of the hat is constant in a cell, so that it is of second order in the middle of the cell only (`ppc` = 1).
    - The centre of the lumped mass of the end functions is O(h) from their nodes: of the hat at a moved or loaded end, of the two
      quadratic functions at every clamped end. This costs half an order in L2 of the stress of splines, and of the velocity where
      FLIP adds the acceleration to it.
    - In the end cells of clamped cubic splines the quadrature over particles does not balance a constant stress, and with moving
      least squares neither does the gradient: a strain error of O(1) over a length O(h) leaves half an order of the stress, and of the
      velocity where FLIP adds the acceleration, and first order of displacement, which with cubic splines shows on fine levels only.
    - The force of a hat changes where the stretched domain of a particle leaves a cell, an error of first order in velocity and stress.
    """
    if isinstance(basis.kind, MovingLeastSquares) or basis.degree > 2:
        return {"displacement": 1.0, "velocity": 0.5, "stress": 0.5}
    if _damped(transfer) or basis.stretched:
        return {"displacement": 1.0 if _damped(transfer) else 2.0, "velocity": 1.0, "stress": 1.0}
    return {"displacement": 2.0, "velocity": 2.0 if transfer.affine else 1.5, "stress": 1.5 if basis.degree > 1 else 1.0}


def coarse_orders(basis: Basis, transfer: Transfer) -> Mapping[str, float]:
    """Return the order of each quantity on coarse levels, from which the measured order comes to the formal one.

    - Errors of second order dominate until those of the end cells, of the gradient off the middle of a cell and of a share of PIC show.
    - PIC multiplies a mode by exp(-a h), with an error 1 - exp(-a h) whose order x/(exp(x) - 1), x = a h, is 1/2 at an error of 0.7.
    """
    return dict.fromkeys(("displacement", "velocity", "stress"), 0.5 if _damped(transfer) and transfer.flip == 0 else 2.0)


def _damped(transfer: Transfer) -> bool:
    return transfer.flip < 1 and not transfer.affine and transfer.terms == 1

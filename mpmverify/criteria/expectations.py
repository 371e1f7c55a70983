"""Criteria derived from the declarations of a solver and from the smoothness of the exact solution."""

import math
from collections.abc import Mapping, Set
from numbers import Real

import numpy as np

from mpmverify.convergence import ROUND_OFF
from mpmverify.criteria import Balance, EnergyDrift, Order
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.errors import LARGEST_ROUND_OFF
from mpmverify.errors import UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.problem import UNITS, Inflow, Outflow, Transport
from mpmverify.solution import Solver

MARGIN = 0.15
"""Accepted difference between the observed and the formal order on smooth data, unless the case knows another."""
INVARIANTS = ("mass", "momentum", "energy")
"""Quantities that a solver may declare to conserve: the first two to round-off, energy at the order of the scheme."""
LAYERS = 0.5
"""How far the order of the energy drift may lie below that of the scheme: layers of width h at ends and surfaces take half an order."""
FALLS = 0.25
"""Least order of the energy drift, however low the order of the scheme on the data."""
THEORY = (
    "a scheme of order p on data with s derivatives in L1 has at most the order s p/(p+1) in L1, and at least its order in L2, "
    "(s-1/2) p/(p+1): Brenner, Thomee and Wahlbin (1975), doi:10.1007/BFb0068125"
)


def order_band(order: float, derivatives: float, margin: float = MARGIN) -> tuple[float, float]:
    """Accepted band of the observed order of a scheme: in L2 on smooth data, in L1 if `derivatives` is finite.

    Parameters
    ----------
    order : float
        Formal order p on smooth data.
    derivatives : float
        Number s of derivatives that the exact field has in L1; infinite on smooth data.
    margin : float
        Accepted difference m between the observed order and that of theory.

    Returns
    -------
    (float, float)
        p - m and p + m on smooth data. On other data the upper edge is at most s p/(p+1) + m, where s p/(p+1) is the order of
        a front smeared over h^(p/(p+1)). The lower edge is at most (s - 1/2) p/(p+1), the order in L2, which is a lower bound of the
        order in L1.

    Notes
    -----
    For a discontinuous solution the bands of all orders overlap, so a high order can be verified on smooth data only.

    References
    ----------
    Brenner P., Thomee V., Wahlbin L. B. (1975). Besov Spaces and Applications to Difference Methods for Initial Value Problems.
    Springer, doi:10.1007/BFb0068125
    """
    gain = order / (order + 1)
    return min(order - margin, (derivatives - 0.5) * gain), min(order, derivatives * gain) + margin


def expectations(solver: Solver, problem: VerificationProblem, norm: str, margin: float = MARGIN) -> tuple[Criterion, ...]:
    """Criteria that follow from the declared orders and invariants of a solver.

    Parameters
    ----------
    solver : Solver
    problem : VerificationProblem
        Its exact solution determines the smoothness of the fields.
    norm : str
        Norm in which the orders are judged, as the `Case` of the problem knows it.
    margin : float
        Accepted difference between the observed and the formal order on smooth data, as the case knows it.

    Returns
    -------
    tuple of Criterion
        An `Order` for every declared quantity that the exact solution has, a `Balance` for declared mass and momentum, and an
        `EnergyDrift` for the declared energy of a body.

    Raises
    ------
    UsageError
        If a declared order or invariant is invalid, or no order of a quantity of the exact solution is declared.
    """
    if not isinstance(solver.orders, Mapping):
        raise UsageError(
            f"solver {solver.name!r} declares its orders as {solver.orders!r}: give a mapping of quantity to order"
        )
    if not isinstance(solver.conserves, Set):
        raise UsageError(f"solver {solver.name!r} declares that it conserves {solver.conserves!r}: give a set of names")
    coarse, round_off = getattr(solver, "coarse_orders", {}), getattr(solver, "round_off", ROUND_OFF)
    if not isinstance(coarse, Mapping):
        raise UsageError(
            f"solver {solver.name!r} declares its coarse orders as {coarse!r}: give a mapping of quantity to order"
        )
    for quantity, order in (*solver.orders.items(), *coarse.items()):
        if quantity not in UNITS:
            raise UsageError(
                f"solver {solver.name!r} declares the order of the unknown quantity {quantity!r}: choose from {', '.join(UNITS)}"
            )
        if not isinstance(order, Real) or isinstance(order, bool | np.bool_) or not (math.isfinite(order) and float(order) > 0):
            raise UsageError(
                f"solver {solver.name!r} declares the order {order!r} of {quantity}: an order must be positive and finite"
            )
    if unknown := sorted(set(solver.conserves) - set(INVARIANTS), key=str):
        raise UsageError(
            f"solver {solver.name!r} declares that it conserves the unknown {unknown[0]!r}: choose from {', '.join(INVARIANTS)}"
        )
    if not isinstance(round_off, Real) or not 0 <= float(round_off) <= LARGEST_ROUND_OFF:
        raise UsageError(
            f"solver {solver.name!r} declares the round-off {round_off!r}: it must be a relative error up to {LARGEST_ROUND_OFF:g}"
        )
    declared = {
        quantity: sorted((order, coarse.get(quantity, order)))
        for quantity, order in solver.orders.items()
        if quantity in problem.exact.fields
    }
    if not declared:
        raise UsageError(
            f"solver {solver.name!r} declares no order of {' or '.join(problem.exact.fields)}, the fields of the problem "
            f"{problem.problem.name!r}: declare an order, or give criteria"
        )
    return (
        *(_order(quantity, low, high, problem, norm, margin, float(round_off)) for quantity, (low, high) in declared.items()),
        *(
            Balance(invariant, source, f"declared by {solver.name}", max(Balance.bound, float(round_off)))
            for invariant, source in _sources(problem).items()
            if invariant in solver.conserves
        ),
        *((_energy(declared, problem, float(round_off)),) if "energy" in solver.conserves and _is_body(problem) else ()),
    )


def _is_body(problem: VerificationProblem) -> bool:
    return not isinstance(problem.problem.material, Transport)


def _energy(declared: Mapping[str, list[float]], problem: VerificationProblem, round_off: float) -> EnergyDrift:
    """Return the criterion on the energy: its drift falls at the order of the motion, less `LAYERS`."""
    moving = [least for quantity, (least, _) in declared.items() if quantity in ("displacement", "velocity")]
    order = min(moving or [least for least, _ in declared.values()])
    low = max(FALLS, round(min(order, order_band(order, problem.exact.derivatives)[0]) - LAYERS, 3))
    source = f"the solver declares that it conserves energy, and order {order:g}; layers at ends and surfaces take up to half an order"
    return EnergyDrift(low, source, max(EnergyDrift.round_off, round_off))


def _order(
    quantity: str, least: float, most: float, problem: VerificationProblem, norm: str, margin: float, round_off: float
) -> Order:
    derivatives = _derivatives(quantity, problem)
    low, high = round(order_band(least, derivatives, margin)[0], 3), round(order_band(most, derivatives, margin)[1], 3)
    order = f"order {least:g}" if least == most else f"an order from {least:g} to {most:g}"
    declared = f"the solver declares {order} of {quantity} on smooth data"
    if math.isinf(derivatives):
        better = "where it is better than that on this problem, give criteria"
        return Order(quantity, norm, low, high, f"{declared}; {better}", round_off)
    return Order(quantity, norm, low, high, f"{declared}; here s = {derivatives:g}; {THEORY}", round_off)


def _derivatives(quantity: str, problem: VerificationProblem) -> float:
    """Number of derivatives in L1 of one field; the displacement is an integral and has one more than velocity and stress."""
    integrated = quantity == "displacement" and problem.exact.fields.keys() & {"velocity", "stress"}
    return problem.exact.derivatives + (1 if integrated else 0)


def _sources(problem: VerificationProblem) -> dict[str, str]:
    """Invariants of a problem, each with the history that accounts for its change; "" if it must stay constant."""
    stated = problem.problem
    if isinstance(stated.material, Transport):
        open_ended = any(isinstance(condition, Inflow | Outflow) for condition in stated.boundary.values())
        return {"mass": "inflow" if open_ended else ""}
    return {"mass": "", "momentum": "impulse"}

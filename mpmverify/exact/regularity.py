"""What order a scheme can have where the solution is not smooth."""

import math

LOST = {"L1": 0.0, "L2": 0.5, "Linf": 1.0}
"""Derivatives that a piecewise smooth function with s derivatives in L1 has less in L2 and in the maximum norm."""


def expected_order(formal: float, derivatives: float, norm: str) -> float:
    """Order of the error at a fixed time, with dt proportional to h, of a linear scheme for a hyperbolic problem.

    Parameters
    ----------
    formal : float
        Order p on smooth data.
    derivatives : float
        Derivatives s of the solution in L1: 1 for a jump, 2 for a kink, infinite when it is smooth.
    norm : {"L1", "L2", "Linf"}

    Returns
    -------
    float
        min(p, s p/(p + 1)) with the derivatives that are left in the norm.

    Notes
    -----
    The theorem is sharp in L2, for dissipative schemes and others. In L1 it bounds what a scheme of even order can reach: its
    oscillations spread, and the more singular the solution, the less of the bound is seen; for a jump and p = 2 it is 2/3, where
    damped oscillations leave 5/8 and undamped ones 1/2. Schemes of first order reach it in every norm.

    References
    ----------
    P. Brenner, V. Thomée and L. B. Wahlbin, Besov Spaces and Applications to Difference Methods for Initial Value Problems,
    Lecture Notes in Mathematics 434, Springer 1975, https://doi.org/10.1007/BFb0068125. G. W. Hedstrom, Models of difference
    schemes for u_t + u_x = 0 by partial differential equations, Mathematics of Computation 29 (1975) 969-977.
    """
    left = derivatives - LOST[norm]
    return formal if math.isinf(left) else min(formal, left * formal / (formal + 1))

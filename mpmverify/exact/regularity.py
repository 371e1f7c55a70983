"""Convergence order that the regularity of the solution allows."""

import math

LOST_DERIVATIVES = {"L1": 0.0, "L2": 0.5, "Linf": 1.0}
"""By norm: a piecewise smooth function with s derivatives in L1 has s minus this many derivatives in the norm."""


def expected_order(formal: float, derivatives: float, norm: str) -> float:
    """Return the order of the error at a fixed time of a linear scheme for a hyperbolic problem, with dt proportional to h.

    Parameters
    ----------
    formal : float
        Order p on smooth data.
    derivatives : float
        Number s of derivatives of the solution in L1: 1 for a jump, 2 for a kink, infinite if it is smooth.
    norm : {"L1", "L2", "Linf"}

    Returns
    -------
    float
        min(p, s' p/(p + 1)) with the number s' of derivatives in the norm: s in L1, s - 1/2 in L2, s - 1 in Linf.

    Notes
    -----
    The theorem is sharp in L2, for dissipative and for non-dissipative schemes. In L1 it is an upper bound for schemes of even order,
    because their oscillations spread. The more singular the solution, the farther the observed order stays below the bound: for a
    jump and p = 2 the bound is 2/3; damped oscillations give 5/8, undamped ones 1/2. First-order schemes attain it in every norm.

    References
    ----------
    P. Brenner, V. Thomée and L. B. Wahlbin, Besov Spaces and Applications to Difference Methods for Initial Value Problems,
    Lecture Notes in Mathematics 434, Springer 1975, https://doi.org/10.1007/BFb0068125. G. W. Hedstrom, Models of difference
    schemes for u_t + u_x = 0 by partial differential equations, Mathematics of Computation 29 (1975) 969-977.
    """
    remaining = derivatives - LOST_DERIVATIVES[norm]
    return formal if math.isinf(remaining) else min(formal, remaining * formal / (formal + 1))

"""Amplification factors: the complex number by which one step of a scheme multiplies a Fourier mode."""

import numpy as np
from numpy.typing import NDArray

from mpmverify.problem import Array


def two_step_taylor_galerkin(theta: Array, courant: float, passes: int) -> NDArray[np.complex128]:
    """Amplification factor of two-step Taylor-Galerkin on a uniform periodic mesh.

    Parameters
    ----------
    theta : Array
        Phase angles k h (n,) [rad].
    courant : float
        Signed Courant number nu_C = a dt/h.
    passes : int
        Passes k of the mass iteration; 1 is the lumped mass.

    Returns
    -------
    Array of complex
        G = 1 - [i nu_C sin(theta) + nu_C^2 (1 - cos(theta))] r (n,). The consistent mass has the symbol
        m = 1 - (1 - cos(theta))/3; k passes approximate its inverse by r = [1 - (1 - m)^k]/m.

    References
    ----------
    Donea J. (1984). A Taylor-Galerkin method for convective transport problems. International Journal for Numerical Methods in
    Engineering 20(1), 101-119, https://doi.org/10.1002/nme.1620200108
    """
    m = 1 - (1 - np.cos(theta)) / 3
    inverse_mass = (1 - (1 - m) ** passes) / m
    return np.asarray(1 - (1j * courant * np.sin(theta) + courant**2 * (1 - np.cos(theta))) * inverse_mass)

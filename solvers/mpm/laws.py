"""Constitutive laws of a material point in one dimension."""

from math import log

from numba import njit

from mpmverify.problem import LinearElastic, NeoHookean

jit = njit(fastmath={"contract"}, error_model="numpy")

LINEAR_ELASTIC, NEO_HOOKEAN = 0, 1
LAWS = {LinearElastic: LINEAR_ELASTIC, NeoHookean: NEO_HOOKEAN}


@jit
def stress(law: int, lame: float, shear: float, sigma: float, increment: float, F: float) -> float:
    """Stress after a strain increment [Pa].

    Parameters
    ----------
    law : int
        `LINEAR_ELASTIC` or `NEO_HOOKEAN`.
    lame, shear : float
        lambda and mu [Pa].
    sigma : float
        Stress before the increment [Pa].
    increment : float
        Strain increment [1].
    F : float
        Deformation gradient after the increment [1].

    Notes
    -----
    Linear elastic sigma + (lambda + 2 mu) d_eps; neo-Hookean lambda ln(F)/F + mu (F - 1/F). In one dimension the Cauchy and the
    first Piola-Kirchhoff stress coincide.

    References
    ----------
    de Vaucorbeil, Nguyen and Hutchinson, 2020, doi:10.1016/j.cma.2019.112783.
    """
    if law == LINEAR_ELASTIC:
        return sigma + (lame + 2 * shear) * increment
    return lame * log(F) / F + shear * (F - 1 / F)


@jit
def strain_energy(law: int, lame: float, shear: float, sigma: float, volume: float, F: float) -> float:
    """Strain energy of a particle per unit cross-section [J/m^2].

    Parameters
    ----------
    law, lame, shear, F
        As for `stress`.
    sigma : float
        Stress [Pa].
    volume : float
        The volume that the stress acts on: V for the linear elastic body, V0 for the neo-Hookean one [m].

    Notes
    -----
    Linear elastic V sigma^2/(2 (lambda + 2 mu)); neo-Hookean V0 [lambda ln(F)^2/2 + mu (F^2 - 1)/2 - mu ln(F)].
    """
    if law == LINEAR_ELASTIC:
        return volume * sigma * sigma / (2 * (lame + 2 * shear))
    return volume * (0.5 * lame * log(F) ** 2 + 0.5 * shear * (F * F - 1) - shear * log(F))

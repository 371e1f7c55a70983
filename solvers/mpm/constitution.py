"""Constitutive laws of a material point in one, two and three dimensions.

A body in one dimension is in uniaxial strain (at nu = 0 a slender bar), in two in plane strain unless it is `PlaneStress`. The
stress out of the plane is not stored: it does no work, and the energies account for the stretches F_zz = 1 that go with it.
Tensors are tuples, see `mpmverify.solvers.mpm.tensors`.
"""

from math import exp, expm1, log, nan
from typing import NamedTuple

from mpmverify.material import (
    Hencky,
    KelvinVoigt,
    LinearElastic,
    Maxwell,
    NeoHookean,
    NeoHookeanSplit,
    PlaneStress,
    SaintVenantKirchhoff,
)

from .compilation import jit
from .tensors import (
    Symmetric,
    Tensor,
    combined,
    ddot,
    det,
    dimension,
    first_piola_kirchhoff,
    full,
    left_cauchy_green,
    logarithm,
    shifted,
    squared,
    sym,
    trace,
)
from .tracing import traced
from .values import equal, where

LINEAR_ELASTIC, KELVIN_VOIGT, MAXWELL, NEO_HOOKEAN, NEO_HOOKEAN_SPLIT, HENCKY, SAINT_VENANT_KIRCHHOFF = range(7)
Law = tuple[int, ...]
"""Number of a law, twice unless it is linear elasticity, for which the others are dropped where a function is compiled."""
LAWS = {
    LinearElastic: LINEAR_ELASTIC,
    PlaneStress: LINEAR_ELASTIC,
    KelvinVoigt: KELVIN_VOIGT,
    Maxwell: MAXWELL,
    NeoHookean: NEO_HOOKEAN,
    NeoHookeanSplit: NEO_HOOKEAN_SPLIT,
    Hencky: HENCKY,
    SaintVenantKirchhoff: SAINT_VENANT_KIRCHHOFF,
}
"""Plane stress is linear elasticity with its own lambda, and for a solver in three dimensions to refuse."""


class Constants(NamedTuple):
    """Lambda and mu [Pa], and the time of a viscous law [s]: of relaxation, or of retardation eta/(lambda + 2 mu)."""

    lame: float
    shear: float
    time: float


def constitution(material: LinearElastic) -> tuple[Law, Constants]:
    """Law of a material and its constants."""
    time = 0.0
    if isinstance(material, KelvinVoigt):
        time = material.retardation_time
    elif isinstance(material, Maxwell):
        time = material.relaxation_time
    number = LAWS[type(material)]
    law = (number,) if number == LINEAR_ELASTIC else (number, number)
    return law, Constants(float(material.lame_lambda), float(material.shear_modulus), float(time))


@jit
def stress(law: Law, constants: Constants, sigma: Symmetric, F: Tensor, increment: Tensor, dt: float) -> Symmetric:
    """Cauchy stress after a step [Pa]; all NaN when a law of finite strain meets J <= 0.

    Parameters
    ----------
    law : tuple of int
        As of `constitution`.
    constants : Constants
        Of the law.
    sigma : tuple of float
        Stress before the step [Pa].
    F : tuple of float
        Deformation gradient after the step [1].
    increment : tuple of float
        dt dv/dx or, in the total Lagrangian formulation, dt dv/dX [1]; strain is its symmetric part.
    dt : float
        Time step, positive [s].

    Notes
    -----
    The laws at small strain go by the increment, but Kelvin-Voigt by the strain sym(F) - I: its stress holds a viscous part that
    is not to be carried on. They do not see J, and are not objective.
    """
    if len(law) == 1:
        return linear_elastic(constants.lame, constants.shear, sigma, sym(increment))
    if law[0] == KELVIN_VOIGT:
        return kelvin_voigt(constants, shifted(-1.0, 1.0, sym(F)), sym(increment), dt)
    if law[0] == MAXWELL:
        return maxwell(constants, sigma, sym(increment), dt)
    return hyperelastic(law[0], constants.lame, constants.shear, F)


@jit
def strain_energy(law: Law, constants: Constants, sigma: Symmetric, F: Tensor) -> float:
    """Stored energy [J/m^3] per volume that the stress acts on at small strain, per reference volume at finite strain.

    Notes
    -----
    sigma : C^-1 : sigma / 2 at small strain, of Kelvin-Voigt the elastic part alone, from sym(F) - I.
    """
    lame, shear = constants.lame, constants.shear
    if len(law) == 1:
        return elastic_energy(lame, shear, sigma)
    if law[0] == MAXWELL:
        return elastic_energy(lame, shear, sigma)
    if law[0] == KELVIN_VOIGT:
        eps = shifted(-1.0, 1.0, sym(F))
        return 0.5 * ddot(hooke(lame, shear, eps), eps)
    return energy(law[0], lame, shear, F)


@jit
def dissipation(law: Law, constants: Constants, sigma: Symmetric, increment: Tensor, dt: float) -> float:
    """Energy that a step turns into heat, per volume that the stress acts on [J/m^3]; `sigma` is the stress before it.

    Notes
    -----
    At a constant strain rate during the step: dt sigma_v : eps_dot for Kelvin-Voigt, and the exact integral of
    sigma : C^-1 : sigma / tau for Maxwell, as work less the change of the stored energy.
    """
    if len(law) == 1:
        return 0.0
    lame, shear, time = constants
    deps = sym(increment)
    if law[0] == KELVIN_VOIGT:
        return time / dt * ddot(hooke(lame, shear, deps), deps)
    if law[0] == MAXWELL:
        x, elastic = dt / time, hooke(lame, shear, deps)
        share = -expm1(-x) / x
        work = share * ddot(sigma, deps) + (1 - share) / x * ddot(elastic, deps)
        after = maxwell(constants, sigma, deps, dt)
        return work - elastic_energy(lame, shear, after) + elastic_energy(lame, shear, sigma)
    return 0.0


@traced
def reference_stress(law: Law, sigma: Symmetric, F: Tensor) -> Tensor:
    """Stress of the total Lagrangian formulation [Pa]: sigma at small strain, P = J sigma F^-T at finite strain."""
    if len(law) == 1:
        return full(sigma)
    return where(finite_strain(law), first_piola_kirchhoff(sigma, F), full(sigma))


@traced
def finite_strain(law: Law) -> bool:
    """Whether a law is one of finite strain, which is objective and does not bear J <= 0."""
    return law[0] >= NEO_HOOKEAN


@traced
def small_strain(law: Law) -> bool:
    """Whether a law is one of small strain."""
    return law[0] < NEO_HOOKEAN


@traced
def viscous(law: Law) -> bool:
    """Whether a law turns energy into heat."""
    return equal(law[0], KELVIN_VOIGT) | equal(law[0], MAXWELL)


# Small strain.


@traced
def hooke(lame: float, shear: float, eps: Symmetric) -> Symmetric:
    """C : eps = lambda tr(eps) I + 2 mu eps."""
    return shifted(lame * trace(eps), 2 * shear, eps)


@traced
def elastic_energy(lame: float, shear: float, sigma: Symmetric) -> float:
    """Stored [sigma : sigma - lambda tr(sigma)^2/(d lambda + 2 mu)]/(4 mu) = sigma : C^-1 : sigma/2 in d dimensions."""
    share = lame / (dimension(sigma) * lame + 2 * shear)
    return (ddot(sigma, sigma) - share * trace(sigma) * trace(sigma)) / (4 * shear)


@traced
def linear_elastic(lame: float, shear: float, sigma: Symmetric, deps: Symmetric) -> Symmetric:
    """Stress sigma + C : d_eps."""
    return combined(1.0, sigma, 1.0, hooke(lame, shear, deps))


@traced
def kelvin_voigt(constants: Constants, eps: Symmetric, deps: Symmetric, dt: float) -> Symmetric:
    """C : (eps + theta eps_dot), theta = eta/(lambda + 2 mu): in one dimension (lambda + 2 mu) eps + eta eps_dot."""
    return hooke(constants.lame, constants.shear, combined(1.0, eps, constants.time / dt, deps))


@jit
def maxwell(constants: Constants, sigma: Symmetric, deps: Symmetric, dt: float) -> Symmetric:
    """sigma_dot = C : eps_dot - sigma/tau at a constant strain rate: e^-x sigma + (1 - e^-x)/x C : d_eps, x = dt/tau."""
    x = dt / constants.time
    return combined(exp(-x), sigma, -expm1(-x) / x, hooke(constants.lame, constants.shear, deps))


# Finite strain.


@jit
def volume_ratio(F: Tensor) -> float:
    """J = det F, NaN unless it is positive: so is every component of a stress that it divides."""
    J = det(F)
    return J if J > 0 else nan


@jit
def hyperelastic(law: int, lame: float, shear: float, F: Tensor) -> Symmetric:
    """Cauchy stress [Pa] of a hyperelastic law; all NaN when J <= 0.

    Notes
    -----
    ================== ========================================================
    neo-Hookean        J sigma = lambda ln J I + mu (b - I)
    neo-Hookean, split J sigma = K (J^2 - 1)/2 I + mu J^(-2/3) (b - tr(b)/3 I)
    Hencky             J sigma = lambda ln J I + mu ln b
    Saint Venant       S = lambda tr(E) I + 2 mu E, so that
    and Kirchhoff      J sigma = lambda tr(b - I)/2 b + mu b (b - I)
    ================== ========================================================

    References
    ----------
    Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008, chapter 6; Simo and Hughes, Computational
    Inelasticity, 1998, section 9.2 (split).
    """
    J, b = volume_ratio(F), left_cauchy_green(F)
    if law == NEO_HOOKEAN:
        return shifted((lame * log(J) - shear) / J, shear / J, b)
    if law == NEO_HOOKEAN_SPLIT:
        bulk, isochoric = lame + 2 * shear / 3, shear * J ** (-5 / 3)
        return shifted(0.5 * bulk * (J - 1 / J) - isochoric * (trace(b) + 3 - dimension(b)) / 3, isochoric, b)
    if law == HENCKY:
        return shifted(lame * log(J) / J, shear / J, logarithm(b, J))
    return combined((0.5 * lame * (trace(b) - dimension(b)) - shear) / J, b, shear / J, squared(b))


@jit
def energy(law: int, lame: float, shear: float, F: Tensor) -> float:
    """Strain energy per reference volume [J/m^3] of a hyperelastic law; NaN when J <= 0.

    Notes
    -----
    ================== ====================================================================
    neo-Hookean        lambda (ln J)^2/2 - mu ln J + mu (tr b - 3)/2
    neo-Hookean, split K/2 [(J^2 - 1)/2 - ln J] + mu (J^(-2/3) tr b - 3)/2
    Hencky             lambda (ln J)^2/2 + mu ln b : ln b/4
    Saint Venant       lambda (tr E)^2/2 + mu E : E, where tr E = tr(b - I)/2
    and Kirchhoff      and E : E = tr (b - I)^2/4
    ================== ====================================================================
    """
    J, b = det(F), left_cauchy_green(F)
    if not J > 0:
        return nan
    if law == NEO_HOOKEAN:
        return 0.5 * lame * log(J) * log(J) - shear * log(J) + 0.5 * shear * (trace(b) - dimension(b))
    if law == NEO_HOOKEAN_SPLIT:
        bulk = lame + 2 * shear / 3
        return 0.5 * bulk * (0.5 * (J * J - 1) - log(J)) + 0.5 * shear * (J ** (-2 / 3) * (trace(b) + 3 - dimension(b)) - 3)
    if law == HENCKY:
        strain = logarithm(b, J)
        return 0.5 * lame * log(J) * log(J) + 0.25 * shear * ddot(strain, strain)
    doubled = shifted(-1.0, 1.0, b)
    return 0.125 * lame * trace(doubled) * trace(doubled) + 0.25 * shear * ddot(doubled, doubled)

"""Constitutive laws of a material point in one, two and three dimensions.

A body in one dimension is in uniaxial strain (at nu = 0 a slender bar), in two in plane strain unless it is `PlaneStress`. The
stress out of the plane is not stored: it does no work, and the energies account for the stretches F_zz = 1 that go with it.
Tensors are tuples, see `mpmverify.solvers.mpm.tensors`.
"""

from typing import NamedTuple

from mpmverify.problem.material import (
    Hencky,
    KelvinVoigt,
    LinearElastic,
    Maxwell,
    NeoHookean,
    NeoHookeanSplit,
    PlaneStress,
    SaintVenantKirchhoff,
)

from ..tracing import equal, exp, expm1, switch, traced, where
from .hyperelastic import HENCKY, NEO_HOOKEAN, NEO_HOOKEAN_SPLIT, SAINT_VENANT_KIRCHHOFF, energy, hyperelastic
from .tensors import (
    Symmetric,
    Tensor,
    combined,
    ddot,
    dimension,
    first_piola_kirchhoff,
    full,
    shifted,
    sym,
    trace,
)

# What is a number or lanes has no annotation.
# mypy: disable-error-code="no-untyped-def"

LINEAR_ELASTIC, KELVIN_VOIGT, MAXWELL = range(SAINT_VENANT_KIRCHHOFF + 1, SAINT_VENANT_KIRCHHOFF + 4)
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


@traced
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
    deps = sym(increment)
    return switch(
        law[0],
        {
            KELVIN_VOIGT: lambda: kelvin_voigt(constants, shifted(-1.0, 1.0, sym(F)), deps, dt),
            MAXWELL: lambda: maxwell(constants, sigma, deps, dt),
        },
        lambda: hyperelastic(law[0], constants.lame, constants.shear, F),
    )


@traced
def strain_energy(law: Law, constants: Constants, sigma: Symmetric, F: Tensor) -> float:
    """Stored energy [J/m^3] per volume that the stress acts on at small strain, per reference volume at finite strain.

    Notes
    -----
    sigma : C^-1 : sigma / 2 at small strain, of Kelvin-Voigt the elastic part alone, from sym(F) - I.
    """
    lame, shear = constants.lame, constants.shear
    if len(law) == 1:
        return elastic_energy(lame, shear, sigma)

    def kelvin_voigt_energy():
        eps = shifted(-1.0, 1.0, sym(F))
        return 0.5 * ddot(hooke(lame, shear, eps), eps)

    return switch(
        law[0],
        {KELVIN_VOIGT: kelvin_voigt_energy, MAXWELL: lambda: elastic_energy(lame, shear, sigma)},
        lambda: energy(law[0], lame, shear, F),
    )


@traced
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
    elastic = hooke(lame, shear, deps)

    def maxwell_heat():
        x = dt / time
        share = -expm1(-x) / x
        work = share * ddot(sigma, deps) + (1 - share) / x * ddot(elastic, deps)
        after = maxwell(constants, sigma, deps, dt)
        return work - elastic_energy(lame, shear, after) + elastic_energy(lame, shear, sigma)

    return switch(law[0], {KELVIN_VOIGT: lambda: time / dt * ddot(elastic, deps), MAXWELL: maxwell_heat}, 0.0)


@traced
def reference_stress(law: Law, sigma: Symmetric, F: Tensor) -> Tensor:
    """Stress of the total Lagrangian formulation [Pa]: sigma at small strain, P = J sigma F^-T at finite strain."""
    if len(law) == 1:
        return full(sigma)
    return where(finite_strain(law), first_piola_kirchhoff(sigma, F), full(sigma))


@traced
def finite_strain(law: Law) -> bool:
    """Whether a law is one of finite strain, which is objective and does not bear J <= 0."""
    return law[0] <= SAINT_VENANT_KIRCHHOFF


@traced
def small_strain(law: Law) -> bool:
    """Whether a law is one of small strain."""
    return law[0] > SAINT_VENANT_KIRCHHOFF


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


@traced
def maxwell(constants: Constants, sigma: Symmetric, deps: Symmetric, dt: float) -> Symmetric:
    """sigma_dot = C : eps_dot - sigma/tau at a constant strain rate: e^-x sigma + (1 - e^-x)/x C : d_eps, x = dt/tau."""
    x = dt / constants.time
    return combined(exp(-x), sigma, -expm1(-x) / x, hooke(constants.lame, constants.shear, deps))

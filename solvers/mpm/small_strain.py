"""Laws at small strain: Cauchy stress [Pa], stored energy and heat of a step [J/m^3] per volume that the stress acts on.

`lame` and `shear` are lambda and mu [Pa], `sigma` is the stress before the step, F the deformation gradient after it, `deps` the
increment of strain in the time step `dt` [s]. The laws do not see J = det F, and are not objective.
"""

from ..tracing import exp, expm1, traced
from .tensors import Symmetric, Tensor, combined, ddot, dimension, shifted, sym, trace

# Numbers and lanes of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def hooke(lame: float, shear: float, eps: Symmetric) -> Symmetric:
    """C : eps = lambda tr(eps) I + 2 mu eps."""
    return shifted(lame * trace(eps), 2 * shear, eps)


@traced
def strain_of(F: Tensor) -> Symmetric:
    """Strain eps = sym(F) - I."""
    return shifted(-1.0, 1.0, sym(F))


@traced
def linear_elastic(lame: float, shear: float, sigma: Symmetric, F: Tensor, deps: Symmetric, dt: float) -> Symmetric:
    """Stress sigma + C : d_eps."""
    return combined(1.0, sigma, 1.0, hooke(lame, shear, deps))


@traced
def linear_elastic_energy(lame: float, shear: float, sigma: Symmetric, F: Tensor) -> float:
    """Stored sigma : C^-1 : sigma/2."""
    return elastic_energy(lame, shear, sigma)


@traced
def elastic_energy(lame: float, shear: float, sigma: Symmetric) -> float:
    """[sigma : sigma - lambda tr(sigma)^2/(d lambda + 2 mu)]/(4 mu) = sigma : C^-1 : sigma/2 in d dimensions."""
    share = lame / (dimension(sigma) * lame + 2 * shear)
    return (ddot(sigma, sigma) - share * trace(sigma) * trace(sigma)) / (4 * shear)


@traced
def kelvin_voigt(
    lame: float, shear: float, sigma: Symmetric, F: Tensor, deps: Symmetric, dt: float, retardation_time: float
) -> Symmetric:
    """C : (eps + theta eps_dot), eps = sym(F) - I, theta = eta/(lambda + 2 mu): in one dimension (lambda + 2 mu) eps + eta eps_dot.

    It takes the strain and not the stress before the step, whose viscous part is not carried on.
    """
    return hooke(lame, shear, combined(1.0, strain_of(F), retardation_time / dt, deps))


@traced
def kelvin_voigt_energy(lame: float, shear: float, sigma: Symmetric, F: Tensor, retardation_time: float) -> float:
    """Stored eps : C : eps/2, of the elastic part alone."""
    eps = strain_of(F)
    return 0.5 * ddot(hooke(lame, shear, eps), eps)


@traced
def kelvin_voigt_heat(
    lame: float, shear: float, sigma: Symmetric, deps: Symmetric, dt: float, retardation_time: float
) -> float:
    """Heat dt sigma_v : eps_dot of the viscous stress at a constant strain rate."""
    return retardation_time / dt * ddot(hooke(lame, shear, deps), deps)


@traced
def maxwell(
    lame: float, shear: float, sigma: Symmetric, F: Tensor, deps: Symmetric, dt: float, relaxation_time: float
) -> Symmetric:
    """Solution of sigma_dot = C : eps_dot - sigma/tau at a constant strain rate, see `relaxed`."""
    return relaxed(lame, shear, sigma, deps, dt, relaxation_time)


@traced
def relaxed(lame: float, shear: float, sigma: Symmetric, deps: Symmetric, dt: float, relaxation_time: float) -> Symmetric:
    """Stress e^-x sigma + (1 - e^-x)/x C : d_eps of a Maxwell body after a step, x = dt/tau."""
    x = dt / relaxation_time
    return combined(exp(-x), sigma, -expm1(-x) / x, hooke(lame, shear, deps))


@traced
def maxwell_energy(lame: float, shear: float, sigma: Symmetric, F: Tensor, relaxation_time: float) -> float:
    """Stored sigma : C^-1 : sigma/2."""
    return elastic_energy(lame, shear, sigma)


@traced
def maxwell_heat(lame: float, shear: float, sigma: Symmetric, deps: Symmetric, dt: float, relaxation_time: float) -> float:
    """Exact integral of sigma : C^-1 : sigma/tau at a constant strain rate: the work less the change of the stored energy."""
    x = dt / relaxation_time
    share = -expm1(-x) / x
    work = share * ddot(sigma, deps) + (1 - share) / x * ddot(hooke(lame, shear, deps), deps)
    after = relaxed(lame, shear, sigma, deps, dt, relaxation_time)
    return work - elastic_energy(lame, shear, after) + elastic_energy(lame, shear, sigma)

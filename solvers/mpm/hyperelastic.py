"""Hyperelastic laws: Cauchy stress [Pa] and strain energy per reference volume [J/m^3], functions of J = det F and b = F F^T.

`lame` and `shear` are lambda and mu [Pa]. Where J <= 0 the caller passes NaN for J.

References
----------
Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008, chapter 6; Simo and Hughes, Computational
Inelasticity, 1998, section 9.2 (uncoupled volume and shape).
"""

from math import nan

from ..tracing import log, power, traced, where
from .tensors import Symmetric, combined, ddot, dimension, logarithm, shifted, squared, trace

# Numbers and lanes of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def neo_hookean(lame: float, shear: float, J: float, b: Symmetric) -> Symmetric:
    """J sigma = lambda ln J I + mu (b - I)."""
    return shifted((lame * log(J) - shear) / J, shear / J, b)


@traced
def neo_hookean_energy(lame: float, shear: float, J: float, b: Symmetric) -> float:
    """W = lambda (ln J)^2/2 - mu ln J + mu (tr b - 3)/2."""
    return 0.5 * lame * log(J) * log(J) - shear * log(J) + 0.5 * shear * (trace(b) - dimension(b))


@traced
def neo_hookean_split(lame: float, shear: float, J: float, b: Symmetric) -> Symmetric:
    """J sigma = K (J^2 - 1)/2 I + mu J^(-2/3) (b - tr(b)/3 I)."""
    return uncoupled(lame + 2 * shear / 3, shear, J, b)


@traced
def neo_hookean_split_energy(lame: float, shear: float, J: float, b: Symmetric) -> float:
    """W = K/2 [(J^2 - 1)/2 - ln J] + mu (J^(-2/3) tr b - 3)/2."""
    return volume_energy(lame + 2 * shear / 3, J) + 0.5 * shear * shape_strain(J, b)


@traced
def hencky(lame: float, shear: float, J: float, b: Symmetric) -> Symmetric:
    """J sigma = lambda ln J I + mu ln b."""
    return shifted(lame * log(J) / J, shear / J, logarithm(b, J))


@traced
def hencky_energy(lame: float, shear: float, J: float, b: Symmetric) -> float:
    """W = lambda (ln J)^2/2 + mu ln b : ln b/4."""
    strain = logarithm(b, J)
    return 0.5 * lame * log(J) * log(J) + 0.25 * shear * ddot(strain, strain)


@traced
def saint_venant_kirchhoff(lame: float, shear: float, J: float, b: Symmetric) -> Symmetric:
    """S = lambda tr(E) I + 2 mu E, so that J sigma = lambda tr(b - I)/2 b + mu b (b - I)."""
    return combined((0.5 * lame * (trace(b) - dimension(b)) - shear) / J, b, shear / J, squared(b))


@traced
def saint_venant_kirchhoff_energy(lame: float, shear: float, J: float, b: Symmetric) -> float:
    """W = lambda (tr E)^2/2 + mu E : E, where tr E = tr(b - I)/2 and E : E = tr (b - I)^2/4."""
    doubled = shifted(-1.0, 1.0, b)
    stored = 0.125 * lame * trace(doubled) * trace(doubled) + 0.25 * shear * ddot(doubled, doubled)
    return where(J > 0, stored, nan)


@traced
def yeoh(lame: float, shear: float, J: float, b: Symmetric, second: float, third: float) -> Symmetric:
    """The split neo-Hookean stress with mu = 2 dW/dx = mu_0 + 4 C20 x + 6 C30 x^2, x = J^(-2/3) tr b - 3."""
    x = shape_strain(J, b)
    return uncoupled(lame + 2 * shear / 3, shear + x * (4 * second + 6 * third * x), J, b)


@traced
def yeoh_energy(lame: float, shear: float, J: float, b: Symmetric, second: float, third: float) -> float:
    """W = K/2 [(J^2 - 1)/2 - ln J] + mu_0 x/2 + C20 x^2 + C30 x^3, x = J^(-2/3) tr b - 3."""
    x = shape_strain(J, b)
    return volume_energy(lame + 2 * shear / 3, J) + x * (0.5 * shear + x * (second + third * x))


# Parts that laws share.


@traced
def uncoupled(bulk: float, shear: float, J: float, b: Symmetric) -> Symmetric:
    """J sigma = K (J^2 - 1)/2 I + mu J^(-2/3) (b - tr(b)/3 I) of a bulk and a shear modulus, which may vary with the strain."""
    isochoric = shear * power(J, -5 / 3)
    return shifted(0.5 * bulk * (J - 1 / J) - isochoric * (trace(b) + 3 - dimension(b)) / 3, isochoric, b)


@traced
def volume_energy(bulk: float, J: float) -> float:
    """K/2 [(J^2 - 1)/2 - ln J]."""
    return 0.5 * bulk * (0.5 * (J * J - 1) - log(J))


@traced
def shape_strain(J: float, b: Symmetric) -> float:
    """Strain J^(-2/3) tr b - 3 of the shape, in three dimensions also for a plane or a line [1]."""
    return power(J, -2 / 3) * (trace(b) + 3 - dimension(b)) - 3

"""Hyperelastic laws of finite strain: stress and energy from the deformation gradient."""

from math import nan

from ..tracing import log, power, switch, traced, where
from .tensors import (
    Symmetric,
    Tensor,
    combined,
    ddot,
    det,
    dimension,
    left_cauchy_green,
    logarithm,
    shifted,
    squared,
    trace,
)

# What is a number or lanes has no annotation.
# mypy: disable-error-code="no-untyped-def"

NEO_HOOKEAN, NEO_HOOKEAN_SPLIT, HENCKY, SAINT_VENANT_KIRCHHOFF = range(4)


@traced
def volume_ratio(F: Tensor) -> float:
    """J = det F, NaN unless it is positive: so is every component of a stress that it divides."""
    J = det(F)
    return where(J > 0, J, nan)


@traced
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

    def split():
        bulk, isochoric = lame + 2 * shear / 3, shear * power(J, -5 / 3)
        return shifted(0.5 * bulk * (J - 1 / J) - isochoric * (trace(b) + 3 - dimension(b)) / 3, isochoric, b)

    return switch(
        law,
        {
            NEO_HOOKEAN: lambda: shifted((lame * log(J) - shear) / J, shear / J, b),
            NEO_HOOKEAN_SPLIT: split,
            HENCKY: lambda: shifted(lame * log(J) / J, shear / J, logarithm(b, J)),
        },
        lambda: combined((0.5 * lame * (trace(b) - dimension(b)) - shear) / J, b, shear / J, squared(b)),
    )


@traced
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
    J, b = volume_ratio(F), left_cauchy_green(F)

    def neo_hookean():
        return 0.5 * lame * log(J) * log(J) - shear * log(J) + 0.5 * shear * (trace(b) - dimension(b))

    def split():
        bulk, stretched = lame + 2 * shear / 3, power(J, -2 / 3) * (trace(b) + 3 - dimension(b)) - 3
        return 0.5 * bulk * (0.5 * (J * J - 1) - log(J)) + 0.5 * shear * stretched

    def hencky():
        strain = logarithm(b, J)
        return 0.5 * lame * log(J) * log(J) + 0.25 * shear * ddot(strain, strain)

    def saint_venant_kirchhoff():
        doubled = shifted(-1.0, 1.0, b)
        stored = 0.125 * lame * trace(doubled) * trace(doubled) + 0.25 * shear * ddot(doubled, doubled)
        return where(J > 0, stored, nan)

    ways = {NEO_HOOKEAN: neo_hookean, NEO_HOOKEAN_SPLIT: split, HENCKY: hencky}
    return switch(law, ways, saint_venant_kirchhoff)

"""Materials: their parameters and wave speeds. Each solver family implements the constitutive laws for itself."""

import math
from dataclasses import dataclass, field

from mpmverify.errors import UsageError


@dataclass(frozen=True)
class Transport:
    """A scalar carried at a constant velocity: u_t + a u_x = 0.

    Parameters
    ----------
    velocity : float
        a [m/s].

    Raises
    ------
    UsageError
        If the velocity is not finite.
    """

    velocity: float

    def __post_init__(self) -> None:
        if not math.isfinite(self.velocity):
            raise UsageError(f"the velocity of transport must be finite, not {self.velocity!r}")

    @property
    def wave_speed(self) -> float:
        return abs(self.velocity)


@dataclass(frozen=True)
class LinearElastic:
    """Isotropic linear elasticity at small strain, sigma = 2 mu eps + lambda tr(eps) I; plane strain in two dimensions.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa].
    density : float
        Reference density rho0 [kg/m^3].
    poissons_ratio : float
        nu [1]; with nu = 0 a one-dimensional body, which is strained uniaxially, behaves as a slender bar.

    Raises
    ------
    UsageError
        If E or rho0 is not positive and finite, or nu does not lie in (-1, 1/2).
    """

    youngs_modulus: float
    density: float
    poissons_ratio: float = 0.0

    def __post_init__(self) -> None:
        if not (0 < self.youngs_modulus < math.inf and 0 < self.density < math.inf and -1 < self.poissons_ratio < 0.5):
            raise UsageError(f"Young's modulus and density must be positive and finite, and -1 < nu < 1/2: {self!r}")

    @property
    def shear_modulus(self) -> float:
        return self.youngs_modulus / (2 * (1 + self.poissons_ratio))

    @property
    def lame_lambda(self) -> float:
        nu = self.poissons_ratio
        return self.youngs_modulus * nu / ((1 + nu) * (1 - 2 * nu))

    @property
    def wave_speed(self) -> float:
        """Speed of P waves in the undeformed body [m/s], the largest wave speed there."""
        return math.sqrt((self.lame_lambda + 2 * self.shear_modulus) / self.density)

    @property
    def shear_wave_speed(self) -> float:
        """Speed of S waves in the undeformed body [m/s]."""
        return math.sqrt(self.shear_modulus / self.density)


@dataclass(frozen=True)
class PlaneStress(LinearElastic):
    """Linear elasticity in plane stress, sigma_zz = 0: a thin plate in two dimensions, a strip with eps_yy = 0 in one.

    The in-plane law is that of `LinearElastic` with `lame_lambda` = 2 lambda mu/(lambda + 2 mu) = E nu/(1 - nu^2). Plane stress does
    not exist in three dimensions.
    """

    @property
    def lame_lambda(self) -> float:
        return self.youngs_modulus * self.poissons_ratio / (1 - self.poissons_ratio**2)


@dataclass(frozen=True)
class KelvinVoigt(LinearElastic):
    """Kelvin-Voigt viscoelasticity at small strain, spring and dashpot in parallel: sigma = C : (eps + theta eps_dot).

    P and S waves have the same retardation time theta = eta/(lambda + 2 mu). In one dimension
    sigma = (lambda + 2 mu) eps + eta eps_dot.

    Parameters
    ----------
    viscosity : float
        Viscosity eta in uniaxial strain [Pa s].

    Raises
    ------
    UsageError
        If the viscosity is not positive and finite, or as for `LinearElastic`.

    Notes
    -----
    The viscosity lowers the stable time step of an explicit scheme that evaluates eps_dot half a step late: the limit is
    omega dt/2 = sqrt(1 + xi^2) - xi, with the damping ratio xi = theta omega/2 of the highest frequency omega of the grid.
    """

    viscosity: float = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 < self.viscosity < math.inf:
            raise UsageError(f"the viscosity must be positive and finite, not {self.viscosity!r}: without it use LinearElastic")

    @property
    def retardation_time(self) -> float:
        """Retardation time theta = eta/(lambda + 2 mu) [s]."""
        return self.viscosity / (self.lame_lambda + 2 * self.shear_modulus)


@dataclass(frozen=True)
class Maxwell(LinearElastic):
    """Maxwell viscoelasticity at small strain, spring and dashpot in series: sigma_dot = C : eps_dot - sigma/tau.

    Parameters
    ----------
    relaxation_time : float
        tau [s], the same for all components of the stress.

    Raises
    ------
    UsageError
        If the relaxation time is not positive and finite, or as for `LinearElastic`.
    """

    relaxation_time: float = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 < self.relaxation_time < math.inf:
            raise UsageError(
                f"the relaxation time must be positive and finite, not {self.relaxation_time!r}: without it use LinearElastic"
            )


@dataclass(frozen=True)
class NeoHookean(LinearElastic):
    """Compressible neo-Hookean law; E and nu are the moduli at small strain.

    Notes
    -----
    The energy per reference volume is W = mu/2 (tr F^T F - 3 - 2 ln J) + lambda/2 (ln J)^2, so that

        P = lambda ln(J) F^-T + mu (F - F^-T),    sigma = [lambda ln(J) I + mu (F F^T - I)]/J,

    with F_33 = 1 in plane strain. In one dimension, where the strain is uniaxial, both are lambda ln(F)/F + mu (F - 1/F).
    """


@dataclass(frozen=True)
class NeoHookeanSplit(LinearElastic):
    """Neo-Hookean law with a volumetric-isochoric split: W = K/2 [(J^2 - 1)/2 - ln J] + mu/2 (J^(-2/3) tr b - 3)."""


@dataclass(frozen=True)
class Hencky(LinearElastic):
    """Linear elasticity in the logarithmic strain, J sigma = lambda ln J I + mu ln b; E and nu are the moduli at small strain."""


@dataclass(frozen=True)
class SaintVenantKirchhoff(LinearElastic):
    """Linear elasticity in the Green-Lagrange strain, S = lambda tr(E) I + 2 mu E.

    In uniaxial strain the compressive nominal stress is largest at F = 1/sqrt(3); below that stretch the body softens.
    """


@dataclass(frozen=True)
class Yeoh(LinearElastic):
    """Compressible Yeoh body, rubber that stiffens at large strain; E and nu are those at small strain.

    Parameters
    ----------
    second : float
        C20 [Pa]; negative for filled rubber, which softens before it stiffens.
    third : float
        C30 [Pa].

    Raises
    ------
    UsageError
        If a coefficient is not finite, or the body softens without bound: C10 + 2 C20 x + 3 C30 x^2 has to be positive for every
        x >= 0, where C10 = mu/2. Otherwise as for `LinearElastic`.

    Notes
    -----
    W = C10 x + C20 x^2 + C30 x^3 + K/2 [(J^2 - 1)/2 - ln J] per reference volume, where x = J^(-2/3) tr b - 3 and
    K = lambda + 2 mu/3. With both coefficients zero it is `NeoHookeanSplit`.

    References
    ----------
    Yeoh, 1993, doi:10.5254/1.3538343; Simo and Hughes, Computational Inelasticity, 1998, section 9.2 (part of the volume).
    """

    second: float = field(kw_only=True)
    third: float = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (math.isfinite(self.second) and math.isfinite(self.third)):
            raise UsageError(f"the coefficients of a Yeoh body must be finite: {self!r}")
        if self.third < 0 or (self.second < 0 and self.second**2 >= 1.5 * self.shear_modulus * self.third):
            raise UsageError(f"a Yeoh body must not soften without bound, C30 >= 0 and C20 > -sqrt(3 C10 C30): {self!r}")


Material = Transport | LinearElastic

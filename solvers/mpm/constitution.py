"""Constitutive laws of a material point in one, two and three dimensions: the table `LAWS`, and what the time loop asks of a law.

A body in one dimension is in uniaxial strain (at nu = 0 a slender bar), in two in plane strain unless it is `PlaneStress`. The
stress out of the plane is not stored: it does no work, and the energies account for the stretches F_zz = 1 that go with it.
Tensors are tuples, see `mpmverify.solvers.mpm.tensors`.

To add a law, write its functions in `hyperelastic` or `small_strain` (or a module of its own) and enter it in `LAWS`.
"""

import operator
from collections.abc import Callable
from functools import partial, reduce
from math import nan
from typing import Any, NamedTuple

from mpmverify.problem import material as materials

from ..tracing import equal, switch, traced, where
from . import hyperelastic, small_strain
from .tensors import Symmetric, Tensor, det, first_piola_kirchhoff, full, left_cauchy_green, sym

# Numbers and lanes of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"


class FiniteStrain(NamedTuple):
    """Objective law of the deformation gradient, which does not bear J <= 0; functions as in `hyperelastic`.

    stress : function
        Cauchy stress [Pa] of (lame, shear, J, b, *parameters).
    energy : function
        Strain energy per reference volume [J/m^3] of the same.
    parameters : tuple of str
        Properties of the material that the functions take beyond lambda and mu.
    """

    stress: Callable[..., Any]
    energy: Callable[..., Any]
    parameters: tuple[str, ...] = ()


class SmallStrain(NamedTuple):
    """Law of the increment of strain, which does not see J; functions as in `small_strain`.

    stress : function
        Cauchy stress after a step [Pa] of (lame, shear, sigma, F, deps, dt, *parameters).
    energy : function
        Stored energy [J/m^3] of (lame, shear, sigma, F, *parameters).
    heat : function, optional
        Energy that a step turns into heat [J/m^3], of (lame, shear, sigma, deps, dt, *parameters); None for an elastic law.
    parameters : tuple of str
        Properties of the material that the functions take beyond lambda and mu.
    """

    stress: Callable[..., Any]
    energy: Callable[..., Any]
    heat: Callable[..., Any] | None = None
    parameters: tuple[str, ...] = ()


LINEAR_ELASTIC = SmallStrain(small_strain.linear_elastic, small_strain.linear_elastic_energy)
LAWS: dict[type, FiniteStrain | SmallStrain] = {
    materials.LinearElastic: LINEAR_ELASTIC,
    materials.PlaneStress: LINEAR_ELASTIC,
    materials.KelvinVoigt: SmallStrain(
        small_strain.kelvin_voigt,
        small_strain.kelvin_voigt_energy,
        small_strain.kelvin_voigt_heat,
        ("retardation_time",),
    ),
    materials.Maxwell: SmallStrain(
        small_strain.maxwell, small_strain.maxwell_energy, small_strain.maxwell_heat, ("relaxation_time",)
    ),
    materials.NeoHookean: FiniteStrain(hyperelastic.neo_hookean, hyperelastic.neo_hookean_energy),
    materials.NeoHookeanSplit: FiniteStrain(hyperelastic.neo_hookean_split, hyperelastic.neo_hookean_split_energy),
    materials.Hencky: FiniteStrain(hyperelastic.hencky, hyperelastic.hencky_energy),
    materials.SaintVenantKirchhoff: FiniteStrain(
        hyperelastic.saint_venant_kirchhoff, hyperelastic.saint_venant_kirchhoff_energy
    ),
    materials.Yeoh: FiniteStrain(hyperelastic.yeoh, hyperelastic.yeoh_energy, ("second", "third")),
}
"""Law of each material. Plane stress is linear elasticity with its own lambda, and is refused in three dimensions."""
ROOM = max(len(law.parameters) for law in LAWS.values())


class Linear(NamedTuple):
    """Linear elasticity, the one law of a time loop that is compiled without the others."""


class Numbered(NamedTuple):
    """Any other law of `LAWS`; a time loop holds them all and is compiled once.

    number : int
        Position in `LAWS`.
    """

    number: int


Law = Linear | Numbered


class Constants(NamedTuple):
    """Constants of a law.

    lame : float
        lambda [Pa].
    shear : float
        mu [Pa].
    parameters : tuple of float
        Parameters of the law in the order of its `parameters`, then zeros, as many as any law has.
    """

    lame: float
    shear: float
    parameters: tuple[float, ...]


def constitution(material: materials.LinearElastic) -> tuple[Law, Constants]:
    """Law of a material and its constants."""
    law = LAWS[type(material)]
    own = [float(getattr(material, name)) for name in law.parameters]
    constants = Constants(float(material.lame_lambda), float(material.shear_modulus), (*own, *[0.0] * (ROOM - len(own))))
    if law is LINEAR_ELASTIC:
        return Linear(), constants
    return Numbered(list(LAWS).index(type(material))), constants


@traced
def stress(law: Law, constants: Constants, sigma: Symmetric, F: Tensor, increment: Tensor, dt: float) -> Symmetric:
    """Cauchy stress after a step [Pa]; all NaN when a law of finite strain meets J <= 0.

    Parameters
    ----------
    law : Linear or Numbered
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
    """
    deps = sym(increment)
    if isinstance(law, Linear):
        return LINEAR_ELASTIC.stress(constants.lame, constants.shear, sigma, F, deps, dt)
    return switch(
        law.number,
        _ways(SmallStrain, "stress", constants, sigma, F, deps, dt),
        lambda: _finite(law, "stress", constants, F),
    )


@traced
def strain_energy(law: Law, constants: Constants, sigma: Symmetric, F: Tensor) -> float:
    """Stored energy [J/m^3] per volume that the stress acts on at small strain, per reference volume at finite strain."""
    if isinstance(law, Linear):
        return LINEAR_ELASTIC.energy(constants.lame, constants.shear, sigma, F)
    return switch(
        law.number,
        _ways(SmallStrain, "energy", constants, sigma, F),
        lambda: _finite(law, "energy", constants, F),
    )


@traced
def dissipation(law: Law, constants: Constants, sigma: Symmetric, increment: Tensor, dt: float) -> float:
    """Energy that a step turns into heat, per volume that the stress acts on [J/m^3]; `sigma` is the stress before it."""
    if isinstance(law, Linear):
        return 0.0
    return switch(law.number, _ways(SmallStrain, "heat", constants, sigma, sym(increment), dt), 0.0)


def _ways(kind: type, function: str, constants: Constants, *arguments: Any) -> dict[int, Callable[[], Any]]:
    """Calls of a function of the laws of a kind, by their numbers."""
    ways: dict[int, Callable[[], Any]] = {}
    for number, law in enumerate(LAWS.values()):
        if isinstance(law, kind) and law is not LINEAR_ELASTIC and getattr(law, function):
            own = constants.parameters[: len(law.parameters)]
            ways[number] = partial(getattr(law, function), constants.lame, constants.shear, *arguments, *own)
    return ways


def _finite(law: Numbered, function: str, constants: Constants, F: Tensor) -> Any:
    """What a function of a law of finite strain returns."""
    ways = _ways(FiniteStrain, function, constants, volume_ratio(F), left_cauchy_green(F))
    _, last = ways.popitem()
    return switch(law.number, ways, last)


@traced
def volume_ratio(F: Tensor) -> float:
    """J = det F, NaN unless it is positive: so is every component of a stress that it divides."""
    J = det(F)
    return where(J > 0, J, nan)


@traced
def reference_stress(law: Law, sigma: Symmetric, F: Tensor) -> Tensor:
    """Stress of the total Lagrangian formulation [Pa]: sigma at small strain, P = J sigma F^-T at finite strain."""
    if isinstance(law, Linear):
        return full(sigma)
    return where(finite_strain(law), first_piola_kirchhoff(sigma, F), full(sigma))


@traced
def finite_strain(law: Law) -> bool:
    """Whether a law is one of finite strain, which is objective and does not bear J <= 0."""
    return False if isinstance(law, Linear) else _among(law, [isinstance(entry, FiniteStrain) for entry in LAWS.values()])


@traced
def viscous(law: Law) -> bool:
    """Whether a law turns energy into heat."""
    return False if isinstance(law, Linear) else _among(law, [bool(getattr(entry, "heat", None)) for entry in LAWS.values()])


def _among(law: Numbered, chosen: list[bool]) -> Any:
    """Whether a law is one of those that are chosen; asked of the number, it lets the compiler merge branches on laws."""
    return reduce(operator.or_, [equal(law.number, number) for number, one in enumerate(chosen) if one])

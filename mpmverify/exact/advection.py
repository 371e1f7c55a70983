"""Linear advection of a scalar: the initial profile moves without change at a constant velocity."""

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, BoundaryCondition, Constant, Inflow, Outflow, Periodic, Problem, Transport

CITATION = (
    "Donea J. (1984). A Taylor-Galerkin method for convective transport problems. International Journal for Numerical Methods "
    "in Engineering 20(1), 101-119, doi:10.1002/nme.1620200108"
)


class Profile(Protocol):
    """Initial value of the scalar, elementwise in the position [m]; `derivatives` is the number of its derivatives in L1."""

    @property
    def name(self) -> str: ...
    @property
    def derivatives(self) -> float: ...
    @property
    def latex(self) -> str: ...
    def __call__(self, x: Array) -> Array: ...


@dataclass(frozen=True)
class CosineHill:
    """Cosine hill (1 + cos(pi (x - x0)/w))/2 on |x - x0| < w, whose second derivative jumps; centre x0 [m], width w [m]."""

    centre: float = 0.5
    width: float = 0.25
    name: ClassVar[str] = "hill"
    derivatives: ClassVar[float] = 3.0
    latex: ClassVar[str] = r"u_0(x) = \tfrac{1}{2}\left(1+\cos\frac{\pi (x-x_0)}{w}\right) H(w-|x-x_0|)"

    def __call__(self, x: Array) -> Array:
        s = np.clip((x - self.centre) / self.width, -1, 1)
        return np.cos(np.pi * s / 2) ** 2


@dataclass(frozen=True)
class Gaussian:
    """Gaussian exp(-((x - x0)/w)^2); centre x0 [m], width w [m]."""

    centre: float = 0.5
    width: float = 0.1
    name: ClassVar[str] = "gaussian"
    derivatives: ClassVar[float] = math.inf
    latex: ClassVar[str] = r"u_0(x) = \exp\left(-\frac{(x-x_0)^2}{w^2}\right)"

    def __call__(self, x: Array) -> Array:
        return np.exp(-(((x - self.centre) / self.width) ** 2))


@dataclass(frozen=True)
class Step:
    """A jump; at the jump the value is the mean of both sides.

    Parameters
    ----------
    centre : float
        Position x0 of the jump [m].
    left, right : float
        Values at x < x0 and at x > x0 [1].
    """

    centre: float = 0.25
    left: float = 1.0
    right: float = 0.0
    name: ClassVar[str] = "step"
    derivatives: ClassVar[float] = 1.0
    latex: ClassVar[str] = r"u_0(x) = u_L H(x_0-x) + u_R H(x-x_0)"

    def __call__(self, x: Array) -> Array:
        return self.right + (self.left - self.right) * np.heaviside(self.centre - x, 0.5)


@dataclass(frozen=True)
class FourierMode:
    """cos(2 pi m x) with the integer `mode` m, an eigenfunction of every linear scheme on a uniform periodic grid."""

    mode: int = 1
    derivatives: ClassVar[float] = math.inf
    latex: ClassVar[str] = r"u_0(x) = \cos(2\pi m x)"

    @property
    def name(self) -> str:
        return f"mode-{self.mode}"

    def __call__(self, x: Array) -> Array:
        return np.cos(2 * np.pi * self.mode * x)


@dataclass(frozen=True)
class PeriodicImages:
    """Sum of a profile over its periodic images, so that a Gaussian is smooth across the ends of the domain.

    Parameters
    ----------
    profile : CosineHill or Gaussian
        Profile with its centre in [0, L] that is below 1e-15 at -2 L and 3 L.
    period : float
        L [m].

    Raises
    ------
    UsageError
        If the centre lies outside the period, or the profile is too wide.
    """

    profile: CosineHill | Gaussian
    period: float = 1.0

    def __post_init__(self) -> None:
        too_wide = np.any(self.profile(self.period * np.array([-2.0, 3.0])) > 1e-15)
        if too_wide or not 0 <= self.profile.centre <= self.period:
            raise UsageError(f"{self.profile!r} does not fit a period of {self.period!r}: centre it inside or narrow it")

    def __call__(self, x: Array) -> Array:
        wrapped = np.mod(x, self.period)
        return np.sum([self.profile(wrapped + n * self.period) for n in range(-2, 3)], axis=0)


@dataclass(frozen=True)
class Translated:
    """Advected profile u0(x - a t): positions (P, 1) [m], times (T,) [s] -> (T, P, 1)."""

    profile: Profile | PeriodicImages
    velocity: float

    def __call__(self, X: Array, t: Array) -> Array:
        return self.profile(X[None] - self.velocity * t[:, None, None])


def advection(profile: Profile | None = None, *, velocity: float = 1.0, end_time: float | None = None) -> VerificationProblem:
    """Advection on [0, 1], with inflow and outflow for a step and periodic for any other profile.

    Parameters
    ----------
    profile : CosineHill, Gaussian, FourierMode or Step, optional
        Initial profile u0; the cosine hill by default.
    velocity : float
        a [m/s].
    end_time : float, optional
        Final time [s]; by default one period 1/|a|, for a step half of it.

    Raises
    ------
    UsageError
        If the velocity is zero, or the profile does not fit the period.

    References
    ----------
    Donea J. (1984). A Taylor-Galerkin method for convective transport problems. International Journal for Numerical Methods in
    Engineering 20(1), 101-119, https://doi.org/10.1002/nme.1620200108
    """
    profile = CosineHill() if profile is None else profile
    if velocity == 0:
        raise UsageError("advection needs a velocity other than zero")
    boundary: dict[str, BoundaryCondition] = {"x-": Periodic(), "x+": Periodic()}
    condition = "u(0,t) = u(1,t)"
    if isinstance(profile, Step):
        upstream, downstream, value = ("x-", "x+", profile.left) if velocity > 0 else ("x+", "x-", profile.right)
        boundary = {upstream: Inflow(Constant(value)), downstream: Outflow()}
        condition = "u(0,t) = u_L" if velocity > 0 else "u(1,t) = u_R"
    initial = PeriodicImages(profile) if isinstance(profile, CosineHill | Gaussian) else profile
    return VerificationProblem(
        problem=Problem(
            name=f"advection-{profile.name}",
            lower=(0.0,),
            upper=(1.0,),
            material=Transport(velocity),
            boundary=boundary,
            end_time=(0.5 if isinstance(profile, Step) else 1.0) / abs(velocity) if end_time is None else end_time,
            initial={"u": initial},
        ),
        exact=ExactSolution({"u": Translated(initial, velocity)}, CITATION, profile.derivatives),
        exposes="Phase and dissipation errors of the transport scheme.",
        equations=(r"\partial_t u + a\, \partial_x u = 0", profile.latex, condition, r"u(x,t) = u_0(x - a t)"),
    )

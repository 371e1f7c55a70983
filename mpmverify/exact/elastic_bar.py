"""Elastic bar, fixed at one end and loaded at the other: d'Alembert's solution by the method of images."""

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from scipy.special import erf

from mpmverify.errors import UsageError
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Constant, History, LinearElastic, Problem, Traction, Velocity

CITATION = "Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford, chapter 2 (d'Alembert, images)"


class Load(History, Protocol):
    """A traction history that is zero before t = 0; `derivatives` is the number of its derivatives in L1."""

    @property
    def name(self) -> str: ...
    @property
    def derivatives(self) -> float: ...
    @property
    def latex(self) -> str: ...


@dataclass(frozen=True)
class StepLoad:
    """Constant p0 from t = 0 on; amplitude p0 [Pa]."""

    amplitude: float = 1e-6
    name: ClassVar[str] = "step"
    derivatives: ClassVar[float] = 1.0
    latex: ClassVar[str] = r"p(t) = p_0 H(t)"

    def __call__(self, t: Array) -> Array:
        return np.where(t >= 0, self.amplitude, 0.0)

    def integral(self, t: Array) -> Array:
        return self.amplitude * np.maximum(t, 0.0)


@dataclass(frozen=True)
class RampLoad:
    """Linear rise from 0 to p0 in the time t_r, then constant; amplitude p0 [Pa], duration t_r [s]."""

    amplitude: float = 1e-6
    duration: float = 0.3
    name: ClassVar[str] = "ramp"
    derivatives: ClassVar[float] = 2.0
    latex: ClassVar[str] = r"p(t) = p_0 \min\left(\frac{t}{t_r}, 1\right) H(t)"

    def __call__(self, t: Array) -> Array:
        return self.amplitude * np.clip(t / self.duration, 0, 1)

    def integral(self, t: Array) -> Array:
        rising = np.clip(t, 0, self.duration)
        return self.amplitude * (rising**2 / (2 * self.duration) + np.maximum(t - self.duration, 0))


@dataclass(frozen=True)
class SmoothPulse:
    """Pulse p0 exp(-((t - t0)/w)^2), zero before t = 0; amplitude p0 [Pa], centre t0 >= 6 w [s], width w [s].

    Raises
    ------
    UsageError
        If 0 < 6 w <= t0 does not hold.
    """

    amplitude: float = 1e-6
    centre: float = 0.5
    width: float = 0.08
    name: ClassVar[str] = "pulse"
    derivatives: ClassVar[float] = math.inf
    latex: ClassVar[str] = r"p(t) = p_0 \exp\left(-\frac{(t-t_0)^2}{w^2}\right) H(t)"

    def __post_init__(self) -> None:
        if not 0 < 6 * self.width <= self.centre:
            raise UsageError(f"{self!r} is not negligible at t = 0: move its centre to six widths or later")

    def __call__(self, t: Array) -> Array:
        return np.where(t >= 0, self.amplitude * np.exp(-(((t - self.centre) / self.width) ** 2)), 0.0)

    def integral(self, t: Array) -> Array:
        start, end = -self.centre / self.width, (np.maximum(t, 0) - self.centre) / self.width
        return self.amplitude * self.width * math.sqrt(math.pi) / 2 * (erf(end) - erf(start))


@dataclass(frozen=True)
class SineLoad:
    """Load p0 sin(omega t) from t = 0 on; amplitude p0 [Pa], omega [rad/s].

    The bar resonates at odd multiples of pi c/(2 L).
    """

    amplitude: float = 1e-6
    omega: float = 2 * math.pi
    name: ClassVar[str] = "sine"
    derivatives: ClassVar[float] = 2.0
    latex: ClassVar[str] = r"p(t) = p_0 \sin(\omega t) H(t)"

    def __call__(self, t: Array) -> Array:
        return self.amplitude * np.sin(self.omega * np.maximum(t, 0))

    def integral(self, t: Array) -> Array:
        return self.amplitude * 2 / self.omega * np.sin(self.omega * np.maximum(t, 0) / 2) ** 2


@dataclass(frozen=True)
class Integral:
    """Time integral of a load from 0, as a function of time [s]."""

    history: Load

    def __call__(self, t: Array) -> Array:
        return self.history.integral(t)


@dataclass(frozen=True)
class ImageSum:
    """Waves from the loaded end x = L with their reflections at both ends: (P, 1) [m], (T,) [s] -> (T, P, 1).

    a sum_n (-1)^n [f(t - (2nL + L - x)/c) + s f(t - (2nL + L + x)/c)], a finite sum at any time.

    Parameters
    ----------
    emitted : Load or Integral
        f, zero before t = 0.
    length : float
        L [m].
    wave_speed : float
        c [m/s].
    sign : float
        s: 1 for stress, -1 for velocity and displacement, which vanish at the fixed end.
    scale : float
        a.
    """

    emitted: Load | Integral
    length: float
    wave_speed: float
    sign: float
    scale: float = 1.0

    def __call__(self, X: Array, t: Array) -> Array:
        L, c, f = self.length, self.wave_speed, self.emitted
        x, time = X[None], t[:, None, None]
        total = np.zeros((len(t), *X.shape))
        for n in range(math.ceil(c * np.max(t, initial=0.0) / (2 * L)) + 1):
            total += (-1) ** n * (f(time - ((2 * n + 1) * L - x) / c) + self.sign * f(time - ((2 * n + 1) * L + x) / c))
        return self.scale * total


def elastic_bar(
    load: Load | None = None,
    *,
    length: float = 1.0,
    youngs_modulus: float = 1.0,
    density: float = 1.0,
    end_time: float | None = None,
) -> VerificationProblem:
    """Bar initially at rest, fixed at x = 0, with the traction p(t) at x = L.

    The declared regularity is that of stress and velocity; the displacement has one derivative more. With the default loads the strain
    stays near 1e-6, so that geometric nonlinearity is below the error of any feasible mesh.

    Parameters
    ----------
    load : StepLoad, RampLoad, SmoothPulse or SineLoad, optional
        Traction p; the step by default.
    length, youngs_modulus, density : float
        L [m], E [Pa], rho [kg/m^3].
    end_time : float, optional
        Final time [s]. By default 1.6 L/c, when the front has been reflected once and is inside the bar; for a pulse 2.5 L/c after
        its centre entered, when it has been reflected once at each end and is at mid-length.

    References
    ----------
    Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford.
    """
    load = StepLoad() if load is None else load
    material = LinearElastic(youngs_modulus, density)
    c = material.wave_speed
    if end_time is None:
        end_time = load.centre + 2.5 * length / c if isinstance(load, SmoothPulse) else 1.6 * length / c
    compliance = 1 / (density * c)
    arrivals = r"\left(t-\frac{(2n+1)L-x}{c}\right)", r"\left(t-\frac{(2n+1)L+x}{c}\right)"
    return VerificationProblem(
        problem=Problem(
            name=f"elastic-bar-{load.name}",
            lower=(0.0,),
            upper=(length,),
            material=material,
            boundary={"x-": Velocity(Constant(0.0)), "x+": Traction(load)},
            end_time=end_time,
        ),
        exact=ExactSolution(
            fields={
                "stress": ImageSum(load, length, c, 1.0),
                "velocity": ImageSum(load, length, c, -1.0, compliance),
                "displacement": ImageSum(Integral(load), length, c, -1.0, compliance),
            },
            citation=CITATION,
            derivatives=load.derivatives,
        ),
        exposes="Oscillation behind a front and the treatment of the fixed and the loaded end.",
        equations=(
            r"\rho\, \partial_t v = \partial_x \sigma, \quad \partial_t \sigma = E\, \partial_x v, \quad \partial_t u = v",
            r"\sigma(x,0) = v(x,0) = u(x,0) = 0",
            r"v(0,t) = 0, \quad \sigma(L,t) = p(t)",
            load.latex,
            rf"\sigma = \sum_{{n \ge 0}} (-1)^n \left[ p{arrivals[0]} + p{arrivals[1]} \right], \quad c = \sqrt{{E/\rho}}",
            rf"\rho c\, v = \sum_{{n \ge 0}} (-1)^n \left[ p{arrivals[0]} - p{arrivals[1]} \right]",
            r"u(x,t) = \int_0^t v(x,s)\, ds",
        ),
    )

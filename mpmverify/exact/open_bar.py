"""Elastic bar loaded at one end, with an absorbing end that reflects no wave."""

from dataclasses import dataclass

import numpy as np

from mpmverify.exact.elastic_bar import CITATION, Integral, Load, SmoothPulse
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Absorbing, Array, LinearElastic, Problem, Traction


@dataclass(frozen=True)
class LeftgoingWave:
    """Wave a f(t - (X1 - X)/c) from X1 towards smaller X: (P, 1) [m], (T,) [s] -> (T, P, 1).

    Parameters
    ----------
    emitted : Load or Integral
        f, zero before t = 0.
    source : float
        X1 [m].
    wave_speed : float
        c [m/s].
    scale : float
        a.
    """

    emitted: Load | Integral
    source: float
    wave_speed: float
    scale: float = 1.0

    def __call__(self, X: Array, t: Array) -> Array:
        return self.scale * np.asarray(self.emitted(t[:, None, None] - (self.source - X[None]) / self.wave_speed))


def open_bar(
    load: SmoothPulse | None = None,
    *,
    lower: float = 0.5,
    length: float = 1.6,
    youngs_modulus: float = 3.0,
    density: float = 2.0,
    poissons_ratio: float = 0.3,
) -> VerificationProblem:
    """Bar initially at rest with the traction p(t) at x+ and an absorbing end x-, until the centre of the pulse reaches x-.

    Parameters
    ----------
    load : SmoothPulse, optional
        Traction p; the default pulse is seven elements wide on a mesh of 48.
    lower, length : float
        Position of the face x- and length of the bar [m].
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1]; the strain is uniaxial.

    References
    ----------
    Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford.
    """
    load = SmoothPulse(centre=0.96, width=0.16) if load is None else load
    material = LinearElastic(youngs_modulus, density, poissons_ratio)
    c, source = material.wave_speed, lower + length
    compliance = 1 / (density * c)
    return VerificationProblem(
        problem=Problem(
            name=f"open-bar-{load.name}",
            lower=(lower,),
            upper=(source,),
            material=material,
            boundary={"x-": Absorbing(), "x+": Traction(load)},
            end_time=load.centre + length / c,
        ),
        exact=ExactSolution(
            fields={
                "stress": LeftgoingWave(load, source, c),
                "velocity": LeftgoingWave(load, source, c, compliance),
                "displacement": LeftgoingWave(Integral(load), source, c, compliance),
            },
            citation=CITATION,
            derivatives=load.derivatives,
        ),
        exposes="Spurious reflections at an absorbing end.",
        equations=(
            r"\rho\, \partial_t v = \partial_x \sigma, \quad \partial_t \sigma = (\lambda + 2\mu)\, \partial_x v",
            r"\sigma(x,0) = v(x,0) = 0",
            r"\sigma(x_+,t) = p(t), \quad \sigma - \rho c\, v = 0 \text{ at } x_-",
            load.latex,
            r"\sigma = \rho c\, v = p\left(t - \frac{x_+ - x}{c}\right), \quad c = \sqrt{(\lambda + 2\mu)/\rho}",
        ),
    )

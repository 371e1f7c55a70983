"""The GeHoJerez deck: a hat-shaped initial velocity at the free end of a bar, translated exactly at a unit Courant number."""

from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Constant, LinearElastic, Problem, Traction, Velocity

CITATION = (
    "Molinos Perez M. (2019). GeHoJerez, unpublished notes, Madrid, 31 May 2019, section 3.2; closed form by images as in "
    "Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford, chapter 2"
)


@dataclass(frozen=True)
class EndHat:
    """Hat v0 max(0, 1 - x/h) of the node x = 0: positions (P, 1) [m] -> velocity (P, 1) [m/s].

    Parameters
    ----------
    h : float
        Element size [m].
    amplitude : float
        v0 [m/s].
    """

    h: float
    amplitude: float = -1.0

    def __call__(self, X: Array) -> Array:
        return self.amplitude * np.maximum(0.0, 1 - X / self.h)


@dataclass(frozen=True)
class HatWave:
    """a [V(x + ct) + s V(x - ct)]/2 with the initial velocity V continued beyond the bar: (P, 1) [m], (T,) [s] -> (T, P, 1).

    Parameters
    ----------
    length, h, wave_speed, amplitude : float
        L [m], h [m], c [m/s], v0 [m/s].
    sign : float
        s: 1 for velocity, -1 for stress.
    scale : float
        a: 1 for velocity, rho c for stress.

    Notes
    -----
    V is even about the free end x = 0 and odd about the fixed end x = L, hence periodic with 4L.
    """

    length: float
    h: float
    wave_speed: float
    amplitude: float
    sign: float
    scale: float = 1.0

    def __call__(self, X: Array, t: Array) -> Array:
        x, travelled = X[None], self.wave_speed * t[:, None, None]
        return self.scale / 2 * (self._continued(x + travelled) + self.sign * self._continued(x - travelled))

    def _continued(self, x: Array) -> Array:
        L, h = self.length, self.h
        x = np.mod(x + L, 4 * L) - L
        return self.amplitude * (np.maximum(0, 1 - np.abs(x) / h) - np.maximum(0, 1 - np.abs(x - 2 * L) / h))


def deck(
    *, length: float = 8.0, h: float = 1.0, steps: int = 25, youngs_modulus: float = 1.0, density: float = 1.0
) -> VerificationProblem:
    """Unstressed bar, free at x = 0 and fixed at x = L; the initial velocity is -1 at node 0 and falls linearly to 0 at node 1.

    The deck takes 25 steps of dt = h/c from rest and sets v = -1 after the first. Its step k therefore is the time (k - 1) dt
    here, and the problem has 24 steps and 24 outputs. At the midpoints of the elements and at multiples of dt, a scheme at a unit
    Courant number must give every value exactly: a stress of 1/4 in two elements, doubled at the fixed end. A finer
    version has length=5, h=0.25.

    The default final time is 24 dt = 3 L/c, where the velocity vanishes everywhere: judge all outputs, not the last one.

    Parameters
    ----------
    length, h : float
        L and the element size [m].
    steps : int
        Number of steps of the deck, including the first.
    youngs_modulus, density : float
        E [Pa], rho [kg/m^3].

    Raises
    ------
    UsageError
        If h exceeds L or there are fewer than two steps.

    References
    ----------
    Molinos Perez M. (2019). GeHoJerez, unpublished notes, Madrid, 31 May 2019, section 3.2.
    """
    if not 0 < h <= length or steps < 2:
        raise UsageError(f"the deck needs 0 < h <= L and at least two steps, not h={h!r}, L={length!r} and {steps!r} steps")
    material = LinearElastic(youngs_modulus, density)
    c = material.wave_speed
    start = EndHat(h)
    return VerificationProblem(
        problem=Problem(
            name=f"deck-{round(length / h)}",
            lower=(0.0,),
            upper=(length,),
            material=material,
            boundary={"x-": Traction(Constant(0.0)), "x+": Velocity(Constant(0.0))},
            end_time=(steps - 1) * h / c,
            initial={"velocity": start},
            outputs=steps - 1,
        ),
        exact=ExactSolution(
            fields={
                "stress": HatWave(length, h, c, start.amplitude, -1.0, density * c),
                "velocity": HatWave(length, h, c, start.amplitude, 1.0),
            },
            citation=CITATION,
            derivatives=2.0,
        ),
        exposes="Any departure from exact translation at a unit Courant number, and the reflections at a free and a fixed end.",
        equations=(
            r"\rho\, \partial_t v = \partial_x \sigma, \quad \partial_t \sigma = E\, \partial_x v",
            r"v(x,0) = -\max\left(0, 1-\frac{x}{h}\right), \quad \sigma(x,0) = 0",
            r"\sigma(0,t) = 0, \quad v(L,t) = 0",
            r"v = \frac{1}{2}\left[V(x+ct)+V(x-ct)\right], \quad \sigma = \frac{\rho c}{2}\left[V(x+ct)-V(x-ct)\right]",
            r"V(s) = \sum_{n} (-1)^{n+1} \max\left(0, 1-\frac{|s-2nL|}{h}\right), \quad c = \sqrt{E/\rho}",
        ),
    )

"""Free block that is pushed or pulled on one side along each axis: plane waves that do not meet, and momentum p A t^2/(2 T)."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.elastic_bar import CITATION, Integral, RampLoad
from mpmverify.exact.open_bar import LeftgoingWave
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Block, Bodies, BoundaryCondition, NeoHookean, Periodic, Problem, Traction
from mpmverify.problem.quantities import SYMMETRIC

Arrangement = Literal["corner", "joined", "pair"]
LOADED = ("x+", "y-", "z+")
"""Faces of the box that load a side of the block."""
STRAINS = (-4e-7, 2e-7, 2.5e-7)
"""Tractions at the final time, as shares of E: so small that the closed form of small strain is exact for every feasible mesh.

They give momenta of different size along every axis.
"""


@dataclass(frozen=True)
class WavesFromSides:
    """One field of a plane wave along each axis: (P, dim) [m], (T,) [s] -> (T, P, components).

    Parameters
    ----------
    quantity : {"displacement", "velocity", "stress"}
    loads : tuple of RampLoad
        Traction on the loaded side across each axis.
    sides : tuple of float
        Places of these sides on their axes [m].
    material : NeoHookean
        Material with nu = 0.
    """

    quantity: str
    loads: tuple[RampLoad, ...]
    sides: tuple[float, ...]
    material: NeoHookean

    def __call__(self, X: Array, t: Array) -> Array:
        c, dimension = self.material.wave_speed, X.shape[1]
        values = np.zeros((len(t), len(X), dimension if self.quantity != "stress" else len(SYMMETRIC[dimension])))
        for k, (load, side, face) in enumerate(zip(self.loads, self.sides, LOADED, strict=False)):
            normal = 1.0 if face[1] == "+" else -1.0
            emitted = Integral(load) if self.quantity == "displacement" else load
            scale = 1.0 if self.quantity == "stress" else normal / (self.material.density * c)
            values[..., k] = LeftgoingWave(emitted, 0.0, c, scale)(-np.abs(X[:, k : k + 1] - side), t)[..., 0]
        return values


@dataclass(frozen=True)
class MomentumOfLoads:
    """Momentum n A int p dt along each axis: times (T,) [s] -> (T, dim) [kg m^(dim - 2)/s].

    Parameters
    ----------
    loads : tuple of RampLoad
        Traction p across each axis.
    areas : tuple of float
        Signed area n A of the loaded sides across each axis [m^(dim - 1)]; 0 where there is no load.
    """

    loads: tuple[RampLoad, ...]
    areas: tuple[float, ...]

    def __call__(self, t: Array) -> Array:
        values = np.zeros((len(t), len(self.areas)))
        for k, load in enumerate(self.loads):
            values[:, k] = self.areas[k] * load.integral(t)
        return values


def pushed_block(
    dimension: int = 2,
    arrangement: Arrangement = "corner",
    *,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    outputs: int = 16,
) -> VerificationProblem:
    """Free block in a corner of a larger box, with a traction that rises in proportion to time on one side across each axis.

    Parameters
    ----------
    dimension : {2, 3}
    arrangement : {"corner", "joined", "pair"}
        In place of the block in a corner, one that spans the last axis, whose ends are joined, or two blocks apart from each other along
        the last axis. No load acts along the last axis of these two.
    youngs_modulus, density : float
        E [Pa], rho [kg/m^3]; nu = 0.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3, or the arrangement is unknown.

    Notes
    -----
    Each loaded side is a part of a face of the box: the load acts on the side, not on the face. With nu = 0 the waves from the sides
    do not interact, and until the first one has crossed the block, at the final time, none is reflected. The trapezoidal rule in time
    is exact for the load, so that a scheme with the leapfrog's impulse has the exact momentum after every step.
    """
    if dimension not in (2, 3):
        raise UsageError(f"the pushed block has 2 or 3 dimensions, not {dimension!r}")
    if arrangement not in get_args(Arrangement):
        raise UsageError(f"the pushed block is arranged as {', '.join(get_args(Arrangement))}, not {arrangement!r}")
    material = NeoHookean(youngs_modulus, density)
    lower, upper = (0.5, 0.0, 0.25)[:dimension], (1.5, 0.75, 1.0)[:dimension]
    box = (1.5, 1.0, 1.0)[:dimension]
    spans = {"corner": ((lower[-1], upper[-1]),), "joined": ((0.0, box[-1]),), "pair": ((0.0, 0.25), (0.5, box[-1]))}[
        arrangement
    ]
    blocks = tuple(Block((*lower[:-1], start), (*upper[:-1], end)) for start, end in spans)
    pushed = dimension - (arrangement != "corner")
    lengths = np.array([*np.subtract(upper, lower)[:-1], sum(end - start for start, end in spans)])
    end_time = 0.9 * float(lengths[:pushed].min()) / material.wave_speed
    faces = LOADED[:pushed]
    loads = tuple(RampLoad(strain * youngs_modulus, end_time) for strain in STRAINS[:pushed])
    sides = tuple(upper[k] if face[1] == "+" else lower[k] for k, face in enumerate(faces))
    areas = [float((1 if face[1] == "+" else -1) * lengths.prod() / lengths[k]) for k, face in enumerate(faces)]
    areas += [0.0] * (dimension - pushed)
    free: dict[str, BoundaryCondition] = {axis + side: Traction() for axis in "xyz"[:dimension] for side in "-+"}
    if arrangement == "joined":
        free |= {"xyz"[dimension - 1] + side: Periodic() for side in "-+"}
    return VerificationProblem(
        problem=Problem(
            name=f"pushed-block-{dimension}d" + ("" if arrangement == "corner" else f"-{arrangement}"),
            lower=(0.0,) * dimension,
            upper=box,
            material=material,
            boundary=free | {face: Traction(load) for face, load in zip(faces, loads, strict=True)},
            end_time=end_time,
            outputs=outputs,
            shape=blocks[0] if len(blocks) == 1 else Bodies(blocks),
        ),
        exact=ExactSolution(
            fields={
                quantity: WavesFromSides(quantity, loads, sides, material)
                for quantity in ("displacement", "velocity", "stress")
            },
            citation=CITATION,
            derivatives=RampLoad.derivatives,
            totals={"momentum": MomentumOfLoads(loads, tuple(areas))},
        ),
        exposes="A traction on a part of a face: its area, sign and direction, and free sides inside the box.",
        equations=(
            r"\rho\, \partial_t v = \nabla \cdot \sigma, \quad \sigma = E\, \varepsilon, \quad u(x,0) = v(x,0) = 0",
            r"\sigma n = p_i(t)\, n \text{ on one side across each axis } i, \quad p_i = \frac{t}{T} p_{0,i}, \quad "
            r"\sigma n = 0 \text{ on the others}",
            r"\sigma_{ii} = p_i\left(t - \frac{d_i}{c}\right), \quad \rho c\, v_i = n_i \sigma_{ii}, \quad u_i = \int_0^t v_i\, ds, "
            r"\quad c = \sqrt{E/\rho}, \quad d_i \text{ the distance from the side}",
            r"\int \rho v_i\, dV = n_i A_i\, p_{0,i} \frac{t^2}{2T}",
        ),
    )

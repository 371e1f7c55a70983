"""Initial-boundary-value problems and their discretisation: all that a solver may see.

Problems, materials, shapes, boundary conditions, quantities with their units, and discretisations belong here. Exact solutions,
norms, results and solvers do not: solvers import this package, and must not see the exact solution.
"""

from mpmverify.problem.boundary import (
    Absorbing,
    BoundaryCondition,
    Constant,
    Fixed,
    History,
    Inflow,
    Outflow,
    Periodic,
    Traction,
    Velocity,
)
from mpmverify.problem.discretisation import Discretisation, output_steps
from mpmverify.problem.material import LinearElastic, Material, NeoHookean, Transport
from mpmverify.problem.particles import GAUSS, REGULAR, Layout, offset, place_particles
from mpmverify.problem.problem import BodyForce, Field, Problem, Spatial, require, require_body
from mpmverify.problem.quantities import UNITS, Array, components
from mpmverify.problem.shapes import Block, Bodies, Disk, Ring, Shape

__all__ = [
    "GAUSS",
    "REGULAR",
    "UNITS",
    "Absorbing",
    "Array",
    "Block",
    "Bodies",
    "BodyForce",
    "BoundaryCondition",
    "Constant",
    "Discretisation",
    "Disk",
    "Field",
    "Fixed",
    "History",
    "Inflow",
    "Layout",
    "LinearElastic",
    "Material",
    "NeoHookean",
    "Outflow",
    "Periodic",
    "Problem",
    "Ring",
    "Shape",
    "Spatial",
    "Traction",
    "Transport",
    "Velocity",
    "components",
    "offset",
    "output_steps",
    "place_particles",
    "require",
    "require_body",
]

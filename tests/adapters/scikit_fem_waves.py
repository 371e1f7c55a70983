"""Elastodynamics with scikit-fem, as its documentation assembles linear elasticity, for the bench of mpmverify."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementLineP1,
    ElementQuad1,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    LinearForm,
    MeshLine,
    MeshQuad,
    MeshTri,
)
from skfem.helpers import ddot, dot, sym_grad
from skfem.models.elasticity import linear_elasticity, linear_stress

from mpmverify.problem import Array, Discretisation, Fixed, LinearElastic, Problem, Traction, Velocity, output_steps, require
from mpmverify.solution import Solution, Work

ELEMENTS = {
    "line": (1, 1, MeshLine, ElementLineP1),
    "P1": (2, 1, MeshTri.init_tensor, ElementTriP1),
    "P2": (2, 2, MeshTri.init_tensor, ElementTriP2),
    "Q1": (2, 1, MeshQuad.init_tensor, ElementQuad1),
}
"""Dimension, degree, mesh of a box and element by name."""


@dataclass(frozen=True)
class ScikitFem:
    """Newmark's rule with gamma = 1/2 for a linear elastic body that fills its box.

    Parameters
    ----------
    element : {"line", "P1", "P2", "Q1"}
        Bars, triangles of degree 1 or 2, or bilinear quadrilaterals.
    lumped : bool
        Lumped mass and beta = 0, which is central differences; or consistent mass and beta = 1/4, the average acceleration.
    projected : bool
        Whether the initial displacement is the elliptic projection, which has the given initial stress, or interpolated at the nodes.
    """

    element: str = "P1"
    lumped: bool = True
    projected: bool = False
    conserves: ClassVar[frozenset[str]] = frozenset({"mass", "momentum"})

    @property
    def name(self) -> str:
        return f"scikit-fem-{self.element}-{'lumped' if self.lumped else 'consistent'}{'-projected' * self.projected}"

    @property
    def orders(self) -> Mapping[str, float]:
        """In space p + 1 and, for the stress, p; in time 2."""
        return {"displacement": 2, "velocity": 2, "stress": ELEMENTS[self.element][1]}

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        law, (dimension, _, make_mesh, element) = problem.material, ELEMENTS[self.element]
        suits = type(law) is LinearElastic and not problem.body_force and not problem.shape and problem.dimension == dimension
        held = {face: condition for face, condition in problem.boundary.items() if condition != Traction()}
        suits &= all(condition in (Fixed(), Velocity()) for condition in held.values())
        require(
            suits,
            self.name,
            problem,
            f"linear elastic boxes in {dimension}D with faces that are held or free, without a body force",
        )

        cells, (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
        mesh = make_mesh(*(np.linspace(a, b, n + 1) for a, b, n in zip(problem.lower, problem.upper, cells, strict=True)))
        basis = Basis(mesh, ElementVector(element(), dimension))
        K = linear_elasticity(law.lame_lambda, law.shear_modulus).assemble(basis)
        M = BilinearForm(lambda u, v, w: law.density * dot(u, v)).assemble(basis)
        if self.lumped:
            M = diags_array(np.ravel(M.sum(axis=1))).tocsc()

        component = basis.split_indices()  # degrees of freedom of each component
        fixed = np.zeros(0, dtype=int)
        for face, condition in held.items():
            axis = "xyz".index(face[0])
            end = (problem.lower if face[1] == "-" else problem.upper)[axis]
            here = basis.get_dofs(mesh.facets_satisfying(lambda x, i=axis, end=end: np.isclose(x[i], end))).all()
            fixed = np.union1d(fixed, here if condition == Fixed() else np.intersect1d(here, component[axis]))
        free = basis.complement_dofs(fixed)

        def nodal(quantity: str) -> Array:
            values = np.zeros(basis.N)
            for i, dofs in enumerate(component):
                values[dofs] = problem.initial_field(quantity, basis.doflocs[:, dofs].T)[:, i]
            values[fixed] = 0
            return values

        beta = 0 if self.lumped else 0.25
        starting, stepping = (splu(A[free][:, free].tocsc()) for A in (M, M + beta * dt**2 * K))
        X = _flat(basis.global_coordinates())
        u, v, a = nodal("displacement"), nodal("velocity"), np.zeros(basis.N)
        if self.projected:
            xx, yy, xy = problem.initial_field("stress", X).T.reshape(3, *basis.dx.shape)
            given = LinearForm(lambda v, w: ddot(np.array([[xx, xy], [xy, yy]]), sym_grad(v))).assemble(basis)
            u[free] = splu(K[free][:, free].tocsc()).solve(given[free])
        a[free] = starting.solve(-(K @ u)[free])
        shown, saved, histories = output_steps(steps, problem.outputs), [], []
        impulse, force, mass = np.zeros(dimension), np.zeros(dimension), M.sum() / dimension
        reacting = [np.intersect1d(fixed, dofs) for dofs in component]
        for n in range(steps + 1):
            if n:
                u, v = u + dt * v + (0.5 - beta) * dt**2 * a, v + dt / 2 * a
                a = np.zeros(basis.N)
                a[free] = stepping.solve(-(K @ u)[free])
                u, v = u + beta * dt**2 * a, v + dt / 2 * a
            reaction, momentum, before = M @ a + K @ u, M @ v, force
            force = np.array([reaction[dofs].sum() for dofs in reacting])
            impulse = impulse + (dt / 2 * (before + force) if n else 0)
            histories.append((mass, *(momentum[dofs].sum() for dofs in component), *impulse))
            if n in shown:
                saved.append((u, v))

        axes = ("",) if dimension == 1 else ("_x", "_y")
        names = ("mass", *("momentum" + i for i in axes), *("impulse" + i for i in axes))
        fields = _at_quadrature_points(basis, linear_stress(law.lame_lambda, law.shear_modulus), saved)
        weight = np.tile(basis.dx.ravel(), (len(shown), 1))
        return Solution(
            time=dt * shown,
            dt=dt,
            reference=X,
            position=X + fields["displacement"],
            weight=weight,
            fields=fields,
            histories={"time": dt * np.arange(steps + 1), **dict(zip(names, np.transpose(histories), strict=True))},
            work=Work(steps, steps * mesh.nelements),
        )


def _flat(values: Array) -> Array:
    """Return values (components, elements, quadrature points) as (points, components)."""
    return np.asarray(values).reshape(len(values), -1).T


def _at_quadrature_points(basis: Basis, stress, saved: list[tuple[Array, Array]]) -> dict[str, Array]:
    fields: dict[str, list[Array]] = {"displacement": [], "velocity": [], "stress": []}
    for u, v in saved:
        moved = basis.interpolate(u)
        s = stress(sym_grad(moved))
        fields["displacement"].append(_flat(moved))
        fields["velocity"].append(_flat(basis.interpolate(v)))
        fields["stress"].append(_flat(s[0] if len(s) == 1 else np.stack([s[0, 0], s[1, 1], s[0, 1]])))
    return {quantity: np.stack(values) for quantity, values in fields.items()}

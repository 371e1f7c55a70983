"""Problems that the material point method accepts."""

from mpmverify.problem import Fixed, Periodic, Problem, Traction, Velocity, require
from mpmverify.problem.material import PlaneStress

from .constitution import LAWS


def check(problem: Problem, name: str, fitted: bool) -> None:
    """Refuse a problem that a solver cannot take; `name` is the solver's, `fitted` whether its basis fits fields in the cells.

    Raises
    ------
    UsageError
        If the material has no law in `constitution.LAWS`, the initial state is given in part, a face is not held, loaded or periodic,
        or the body has a shape and the basis fits fields, which would treat the partly filled cells at its surface as full.
    """
    require(type(problem.material) in LAWS, name, problem, "elastic and viscoelastic bodies")
    conditions = problem.boundary.values()
    taken = all(isinstance(condition, Velocity | Fixed | Traction | Periodic) for condition in conditions)
    require(taken, name, problem, "prescribed velocities, tractions and joined ends as boundary conditions")
    joined = [isinstance(condition, Periodic) for _, condition in sorted(problem.boundary.items())]
    require(joined[::2] == joined[1::2], name, problem, "axes of which both ends are joined or neither")
    require(not fitted or problem.shape is None, name, problem, "bodies that fill the cells of their box")
    loaded = [face for face, c in problem.boundary.items() if isinstance(c, Traction) and c != Traction()]
    require(all(map(problem.touched, loaded)), name, problem, "no traction on faces that no side of a body lies against")
    flat = problem.dimension == 2 or not isinstance(problem.material, PlaneStress)
    require(flat, name, problem, "plane stress in two dimensions")
    state = {"displacement", "displacement_gradient", "stress"}
    given = state & problem.initial.keys()
    require(
        given in (set(), state),
        name,
        problem,
        f"bodies that begin undeformed, or with all of {', '.join(sorted(state))}",
    )

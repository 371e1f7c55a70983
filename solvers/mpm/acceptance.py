"""Problems that the material point method accepts."""

from mpmverify.problem import Problem, require, require_body
from mpmverify.problem.material import PlaneStress

from .constitution import LAWS


def check(problem: Problem, name: str, fitted: bool) -> None:
    """Refuse a problem that a solver cannot take; `name` is the solver's, `fitted` whether its basis fits fields in the cells.

    Raises
    ------
    UsageError
        If the material has no law in `constitution.LAWS`, `require_body` refuses the faces or the initial state, or the body has a shape
        and the basis fits fields, which would treat the partly filled cells at its surface as full.
    """
    require(type(problem.material) in LAWS, name, problem, "elastic and viscoelastic bodies")
    require_body(name, problem)
    require(not fitted or problem.shape is None, name, problem, "bodies that fill the cells of their box")
    flat = problem.dimension == 2 or not isinstance(problem.material, PlaneStress)
    require(flat, name, problem, "plane stress in two dimensions")

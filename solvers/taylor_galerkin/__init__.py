"""Two-step Taylor-Galerkin method in one dimension: the solver and its compiled time loop."""

from .solver import TaylorGalerkin

__all__ = ["TaylorGalerkin"]

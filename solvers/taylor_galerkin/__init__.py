"""Two-step Taylor-Galerkin."""

from .solver import TaylorGalerkin

__all__ = ["TaylorGalerkin"]

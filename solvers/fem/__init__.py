"""Finite element reference built on scikit-fem; it shares no kernel with the other solvers."""

from .solver import FiniteElement

__all__ = ["FiniteElement"]

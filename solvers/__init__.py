"""Compact reference solvers: explicit MPM, two-step Taylor-Galerkin, and FEM on scikit-fem as the independent oracle.

Beside them, the tracing compiler that MPM alone is built on.
"""

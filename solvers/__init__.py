"""Compact reference solvers: explicit MPM, two-step Taylor-Galerkin, and FEM on scikit-fem as the independent oracle.

Here belong schemes, one package a family, and the tracing compiler of the material point method. A solver sees the problem, the
solution and the errors of a user alone: exact solutions, studies, norms and files do not belong here.
"""

"""Adapters: wrappers that give another solver, or a code outside this package, the protocol of a `Solver`.

What runs, measures or translates for a solver that is not written for this package belongs here. The shipped schemes do not: they are
in `mpmverify.solvers`.
"""

"""Adapters: wrappers that give another solver or an external code the protocol of a `Solver`.

The shipped schemes are in `mpmverify.solvers`.
"""

"""Adapters: wrappers that give another solver, or a code outside this package, the protocol of a `Solver`.

What runs a code, reads its files or searches on its behalf (`bisection`: its largest stable time step) belongs here. The shipped
schemes do not: they are in `mpmverify.solvers`.
"""

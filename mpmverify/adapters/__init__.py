"""Own code on the bench: what makes a solver of something else.

Here belong wrappers that keep the protocol of a `Solver` around another solver or another code. Shipped schemes do not: they are in
`mpmverify.solvers`.
"""

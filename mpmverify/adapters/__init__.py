"""Own code on the bench: a solver or a study by its name, a program in any language by files, results that are already there.

What runs a code, writes problems for it, reads its results, looks for its mistakes (`check`) or searches on its behalf (`bisection`: its
largest stable time step) belongs here; so does the check of a closed form of one's own. The shipped schemes do not: they are in
`mpmverify.solvers`.
"""

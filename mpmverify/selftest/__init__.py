"""The self-test: faults planted in copies of the shipped solvers, which the studies must catch.

Here belong the faults, named and by rule, the faulty copies of the solvers, and the trials that judge them. Tests of the harness
itself do not: they are in `tests/`.
"""

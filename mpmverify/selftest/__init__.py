"""The self-test of the bench: faults planted in copies of the shipped solvers, which the studies must catch.

Here belong the faults, named and by rule, the copies that hold them, and the trials that judge them. Tests of the harness do not:
they are in `tests/`.
"""

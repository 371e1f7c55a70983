"""Declarations of a study as values: its cases, each with a verification problem, and series of a solver on a refinement with criteria.

What a study says belongs here, and the ladders and designs that it refines by. Its problems are defined in `exact`, what it may demand in
`criteria`; running and judging it does not belong here.
"""

from mpmverify.study.declaration import Case, Series, Study
from mpmverify.study.refinement import Refinement, design, halving, in_particles, in_time, ladder_label

__all__ = ["Case", "Refinement", "Series", "Study", "design", "halving", "in_particles", "in_time", "ladder_label"]

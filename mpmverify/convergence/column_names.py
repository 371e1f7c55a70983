"""What a column holds, by its name: a size, a count, a rate, a time, or else an error."""

import re
from enum import StrEnum


class Role(StrEnum):
    """What a column may hold."""

    SPACE = "cell size"
    TIME_STEP = "time step"
    PARTICLES = "particles per cell"
    STEPS = "number of time steps"
    DIRECTION = "cells along an edge"
    CELLS = "number of cells"
    DOFS = "number of degrees of freedom"
    LEVEL = "level of refinement"
    VARIANT = "degree, case or method"
    RATE = "rate"
    OTHER = "neither size nor error"
    ERROR = "error"


SIZES = (Role.SPACE, Role.TIME_STEP, Role.PARTICLES, Role.DIRECTION, Role.STEPS)
"""Roles that give a size by themselves: h, dt, 1/ppc, 1/nx and 1/steps."""
COUNTS = (Role.CELLS, Role.DOFS, Role.LEVEL)
"""Roles that give a size with the dimension, or with the ratio of levels."""
NAMES: dict[Role, str] = {
    Role.SPACE: r"h|h(max|min|mean|avg|k|e|x|y)|(max|min|mean)h|d(elta)?[xyzr]"
    r"|(mesh|grid|cell|element|elem|edge|zone)?(size|spacing|width|diameter|length)(h|dx)?|(mesh|grid)h|cellwidth",
    Role.TIME_STEP: r"d(elta)?t|tau|τ|time(step)?size|(time)?step(size|length|width)?|timesteps?(size|length)",
    Role.PARTICLES: r"1?ppc|mppc|(particles|points|materialpoints)percell|particlesperelement",
    Role.DIRECTION: r"n[xyz]|(cells|elements|elems|points|nodes|intervals)(per|along|in)?(each|a)?(side|edge|direction|dimension|axis|x)"
    r"|1(h|dx)|(h|dx)inv|inv(erse)?h",
    Role.STEPS: r"(time)?steps|nt",
    Role.CELLS: r"n|(cell|element|elem|elt|el|triangle|quad|zone|volume|interval)s?|tets|tetrahedra|hexes|grid|mesh|resolution",
    Role.DOFS: r"dofs?|degreesoffreedom|unknowns?|nodes|vertices|(grid|mesh|material)?(points|pts)|particles|equations",
    Role.LEVEL: r"(refinement|mesh|grid|ref)?(levels?|lvl|lev|cycle)|refinements?|refs?",
    Role.RATE: r"r|o(1|2|inf)|p(obs|hat)",
    Role.OTHER: r"t|s",
    Role.VARIANT: r"case|test|example|variant|method|scheme|cfl|courant|p|k|q|deg(ree)?|poly(nomial)?deg(ree)?|(degree|order)[pkq]",
}
"""Whole names without blanks, and of counts without "number of" and the like."""
COUNTED = frozenset({"number", "of", "num", "no", "nb", "n", "total", "active", "global", "free"})
"""Words before a count that say nothing more."""
POWER = re.compile(r"(O\()?(h|dx|dt|Δx|Δt)\^\d+\)?|O\(\w+\)")
"""A column of a power of the size, to compare with."""
RATES = re.compile("(conv)?rates?|orders?|ord|obs(erved)?|eoc.*|oc|ro?c|ooc|slopes?|conv|ratios?|reduction|quotient|log")
"""A word in the name of a column of rates."""
ERRORS = re.compile(".*err(ors?)?")
OTHERS = re.compile(
    "cells|elem(ent)?s|n?dofs|nodes|vertices|faces|edges|particles|unknowns|"
    "times?|sec(ond)?s?|cpu|wall(time)?|runtime|clock|hours|minutes|ms|iter(ation)?s?|its?|nits?|niter|newton|mem(ory)?|[mg]b|flops"
    "|cost|cond(ition)?|seeds?|samples?|replicates?|run|id|index|cores|procs|ranks|threads"
)
"""A word in the name of a column that holds neither sizes nor errors."""


def role(name: str) -> Role:
    """Role of a column by its name; ERROR where no other is known."""
    if POWER.fullmatch(name):
        return Role.OTHER
    bare = re.sub(r"\[[^\]]*\]|\([^)]*\)", lambda unit: " " if unit.start() else unit[0], name)
    split = re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", " ", bare).lower()
    words = re.findall(r"[^\W\d_]+|\d+", re.sub(r"[Δ∆δ]\s*", "d", split).replace("^-1", "inv"))
    known = ("".join(words), re.sub("^n", "", "".join(words)), "".join(word for word in words if word not in COUNTED))
    for kind, pattern in NAMES.items():
        counts = kind in (*COUNTS, Role.DIRECTION, Role.STEPS)
        if any(re.fullmatch(pattern, whole) for whole in (known if counts else known[:1])):
            return kind
    for kind, word_of_it in ((Role.RATE, RATES), (Role.ERROR, ERRORS), (Role.OTHER, OTHERS)):
        if any(word_of_it.fullmatch(word) for word in words):
            return kind
    return Role.ERROR

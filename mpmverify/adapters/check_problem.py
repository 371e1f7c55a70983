"""Whether a closed form solves its problem: a wrong one would let a wrong solver pass.

Derivatives are central differences of fourth order, so that nothing is shared with the way in which a closed form was derived.
"""

import math
from collections.abc import Iterator

import numpy as np

from mpmverify.adapters.mistakes import Remark
from mpmverify.adapters.probe import Probe, elastic_stress
from mpmverify.exact import VerificationProblem
from mpmverify.exact.finite_strain import KIRCHHOFF, cauchy_stress
from mpmverify.problem import (
    Absorbing,
    Array,
    Block,
    Disk,
    Fixed,
    Inflow,
    LinearElastic,
    Outflow,
    Periodic,
    Ring,
    Spatial,
    Traction,
    Transport,
    Velocity,
    components,
)
from mpmverify.problem.material import KelvinVoigt, Maxwell

TOLERANCE = 1e-5
"""Largest defect of an equation, relative to the largest of its terms."""
POINTS, TIMES = 200, 7
STEPS = (2e-4, 2e-5)
"""Steps of the differences, as shares of the box and of the final time; of the two defects the smaller one counts."""
ROUGH = 0.2
"""Share of points that may lie where a solution with a kink or a jump has no derivative."""


Equation = tuple[str, Array, tuple[Array, ...]]
"""What should hold, its defect (T, P, ...), and the terms by whose size the defect is judged."""


def check_problem(problem: VerificationProblem, seed: int = 1) -> list[Remark]:
    """Say which equations the closed form of a problem does not solve.

    Parameters
    ----------
    problem : VerificationProblem
    seed : int
        Of the random points and times.

    Returns
    -------
    list of Remark
        Empty when every equation holds to `TOLERANCE`. What the problem gives no field for is not looked at.
    """
    random = np.random.default_rng(seed)
    statement = problem.problem
    X = _inside(problem, random)
    t = np.sort(random.uniform(0.02, 0.98, TIMES)) * statement.end_time
    remarks = []
    for quantity, exact in problem.exact.fields.items():
        values = exact(X, t)
        shape = (len(t), len(X), len(components(quantity, statement.dimension)))
        if values.shape != shape:
            return [Remark(f"the {quantity} has the shape {values.shape}, expected {shape}", "(T, P, components)")]
        if not np.isfinite(values).all():
            return [Remark(f"the {quantity} is not finite everywhere in the body")]
        if statement.initial_field(quantity, X).shape != shape[1:]:
            return [Remark(f"the initial {quantity} has another shape than {shape[1:]}")]
    smooth = math.isinf(problem.exact.derivatives)
    coarse, fine = (list(_conditions(Probe(problem, X, t, step), np.random.default_rng(seed))) for step in STEPS)
    for (what, one, terms), (_, other, _) in zip(coarse, fine, strict=True):
        defect = np.minimum(np.abs(one), np.abs(other))
        scale = max([float(np.max(np.abs(term), initial=0.0)) for term in terms], default=0.0)
        if not defect.size:
            continue
        wrong = defect > TOLERANCE * scale
        if np.mean(wrong) > (0 if smooth else ROUGH):
            worst = float(np.max(defect)) / scale if scale else math.inf
            remarks.append(Remark(f"{what} does not hold: it is off by up to {worst:.2g} of its largest term"))
    return remarks


def _conditions(probe: Probe, random: np.random.Generator) -> Iterator[Equation]:
    yield from _initial(probe)
    yield from _equations(probe)
    yield from _faces(probe, random)
    yield from _surfaces(probe, random)


def _inside(problem: VerificationProblem, random: np.random.Generator) -> Array:
    """Random points of the body, so far from its surface that differences stay inside."""
    statement = problem.problem
    margin = 3 * max(STEPS)
    found = np.zeros((0, statement.dimension))
    while len(found) < POINTS:
        share = random.uniform(margin, 1 - margin, (4 * POINTS, statement.dimension))
        X = np.array(statement.lower) + share * statement.lengths
        if statement.shape is not None:
            around = [
                X,
                *(
                    X + sign * margin * length * e
                    for e, length in zip(np.eye(statement.dimension), statement.lengths, strict=True)
                    for sign in (-1, 1)
                ),
            ]
            X = X[np.any([np.all([body.contains(x) for x in around], axis=0) for body in statement.shape.bodies], axis=0)]
        found = np.concatenate([found, X])
    return found[:POINTS]


def _initial(probe: Probe) -> Iterator[Equation]:
    start = np.zeros(1)
    for quantity in probe.problem.exact.fields:
        exact, given = probe.of(quantity)(probe.X, start)[0], probe.problem.problem.initial_field(quantity, probe.X)
        yield f"the initial {quantity} of the problem", exact - given, (probe.field(quantity), given)


def _equations(probe: Probe) -> Iterator[Equation]:
    statement = probe.problem.problem
    law = statement.material
    if isinstance(law, Transport):
        rate, slope = probe.rate(probe.of("u")), probe.slopes(probe.of("u"))
        carried = law.velocity * slope[..., 0]
        yield "u_t + a u_x = 0", rate + carried, (rate, carried)
        return
    if probe.has("displacement", "velocity"):
        v = probe.field("velocity")
        yield "v = du/dt", probe.rate(probe.of("displacement")) - v, (v,)
    if probe.has("displacement", "displacement_gradient"):
        H = probe.gradient(probe.X, probe.t)
        size = np.max(np.abs(probe.field("displacement"))) / max(statement.lengths)
        yield "H = du/dX", probe.slopes(probe.of("displacement")) - H, (H, size)
    if probe.has("stress") and (probe.has("displacement") or probe.has("displacement_gradient")):
        yield from _constitutive(probe, law)
    if balanced(probe.problem):

        def velocity(X: Array, t: Array) -> Array:
            return Probe(probe.problem, X, t, probe.step).rate(probe.of("displacement"))

        inertia = law.density * probe.rate(probe.of("velocity") if probe.has("velocity") else velocity)
        divergence = np.einsum("tpijj->tpi", probe.slopes(probe.stress))
        body = law.density * np.stack([_force(probe, k) for k in range(len(probe.t))])
        yield "rho dv/dt = Div P + rho b", inertia - divergence - body, (inertia, divergence, body)


def balanced(problem: VerificationProblem) -> bool:
    """Whether the fields of a body say enough to put them into the balance of momentum: a motion, and a stress or its law."""
    given, law = problem.exact.fields.keys(), problem.problem.material
    viscous = isinstance(law, KelvinVoigt | Maxwell)
    if "displacement" in given:
        return "stress" in given or not viscous
    return {"velocity", "stress"} <= given and type(law) not in KIRCHHOFF


def not_looked_at(problem: VerificationProblem) -> list[str]:
    """Say which equations cannot be looked at, because the closed form has not the fields for them."""
    given, law = problem.exact.fields.keys(), problem.problem.material
    if isinstance(law, Transport):
        return []
    missing = [] if balanced(problem) else ["the balance of momentum, which needs the displacement, or velocity and stress"]
    if "stress" in given and not {"displacement", "displacement_gradient"} & given:
        missing.append("the law of the material, which needs the displacement")
    return missing


def _force(probe: Probe, k: int) -> Array:
    statement = probe.problem.problem
    position = probe.X
    if isinstance(statement.body_force, Spatial):
        position = probe.X + probe.of("displacement")(probe.X, probe.t[[k]])[0]
    return statement.force(probe.X, position, float(probe.t[k]))


def _constitutive(probe: Probe, law: LinearElastic) -> Iterator[Equation]:
    sigma, H = probe.field("stress"), probe.gradient(probe.X, probe.t)
    least = law.youngs_modulus * np.maximum(np.abs(H), 1e-6)  # of a rigid motion the stress is round-off
    if type(law) in KIRCHHOFF:
        yield "the stress of the material", sigma - cauchy_stress(law, H), (sigma, least)
        return

    def elastic(X: Array, t: Array) -> Array:
        return elastic_stress(law, probe.gradient(X, t))

    now = elastic(probe.X, probe.t)
    if isinstance(law, Maxwell):
        rate, strained = probe.rate(probe.of("stress")), probe.rate(elastic)
        yield "the stress of the material", rate - strained + sigma / law.relaxation_time, (rate, strained)
    elif isinstance(law, KelvinVoigt):
        yield "the stress of the material", now + law.retardation_time * probe.rate(elastic) - sigma, (sigma, now)
    else:
        yield "the stress of the material", now - sigma, (sigma, now, least)


def _faces(probe: Probe, random: np.random.Generator) -> Iterator[Equation]:
    """Conditions on the faces of the box, where a side of a body lies against them."""
    statement = probe.problem.problem
    for face, condition in statement.boundary.items():
        axis, outwards = "xyz".index(face[0]), 1.0 if face[1] == "+" else -1.0
        blocks = statement.touched(face)
        opposite = statement.touched(face[0] + ("-" if face[1] == "+" else "+"))
        if isinstance(condition, Periodic) and not opposite:
            continue
        if not blocks or isinstance(condition, Absorbing | Outflow):
            continue
        block: Block = blocks[0]
        X = random.uniform(block.lower, block.upper, (40, statement.dimension))
        inside = 1e-9 * statement.lengths[axis]  # a closed form of pieces may end at the face
        X[:, axis] = (statement.upper if outwards > 0 else statement.lower)[axis] - outwards * inside
        here = Probe(probe.problem, X, probe.t, probe.step)
        yield from _condition(here, condition, axis, outwards, face)


def _condition(here: Probe, condition: object, axis: int, outwards: float, face: str) -> Iterator[Equation]:
    across = [k for k in range(here.dimension) if k != axis]
    inner = Probe(here.problem, _inside(here.problem, np.random.default_rng(2)), here.t, here.step)
    if isinstance(condition, Periodic):
        other = here.X.copy()
        lower, upper = here.problem.problem.lower[axis], here.problem.problem.upper[axis]
        other[:, axis] = lower + upper - here.X[:, axis]
        for quantity in here.problem.exact.fields:
            value = here.field(quantity)
            yield (
                f"the {quantity} passes the joined ends of {face}, which",
                value - here.of(quantity)(other, here.t),
                (inner.field(quantity),),
            )
        return
    if isinstance(condition, Inflow):
        u = here.field("u")
        yield f"the inflow at {face}", u - condition.value(here.t)[:, None, None], (u, np.ones(1))
        return
    v = here.field("velocity") if here.has("velocity") else None
    sizes = () if v is None else (v, inner.field("velocity"))
    if v is not None and isinstance(condition, Velocity | Fixed):
        held = condition.value(here.t)[:, None] if isinstance(condition, Velocity) else np.zeros((1, 1))
        yield f"the velocity at {face}", v[..., axis] - held, sizes
    if v is not None and isinstance(condition, Fixed):
        yield f"the velocity along {face}", v[..., across], sizes
    if here.has("stress") and (type(here.problem.problem.material) not in KIRCHHOFF or here.has("displacement")):
        P, whole = here.stress(here.X, here.t), inner.stress(inner.X, inner.t)
        if isinstance(condition, Traction):
            yield f"the traction at {face}", P[..., axis, axis] - condition.value(here.t)[:, None], (P, whole)
        if isinstance(condition, Traction | Velocity):
            yield f"no shear traction at {face}, which", P[..., across, axis], (P, whole)


def _surfaces(probe: Probe, random: np.random.Generator) -> Iterator[Equation]:
    """Circles are free of traction."""
    statement, shape = probe.problem.problem, probe.problem.problem.shape
    if shape is None or not probe.has("stress", "displacement") or not isinstance(statement.material, LinearElastic):
        return
    for body in shape.bodies:
        if isinstance(body, Disk | Ring):
            for radius in {body.outer, body.inner} - {0.0}:
                angle = random.uniform(0, 2 * np.pi, 40)
                normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
                X = np.array(body.center) + radius * normal
                P, whole = probe.stress(X, probe.t), probe.stress(probe.X, probe.t)
                least = np.full(1, statement.material.youngs_modulus * 1e-6)
                traction = np.einsum("tpij,pj->tpi", P, normal)
                yield f"no traction at the circle of radius {radius:g}, which", traction, (P, whole, least)

"""Faults of material point codes, planted in the textbook's, by the cause that they have in common: for the signatures of a diagnosis.

They are the mistakes that an author of another code can make, each in a noun phrase that goes after "errors like these come from".
A cause has several faults where it comes in several strengths or places.
"""

import dataclasses
from collections.abc import Mapping

from mpmverify.selftest.faults import Edit, Fault

FILE = "textbook.py"
LAME, SHEAR = "law.lame_lambda", "law.shear_modulus"
STEP = '            step = dt * einsum("pwi,pwj->pij", v_I[node], dN)\n'
INCREMENT = "F + (step if total else step @ F)"
HOOKE = f"2 * {SHEAR} * strain"
NEO_HOOKEAN = f"({LAME} * np.log(J) * one + {SHEAR} * (after @ after.mT - one)) / J"
PIOLA = "J[:, None, None] * stress @ np.linalg.inv(F).mT"
INTERNAL = "V0 if total else V, P, dN"
FORCE, WEIGHTED = "problem.force(X, x, now)", 'einsum("p,pi,pw->pwi", m, '
LOAD = "heavy * grid.load(now)"
KICKS = "(dt / 2, dt) if n else (0.0, dt / 2)"
HELD = "                a_I = np.where(grid.fixed, (grid.held(v_I, after) - v_I) / leap, a_I)\n"
FIRST = "grid.held(p_I / np.maximum(m_I, TINY), before)"
AGAIN = "grid.held(nodal_momentum() / np.maximum(m_I, TINY), after)"
MOVED = "x + dt * moved"
KEPT = "v_n, stress[:, *VOIGT[d]], V))"
SLIP = "np.ix_(nodes, [k]), condition.value"
FACES = "for face, condition in sorted(problem.boundary.items(), key=lambda item: isinstance(item[1], bvp.Fixed)):\n"
STRAINED = '                if self.schedule != "USF":\n'
BEGAN = "X, V0 = time.perf_counter(), *bvp.place_particles(problem, discretisation)\n"
PLANE_STRESS = f"(2 * {LAME} * {SHEAR} / ({LAME} + 2 * {SHEAR}))"
LATE = "                J = np.linalg.det(F)\n"
STARTED = "X + u, one + H.reshape(-1, d, d), sigma, sigma"


GRADIENT = (
    Edit(FILE, "], V))", "], V, (F - one).reshape(-1, d * d)))"),
    Edit(FILE, "t, u, v, sigma, V = (np", "t, u, v, sigma, V, gradient = (np"),
    Edit(FILE, '"stress": sigma}', '"stress": sigma, "displacement_gradient": gradient}'),
)
"""Edits by which the textbook's code also returns the displacement gradient, as other codes do."""


def returning_gradient(fault: Fault) -> Fault:
    """Return a fault in the code that also returns the displacement gradient."""
    return dataclasses.replace(fault, edits=(*fault.edits, *(GRADIENT[any("(F - one)" in edit.new for edit in fault.edits) :])))


def _fault(*edits: tuple[str, str] | tuple[str, str, int]) -> Fault:
    """Return a fault of edits (old, new), or (old, new, count) where each of several occurrences is replaced."""
    planted: list[Edit] = []
    for old, new, *several in edits:
        count = several[0] if several else 1
        planted += [Edit(FILE, old, new, count - 1 - k, count - k if old not in new else count) for k in range(count)]
    return Fault("textbook", "named", "", tuple(planted))


def _constants(lame: str, shear: str) -> Fault:
    """Return a fault in both laws of stress."""
    hooke = f"stress + {LAME} *", f"stress + {lame} *"
    return _fault(hooke, (HOOKE, f"2 * {shear} * strain"), (NEO_HOOKEAN, NEO_HOOKEAN.replace(LAME, lame).replace(SHEAR, shear)))


CAUSES: Mapping[str, tuple[Fault, ...]] = {
    # stress and strain
    "a volume that does not follow the deformation": (_fault(("else J * V0, m_I", "else V0, m_I")),),
    "a Kirchhoff stress in the place of the Cauchy stress": (_fault((NEO_HOOKEAN, NEO_HOOKEAN.removesuffix(" / J"))),),
    "a strain increment without its spin part": (_fault((STEP, f"{STEP}            step = (step + step.mT) / 2\n")),),
    "a velocity gradient that is transposed": (_fault((STEP, STEP.replace("->pij", "->pji"))),),
    "a deformation gradient that is updated by addition, as if the body were not deformed": (_fault((INCREMENT, "F + step")),),
    "a deformation gradient that is updated by multiplication in the total Lagrangian formulation": (
        _fault((INCREMENT, "F + step @ F")),
    ),
    "engineering shear strains in the place of tensorial ones": (_fault((HOOKE, f"{HOOKE} * (2 - one)")),),
    "the constant lambda of plane stress in plane strain": (_constants(PLANE_STRESS, SHEAR),),
    "a stress without its volumetric part, lambda": (_constants(f"0.0 * {LAME}", SHEAR),),
    "a constant lambda that is a little wrong": (_constants(f"1.01 * {LAME}", SHEAR),),
    "a shear modulus that is a little wrong": (_constants(LAME, f"1.01 * {SHEAR}"),),
    "Young's modulus in the place of twice the shear modulus": (_constants(LAME, "law.youngs_modulus / 2"),),
    "the shear modulus in the place of twice the shear modulus": (_constants(LAME, f"0.5 * {SHEAR}"),),
    "Lame constants that are swapped": (_constants(SHEAR, LAME),),
    "a shear stress of the wrong sign in the internal force": (
        _fault((INTERNAL, INTERNAL.replace("P,", "P * (2 * one - 1),"))),
    ),
    "an initial stress whose components are in another order": (
        _fault((STARTED, STARTED.replace("sigma, sigma", "*[sigma[:, [0, 2, 1][: 2 * d - 1]] if d < 3 else sigma] * 2"))),
    ),
    "an initial deformation that is left out": (
        _fault(
            (STARTED, STARTED.replace("one + H.reshape(-1, d, d)", "one + 0 * H.reshape(-1, d, d)")),
        ),
    ),
    "a stress that is one step late in the force": (
        _fault(
            (LATE, f"{LATE}                old, new = (new if n else stress), stress\n"),
            (
                f"P = {PIOLA} if total and not hooke else stress",
                f"P = {PIOLA.replace('stress', 'old')} if total and not hooke else old",
            ),
        ),
    ),
    "the Cauchy stress in the place of the first Piola-Kirchhoff stress": (_fault((PIOLA, "stress")),),
    "an inverse deformation gradient that is not transposed in the first Piola-Kirchhoff stress": (
        _fault((PIOLA, PIOLA.removesuffix(".mT"))),
    ),
    "J - 1 in the place of its logarithm in the law of the stress": (
        _fault((NEO_HOOKEAN, NEO_HOOKEAN.replace("np.log(J)", "(J - 1)"))),
    ),
    "the right in the place of the left Cauchy-Green tensor": (
        _fault((NEO_HOOKEAN, NEO_HOOKEAN.replace("after @ after.mT", "after.mT @ after"))),
    ),
    # time
    "velocities that start with a full step in the place of half a step": (
        _fault((KICKS, KICKS.replace("0.0, dt / 2", "0.0, dt"))),
    ),
    "a body force at the time of another step": (
        _fault((FORCE, "problem.force(X, x, now + dt)")),
        _fault((FORCE, "problem.force(X, x, now + dt / 2)")),
    ),
    "a traction at the time of another step": (
        _fault((LOAD, "heavy * grid.load(now + dt)")),
        _fault((LOAD, "heavy * grid.load(now + dt / 2)")),
    ),
    "a strain increment by another time step": (_fault((STEP, STEP.replace("dt *", "1.01 * dt *"))),),
    "positions by another time step": (_fault((MOVED, MOVED.replace("dt", "1.01 * dt"))),),
    "velocities by another time step": (
        _fault((KICKS, KICKS.replace("dt) if", "1.01 * dt) if").replace("0.0, dt", "0.0, 1.01 * dt"))),
    ),
    "a strain increment by the nodal velocities before their update": (
        _fault((STRAINED, f"{STRAINED}                    v_I = v_I - leap * a_I\n")),
    ),
    "velocities that are returned half a step old": (_fault((f"x - X, {KEPT}", f"x - X, {KEPT.replace('v_n', 'v')}")),),
    # forces and loads
    "a body force that is left out": (_fault((WEIGHTED, WEIGHTED.replace("m, ", "0 * m, "))),),
    "a body force at spatial in the place of material coordinates": (_fault((FORCE, "problem.force(x, x, now)")),),
    "a body force by the volume in the place of the mass": (_fault((WEIGHTED, WEIGHTED.replace("m, ", "V0, "))),),
    "a traction on a wrong area": (
        _fault((LOAD, f"2 * {LOAD}")),
        _fault(("self.integrals(c, body.lower[c], body.upper[c])", "self.integrals(c, problem.lower[c], problem.upper[c])")),
    ),
    "a traction of the wrong sign": (_fault((LOAD, f"-{LOAD}")), _fault(("np.array(1.0 if side else -1.0)", "np.array(1.0)"))),
    "a traction that is left out": (_fault((LOAD, f"0 * {LOAD}")),),
    # faces
    "a face that holds the velocity but not the force": (_fault((HELD, "")),),
    "a face that holds the force but not the velocity": (
        _fault(
            (FIRST, FIRST.removeprefix("grid.held(").removesuffix(", before)")),
            (AGAIN, AGAIN.removeprefix("grid.held(").removesuffix(", after)")),
            (HELD, "                a_I = np.where(grid.fixed, 0.0, a_I)\n"),
        ),
    ),
    "a face that is not held": (
        _fault(
            (
                FACES,
                f'{FACES}            if face[1] == "+" and not isinstance(condition, bvp.Traction | bvp.Periodic):\n                continue\n',
            )
        ),
        _fault((FACES, f"{FACES}            if isinstance(condition, bvp.Fixed | bvp.Velocity):\n                continue\n")),
    ),
    "a clamped face that holds the normal component alone": (
        _fault(("np.ix_(nodes, self.axes), bvp.Constant()", "np.ix_(nodes, [k]), bvp.Constant()")),
    ),
    "a slip face that holds all components": (_fault((SLIP, SLIP.replace("[k]", "self.axes"))),),
    # particles and nodes
    "a mass that is wrong by the number of particles": (
        _fault(
            (
                "m, one, given, impulse, B, stress = law.density * V0",
                "m, one, given, impulse, B, stress = law.density * V0 * discretisation.ppc",
            )
        ),
    ),
    "a density that is a little wrong": (
        _fault(
            (
                "m, one, given, impulse, B, stress = law.density * V0",
                "m, one, given, impulse, B, stress = 1.01 * law.density * V0",
            )
        ),
    ),
    "velocities that are smoothed in every transfer, as by PIC": (_fault(('self.transfer == "FLIP"', "False")),),
    "particles that are moved by their own velocity": (_fault((MOVED, "x + dt * (v + leap * a)")),),
    "particles that are moved by the nodal velocity before its update": (_fault((MOVED, "x + dt * (moved - leap * a)")),),
    "particles that are shifted from the middle of their cells": (
        _fault((BEGAN, f"{BEGAN}        X = X - 0.25 * discretisation.h / discretisation.ppc\n")),
    ),
    "B-splines that are not clamped at the ends": (_fault(("knots if self.joined[k] else np.clip(knots, 0, cells)", "knots")),),
    "an affine velocity that is transposed": (_fault(('"pij,pwj->pwi", B', '"pji,pwj->pwi", B')),),
    # what is returned
    "shear stresses that are returned with the wrong sign": (
        _fault((KEPT, KEPT.replace("stress[:, *VOIGT[d]]", "(stress * (2 * one - 1))[:, *VOIGT[d]]"))),
    ),
    "stresses whose components are returned in another order": (
        _fault((KEPT, KEPT.replace("stress[:, *VOIGT[d]]", "stress[:, ::-1, ::-1][:, *VOIGT[d]]"))),
    ),
    "a momentum that is returned half a step old": (_fault(("*(m @ v_n)", "*(m @ v)")),),
    "an impulse without the reactions of held faces": (
        _fault(("                external = np.where(grid.fixed, m_I * a_I - internal, external)\n", "")),
    ),
    "an impulse that is half a step short": (_fault(("impulse + kick * external", "impulse")),),
    "a displacement gradient that is returned transposed": (_fault(("], V))", "], V, (F - one).mT.reshape(-1, d * d)))")),),
    "a mass by the current volume": (_fault(("sums = now, m_I.sum()", "sums = now, law.density * V.sum()")),),
}
"""Faults by cause."""

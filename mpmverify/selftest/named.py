"""Faults that authors of material point and wave codes really make, those of the GeHoJerez notes first.

In one dimension an engineering shear strain taken for a tensorial one shows as the doubled shear term of the modulus.
"""

from mpmverify.selftest.faults import Edit, Fault

MPM, TG, FEM = "mpm", "taylor_galerkin", "fem"
LAW, LOOP, RECORDING, TRANSFER, BASIS, SOLVER = (
    f"mpm/{name}.py" for name in ("laws", "kernels", "recording", "transfer", "basis", "solver")
)
TG_LOOP, TG_SOLVER = "taylor_galerkin/kernel.py", "taylor_galerkin/solver.py"
FEM_LOOP, FEM_SOLVER = "fem/kernel.py", "fem/solver.py"

MOMENTUM = "scatter(stencil.first, stencil.value, nodes.momentum, p, particles.mass[p] * particles.velocity[p])"
OTHER_NODE = (
    "i, amount = stencil.first[p], particles.mass[p] * particles.velocity[p]\n"
    "        nodes.momentum[i] += stencil.value[p, 1] * amount\n"
    "        nodes.momentum[i + 1] += stencil.value[p, 0] * amount\n"
    "        nodes.momentum[i + 2] += stencil.value[p, 2] * amount"
)
INTERNAL = "scatter(stencil.first, stencil.gradient, nodes.internal, p, -volume * particles.stress[p])"
SCALED = (
    "particles.stress[p] *= volume\n        scatter(stencil.first, stencil.gradient, nodes.internal, p, -particles.stress[p])"
)
VOLUME = "volume = particles.volume[p] if scheme.total else particles.volume[p] * particles.F[p]\n        scatter"
LINEAR = "return sigma + (lame + 2 * shear) * increment"
NEO_HOOKEAN = "return lame * log(F) / F + shear * (F - 1 / F)"
REACTION = "            nodes.acceleration[i] = (ends.velocity[side, n + 1] - ends.velocity[side, n]) / step\n"
ADVANCE = "        advance(scheme, particles, stencil, nodes, n, dt)\n"
REPROJECT = (
    "        if scheme.schedule == MUSL:\n"
    "            particle_momentum_to_grid(particles, stencil, nodes)\n"
    "            nodal_velocity(nodes, ends, n + 1, massless)\n"
)
UPDATE = (
    "        if scheme.schedule != USF and not update_stress(scheme, particles, stencil, nodes, dt):\n"
    "            return INVERTED, n + 1, output\n"
)
TRACTION = "force[side] = (-1, 1)[side] * condition.value(levels)"
KICKED = "kicked = particles.velocity[p] + step * gather(stencil.first, stencil.value, nodes.acceleration, p)"
CONSTANTS = "float(material.lame_lambda),\n            float(material.shear_modulus),"
SWAPPED = "float(material.shear_modulus),\n            float(material.lame_lambda),"
CONTOUR = "                    R[i, k] -= dt * contour\n"
ACCOUNT = "                    gain[n + 1, k] -= dt * contour\n"
MODULUS = "-(material.lame_lambda + 2 * material.shear_modulus)"
FEM_NEO_HOOKEAN = "return lame * ln_F / F + shear * e * (2 + e) / F,"
FIRST_KICK = "        u += moved\n        v += dt / 2 * a\n"
SECOND_KICK = "        u += beta * dt * dt * a\n        v += dt / 2 * a\n"


def _fault(family: str, name: str, *edits: tuple[str, str, str]) -> Fault:
    return Fault(family, "named", name, tuple(Edit(*edit) for edit in edits))


HISTORIC = (
    _fault(
        MPM,
        "momentum weighted by the gradient of the shape function",
        (TRANSFER, MOMENTUM, MOMENTUM.replace(".value", ".gradient")),
    ),
    _fault(MPM, "momentum weighted by the shape function of the other node", (TRANSFER, MOMENTUM, OTHER_NODE)),
    _fault(MPM, "strain increment without dt", (LOOP, "increment = dt * gather(", "increment = gather(")),
    _fault(MPM, "2 G on the engineering shear strain", (LAW, LINEAR, LINEAR.replace("2 * shear", "4 * shear"))),
    _fault(MPM, "particle stress scaled in place by m/rho", (LOOP, INTERNAL, SCALED)),
    _fault(MPM, "boundary condition on the momentum and not on the force", (LOOP, REACTION, "")),
    _fault(
        TG,
        "Gauss-point array indexed by node",
        (TG_LOOP, "= 0.5 * (U[e, k] + U[(e + 1) % nodes, k])", "= U[e, k]"),
    ),
)
"""Faults of the GeHoJerez codes."""

MATERIAL_POINT = (
    _fault(MPM, "shear modulus for twice the shear modulus", (LAW, LINEAR, LINEAR.replace("2 * shear", "shear"))),
    _fault(MPM, "modulus halved", (LAW, LINEAR, LINEAR.replace("(lame", "0.5 * (lame"))),
    _fault(MPM, "first Lame constant left out of the linear law", (LAW, LINEAR, LINEAR.replace("lame + ", ""))),
    _fault(MPM, "mu halved in the neo-Hookean law", (LAW, NEO_HOOKEAN, NEO_HOOKEAN.replace("shear", "0.5 * shear"))),
    _fault(MPM, "first Lame constant left out of the neo-Hookean law", (LAW, NEO_HOOKEAN, "return shear * (F - 1 / F)")),
    _fault(
        MPM,
        "second Piola-Kirchhoff stress for the first",
        (LAW, NEO_HOOKEAN, "return (lame * log(F) / F + shear * (F - 1 / F)) / F"),
    ),
    _fault(MPM, "lambda and mu swapped", (SOLVER, CONSTANTS, SWAPPED)),
    _fault(MPM, "sign of the internal force", (LOOP, INTERNAL, INTERNAL.replace("-volume", "volume"))),
    _fault(MPM, "density and volume not updated", (LOOP, VOLUME, "volume = particles.volume[p]\n        scatter")),
    _fault(
        MPM,
        "volume updated in the total Lagrangian formulation too",
        (LOOP, VOLUME, "volume = particles.volume[p] * particles.F[p]\n        scatter"),
    ),
    _fault(
        MPM,
        "deformation gradient updated by a sum in the updated Lagrangian formulation",
        (LOOP, "particles.F[p] * (1 + increment)", "particles.F[p] + increment"),
    ),
    _fault(
        MPM, "FLIP with the total velocity instead of its increment", (LOOP, KICKED, "kicked = particles.velocity[p] + moved")
    ),
    _fault(
        MPM,
        "FLIP and PIC swapped",
        (LOOP, "scheme.flip * kicked + (1 - scheme.flip) * moved", "(1 - scheme.flip) * kicked + scheme.flip * moved"),
    ),
    _fault(MPM, "position moved by the particle's velocity", (LOOP, "+= dt * moved", "+= dt * particles.velocity[p]")),
    _fault(
        MPM,
        "USF and USL swapped",
        (LOOP, "if scheme.schedule == USF and n > 0", "if scheme.schedule == USL and n > 0"),
        (LOOP, "if scheme.schedule != USF and not", "if scheme.schedule != USL and not"),
    ),
    _fault(MPM, "MUSL without projecting again", (LOOP, REPROJECT, "")),
    _fault(MPM, "strain increment from the velocities before the kick", (LOOP, ADVANCE + REPROJECT + UPDATE, UPDATE + ADVANCE)),
    _fault(
        MPM,
        "acceleration of the nearest node instead of the interpolated one",
        (LOOP, KICKED, "kicked = particles.velocity[p] + step * nodes.acceleration[stencil.first[p]]"),
    ),
    _fault(
        MPM,
        "body force at spatial instead of material coordinates",
        (SOLVER, "block = max(1, BLOCK // len(points)) if problem.body_force else steps + 1", "block = 1"),
        (
            SOLVER,
            "_tabulate(problem.body_force, points, times",
            "_tabulate(problem.body_force, points + (particles.displacement if len(points) == count else 0.0), times",
        ),
    ),
    _fault(MPM, "body force without the mass of the particle", (LOOP, "particles.mass[p] * body[row, p])", "body[row, p])")),
    _fault(MPM, "body force dropped", (LOOP, "particles.mass[p] * body[row, p])", "0.0 * body[row, p])")),
    _fault(MPM, "sign of the traction", (SOLVER, TRACTION, TRACTION.replace("(-1, 1)", "(1, -1)"))),
    _fault(MPM, "traction one step late", (LOOP, "+= ends.force[side, n]", "+= ends.force[side, max(n - 1, 0)]")),
    _fault(MPM, "no condition on the momentum", (LOOP, "            nodes.velocity[i] = ends.velocity[side, n]\n", "")),
    _fault(
        MPM,
        "essential conditions dropped",
        (SOLVER, "held = np.array([isinstance(condition, Velocity)", "held = np.array([False"),
    ),
    _fault(
        MPM,
        "volume of a particle that of its cell",
        (SOLVER, "volume = cells * at.ppc, at.h / at.ppc", "volume = cells * at.ppc, at.h"),
    ),
    _fault(
        MPM,
        "particles at the corners of the cell's parts",
        (SOLVER, "places = np.arange(count) + 0.5", "places = np.arange(count) + 0.25"),
    ),
    _fault(
        MPM,
        "quadratic functions not clamped at the ends",
        (BASIS, "left = 1.0 + min(cell, 1)", "left = 2.0"),
        (BASIS, "right = 1.0 + min(cells - 1 - cell, 1)", "right = 2.0"),
    ),
    _fault(MPM, "gradient by the local coordinate", (TRANSFER, "= d0 / grid.h, d1 / grid.h, d2 / grid.h", "= d0, d1, d2")),
    _fault(MPM, "nodal masses not reset", (TRANSFER, "        nodes.mass[i] = 0.0\n", "        pass\n")),
    _fault(MPM, "nodes of small mass frozen", (LOOP, "MASSLESS = 1e-12", "MASSLESS = 0.6")),
    _fault(MPM, "whole kick for the first half", (RECORDING, "else (0.0, 0.5 * dt)", "else (0.0, dt)")),
    _fault(MPM, "velocity recorded half a step early", (RECORDING, "return (0.5 * dt, dt) if", "return (0.0, dt) if")),
    _fault(MPM, "momentum that PIC loses at a held end not counted", (RECORDING, " + (1 - scheme.flip) * added", "")),
)

TAYLOR_GALERKIN = (
    _fault(TG, "dt for dt/2 in the predictor", (TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - dt * (")),
    _fault(TG, "no predictor", (TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - 0.0 * dt * (")),
    _fault(TG, "contour flux left out", (TG_LOOP, CONTOUR, "")),
    _fault(TG, "contour flux and its account left out", (TG_LOOP, CONTOUR + ACCOUNT, "                    pass\n")),
    _fault(TG, "normal of the contour reversed", (TG_LOOP, "contour = normal * dot", "contour = -normal * dot")),
    _fault(TG, "sign of the incoming characteristic", (TG_SOLVER, "nZ = normal *", "nZ = -normal *")),
    _fault(TG, "datum of the face half a step early", (TG_LOOP, "datum[face, 2 * n + 1]", "datum[face, 2 * n]")),
    _fault(TG, "one mass pass less", (TG_LOOP, "for sweep in range(passes)", "for sweep in range(max(1, passes - 1))")),
    _fault(TG, "row of the consistent mass matrix doubled", (TG_LOOP, "MdU[i, k] += h / 6 *", "MdU[i, k] += h / 3 *")),
    _fault(TG, "prescribed unknown not held in later passes", (TG_LOOP, "dU[i, k] += holds[face, k] * gap", "pass")),
    _fault(TG, "end node of full mass", (TG_SOLVER, "mass[[0, -1]] = 0.5 * h", "pass")),
    _fault(TG, "modulus halved", (TG_SOLVER, MODULUS, MODULUS.replace("-(", "-0.5 * ("))),
    _fault(
        TG, "first Lame constant left out of the modulus", (TG_SOLVER, MODULUS, MODULUS.replace("material.lame_lambda + ", ""))
    ),
    _fault(TG, "density left out of the momentum equation", (TG_SOLVER, "[-1 / rho, 0.0]", "[-1.0, 0.0]")),
    _fault(
        TG,
        "source of the corrector taken at the beginning of the step",
        (TG_LOOP, "S = load[k] * b_half[e]", "S = load[k] * b[e]"),
    ),
)

FINITE_ELEMENT = (
    _fault(FEM, "Newmark's beta 1/6", (FEM_SOLVER, '"newmark": 0.25', '"newmark": 1 / 6')),
    _fault(FEM, "sign of beta in the predictor", (FEM_LOOP, "dt * dt * (0.5 - beta) * a", "dt * dt * (0.5 + beta) * a")),
    _fault(
        FEM,
        "Newmark's gamma 0.6",
        (FEM_LOOP, FIRST_KICK, FIRST_KICK.replace("dt / 2", "0.4 * dt")),
        (FEM_LOOP, SECOND_KICK, SECOND_KICK.replace("dt / 2", "0.6 * dt")),
    ),
    _fault(FEM, "operator with beta dt K", (FEM_SOLVER, "mass + beta * dt**2 *", "mass + beta * dt *")),
    _fault(FEM, "mass lumped by the diagonal", (FEM_SOLVER, "diags_array(mass.sum(axis=1))", "diags_array(mass.diagonal())")),
    _fault(FEM, "mass without density", (FEM_SOLVER, "mass = law.density * (mass if", "mass = 1.0 * (mass if")),
    _fault(FEM, "modulus halved", (FEM_LOOP, "return (lame + 2 * shear) * e,", "return 0.5 * (lame + 2 * shear) * e,")),
    _fault(
        FEM,
        "first Lame constant left out of the linear law",
        (FEM_LOOP, "return (lame + 2 * shear) * e,", "return 2 * shear * e,"),
    ),
    _fault(
        FEM, "mu halved in the neo-Hookean law", (FEM_LOOP, FEM_NEO_HOOKEAN, FEM_NEO_HOOKEAN.replace("shear", "0.5 * shear"))
    ),
    _fault(
        FEM,
        "first Lame constant left out of the neo-Hookean law",
        (FEM_LOOP, FEM_NEO_HOOKEAN, "return shear * e * (2 + e) / F,"),
    ),
    _fault(FEM, "sign of the traction", (FEM_SOLVER, "normal * condition.value(t)", "-normal * condition.value(t)")),
    _fault(FEM, "body force dropped", (FEM_SOLVER, "(law.density * weight) @ values", "(0.0 * weight) @ values")),
    _fault(FEM, "body force without density", (FEM_SOLVER, "(law.density * weight) @ values", "weight @ values")),
    _fault(
        FEM,
        "quadrature weight left out of the internal force",
        (FEM_LOOP, "+= mesh.weight[i, q] * mesh.gradient[i, q, k] * stress", "+= mesh.gradient[i, q, k] * stress"),
    ),
    _fault(FEM, "held end kept in the factor", (FEM_SOLVER, "free[[0, -1]] = ~held", "pass")),
)

NAMED = (*HISTORIC, *MATERIAL_POINT, *TAYLOR_GALERKIN, *FINITE_ELEMENT)

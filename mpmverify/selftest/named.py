"""Faults that authors of material point and wave codes really make, those of the GeHoJerez notes first.

In one dimension an engineering shear strain taken for a tensorial one shows as the doubled shear term of the modulus.
"""

from textwrap import indent

from mpmverify.selftest.faults import Edit, Fault

MPM, TG, FEM = "mpm", "taylor_galerkin", "fem"
BASIS, FACES, GRID, HISTORIES, LAW, LAYOUT, LOOP, PASSES, SOLVER, TENSORS = (
    f"mpm/{name}.py"
    for name in ("basis", "faces", "grid", "histories", "constitution", "layout", "loop", "passes", "solver", "tensors")
)
AFFINE, DEFORMATION, HYPERELASTIC = "mpm/affine.py", "mpm/deformation.py", "mpm/hyperelastic.py"
SMALL_STRAIN, SPLINES = "mpm/small_strain.py", "mpm/splines.py"
TG_LOOP, TG_SOLVER = "taylor_galerkin/kernel.py", "taylor_galerkin/solver.py"
FEM_LOOP, FEM_SOLVER = "fem/kernel.py", "fem/solver.py"

PROJECTED = "at.spread(grid, nodes.inertia, 0, with_mass(m, v))"
PROJECTED_AGAIN = "at.spread(grid, nodes.inertia, 1, scale(m, v))"
MOMENTUM = "        " + PROJECTED_AGAIN
MASS_ALONE = "at.spread(grid, nodes.inertia, 0, (m,))\n        "
BY_GRADIENT, BY_OTHER = "at._replace(N=at.derivative).", "at._replace(N=(at.N[0][::-1],))."
LINEAR = "return shifted(lame * trace(eps), 2 * shear, eps)"
NEO_HOOKEAN = "shifted((lame * log(J) - shear) / J, shear / J, b)"
VOLUME = "where(scheme.total, V0, V0 * det(F))"
STRAINED = "strained = strain(scheme, particles, some, scale(step.dt, gradient)"
TOO_FAR = STRAINED.replace("scale(step.dt, gradient)", "gradient")
SCALED = (
    "            wrong = where(scheme.total, scale(V, sigma), scale(V * det(F), sigma))\n"
    "            store_rows(state, some.numbers, column.stress, wrong)\n"
)
KICKED = "axpy(leap, a, before), scale("
MOVED = "scale(step.dt, moved), limits))\n                with"
HELD = "        nodes.acceleration[c, i] = (faces.velocity[face, n + 1] - faces.velocity[face, n]) / leap\n"
KICK = "        nodes.velocity[c, i] = v + leap * a\n"
KEPT = "        nodes.projected[c, i] = v\n"
REPROJECT = "            nodal_velocity(zero, nodes, strips, nodes.projected, massless, 0.0, 0.0, added, 0, count)\n"
REPROJECTED = "            hold_velocity(grid, nodes, faces, n + 1, nodes.projected, added)\n"
CLEARED, KEEP_MASS = "for c in range(count):", "for c in range(count - len(zero), count):"
CONSTANTS = "float(material.lame_lambda), float(material.shear_modulus)"
SWAPPED = "float(material.shear_modulus), float(material.lame_lambda)"
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
        (PASSES, PROJECTED, MASS_ALONE + PROJECTED_AGAIN.replace("at.", BY_GRADIENT)),
        (AFFINE, MOMENTUM, MOMENTUM.replace("at.", BY_GRADIENT)),
    ),
    _fault(
        MPM,
        "momentum weighted by the shape function of the other node",
        (PASSES, PROJECTED, MASS_ALONE + PROJECTED_AGAIN.replace("at.", BY_OTHER)),
        (AFFINE, MOMENTUM, MOMENTUM.replace("at.", BY_OTHER)),
    ),
    _fault(
        MPM,
        "strain increment without dt",
        (PASSES, f"USL)):\n{20 * ' '}{STRAINED}", f"USL)):\n{20 * ' '}{TOO_FAR}"),
        (PASSES, f"limits))\n{8 * ' '}{STRAINED}", f"limits))\n{8 * ' '}{TOO_FAR}"),
    ),
    _fault(MPM, "2 G on the engineering shear strain", (SMALL_STRAIN, LINEAR, LINEAR.replace("2 * shear", "4 * shear"))),
    _fault(
        MPM,
        "particle stress scaled in place by m/rho",
        (PASSES, "zero))\n            with when((step", "zero))\n" + indent(SCALED, 4 * " ") + "            with when((step"),
        (PASSES, "F, zero))\n    return", "F, zero))\n" + SCALED + "    return"),
    ),
    _fault(MPM, "boundary condition on the momentum and not on the force", (GRID, HELD, "")),
    _fault(
        TG,
        "Gauss-point array indexed by node",
        (TG_LOOP, "= 0.5 * (U[e, k] + U[(e + 1) % nodes, k])", "= U[e, k]"),
    ),
)
"""Faults of the GeHoJerez codes."""

MATERIAL_POINT = (
    _fault(MPM, "shear modulus for twice the shear modulus", (SMALL_STRAIN, LINEAR, LINEAR.replace("2 * shear", "shear"))),
    _fault(MPM, "modulus halved", (SMALL_STRAIN, LINEAR, "return shifted(0.5 * lame * trace(eps), shear, eps)")),
    _fault(
        MPM, "first Lame constant left out of the linear law", (SMALL_STRAIN, LINEAR, "return shifted(0.0, 2 * shear, eps)")
    ),
    _fault(MPM, "mu halved in the neo-Hookean law", (HYPERELASTIC, NEO_HOOKEAN, NEO_HOOKEAN.replace("shear", "0.5 * shear"))),
    _fault(
        MPM,
        "first Lame constant left out of the neo-Hookean law",
        (HYPERELASTIC, NEO_HOOKEAN, NEO_HOOKEAN.replace("(lame * log(J) - shear)", "-shear")),
    ),
    _fault(
        MPM,
        "second Piola-Kirchhoff stress for the first, in one dimension",
        (TENSORS, "full(sigma), cofactor(F)", "full(sigma), tuple(c / F[0] for c in cofactor(F))"),
    ),
    _fault(MPM, "lambda and mu swapped", (LAW, CONSTANTS, SWAPPED)),
    _fault(
        MPM,
        "sign of the internal force",
        (DEFORMATION, "constant(-V, like)", "constant(V, like)"),
    ),
    _fault(MPM, "density and volume not updated", (DEFORMATION, VOLUME, "V0")),
    _fault(MPM, "volume updated in the total Lagrangian formulation too", (DEFORMATION, VOLUME, "V0 * det(F)")),
    _fault(
        MPM,
        "deformation gradient updated by a sum in the updated Lagrangian formulation",
        (DEFORMATION, "lambda: deform(increment, F)", "lambda: axpy(1.0, increment, F)"),
        (
            DEFORMATION,
            "F[0] * det(axpy(1.0, increment, identity(increment)))",
            "F[0] + sum(increment[:: {4: 3, 9: 4}[len(increment)]])",
        ),
    ),
    _fault(
        MPM,
        "FLIP with the total velocity instead of its increment",
        (PASSES, KICKED, KICKED.replace("axpy(leap, a, before)", "axpy(1.0, moved, before)")),
    ),
    _fault(
        MPM,
        "FLIP and PIC swapped",
        (PASSES, "v = axpy(scheme.flip, ", "v = axpy(1 - scheme.flip, "),
        (PASSES, "scale(1 - scheme.flip, moved)", "scale(scheme.flip, moved)"),
    ),
    _fault(
        MPM,
        "position moved by the particle's velocity",
        (PASSES, MOVED, MOVED.replace("moved", "v")),
        (PASSES, "nodal), at.gather(grid, nodes.velocity)", "nodal), load_rows(state, some.numbers, column.velocity, zero)"),
    ),
    _fault(
        MPM,
        "USF and USL swapped",
        (SOLVER, '"USF": passes.USF, "USL": passes.USL', '"USF": passes.USL, "USL": passes.USF'),
    ),
    _fault(
        MPM,
        "MUSL without projecting again",
        (PASSES, "where(first_of_all, nodes.velocity, nodes.projected)", "nodes.velocity"),
    ),
    _fault(
        MPM,
        "strain increment from the velocities before the kick",
        (GRID, KICK, KEPT + KICK),
        (PASSES, "gradient = at.gather_tensor(grid, nodes.velocity", "gradient = at.gather_tensor(grid, nodes.projected"),
        (LOOP, REPROJECT + REPROJECTED, ""),
    ),
    _fault(
        MPM,
        "acceleration of the nearest node instead of the interpolated one",
        (PASSES, KICKED, KICKED.replace(" a,", " (nodes.acceleration[0, at.first],),")),
    ),
    _fault(
        MPM,
        "body force at spatial instead of material coordinates",
        (
            SOLVER,
            "spatial = isinstance(problem.body_force, Spatial)",
            "spatial = bool(problem.body_force) and points is reference",
        ),
    ),
    _fault(MPM, "body force without the mass of the particle", (PASSES, "scale(m, b)", "scale(some.present, b)")),
    _fault(MPM, "body force dropped", (PASSES, "scale(m, b)", "scale(0.0, b)")),
    _fault(MPM, "sign of the traction", (FACES, "force.append(sign * values)", "force.append(-sign * values)")),
    _fault(MPM, "traction one step late", (GRID, "faces.force[face, n]", "faces.force[face, where(n > 0, n - 1, n)]")),
    _fault(MPM, "no condition on the momentum", (GRID, "        velocity[c, i] = held\n", "")),
    _fault(MPM, "essential conditions dropped", (FACES, "np.array(held, ", "np.array([], ")),
    _fault(
        MPM,
        "volume of a particle that of its cell",
        (LAYOUT, "volume = size.prod(axis=1)", "volume = (at.ppc * size).prod(axis=1)"),
    ),
    _fault(
        MPM,
        "particles at the corners of the cell's parts",
        (LAYOUT, "(np.arange(ppc) + 0.5) / ppc", "(np.arange(ppc) + 0.25) / ppc"),
    ),
    _fault(MPM, "quadratic functions not clamped at the ends", (BASIS, "np.clip(knots, 0, cells)", "knots")),
    _fault(
        MPM,
        "gradient by the local coordinate",
        (SPLINES, "(1.0 - xi, xi), (-grid.scale, grid.scale)", "(1.0 - xi, xi), (-1.0, 1.0)"),
        (SPLINES, "scale(grid.scale, axpy(xi, c2, inner))", "axpy(xi, c2, inner)"),
    ),
    _fault(MPM, "nodal masses not reset", (GRID, CLEARED, KEEP_MASS)),
    _fault(MPM, "nodes of small mass frozen", (LOOP, "MASSLESS = 1e-12", "MASSLESS = 1.2")),
    _fault(MPM, "whole kick for the first half", (GRID, "(0.0, 0.5 * dt))", "(0.0, dt))")),
    _fault(MPM, "velocity recorded half a step early", (GRID, "(0.5 * dt, dt)", "(0.0, dt)")),
    _fault(MPM, "momentum that PIC loses at a held end not counted", (HISTORIES, " + (1.0 - scheme.flip) * added[c]", "")),
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
    _fault(TG, "prescribed unknown not held in later passes", (TG_LOOP, "dU[i, k] += correction[face, k] * gap", "pass")),
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

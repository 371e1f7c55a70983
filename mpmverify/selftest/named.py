"""Named faults: errors that authors of material point and wave codes have made, those in the GeHoJerez codes first.

In one dimension, an engineering shear strain used as a tensorial one doubles the shear term of the modulus.
"""

from textwrap import indent

from mpmverify.selftest.faults import named
from mpmverify.selftest.named_in_space import IN_SPACE

MPM, TG, FEM = "mpm", "taylor_galerkin", "fem"
BASIS, FACES, GRID, HISTORIES, LAW, LOOP, PASSES, SOLVER, TENSORS = (
    f"mpm/{name}.py" for name in ("basis", "faces", "grid", "histories", "constitution", "loop", "passes", "solver", "tensors")
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
REPROJECT = "            passes.nodal_velocity(*at_nodes, nodes.projected, least, 0.0, 0.0, added, 0, count)\n"
REPROJECTED = "            hold_velocity(grid, nodes, faces, n + 1, nodes.projected, added)\n"
CLEARED, KEEP_MASS = "for c in range(count):", "for c in range(count - len(zero), count):"
CONSTANTS = "float(material.lame_lambda), float(material.shear_modulus)"
SWAPPED = "float(material.shear_modulus), float(material.lame_lambda)"
PLACED = "reference, volume = place_particles(problem, discretisation, self.layout)\n        "
CONTOUR = "                    R[i, k] -= dt * contour\n"
ACCOUNT = "                    gain[n + 1, k] -= dt * contour\n"
MODULUS = "-(material.lame_lambda + 2 * material.shear_modulus)"
FEM_NEO_HOOKEAN = "return lame * ln_F / F + shear * e * (2 + e) / F,"
FIRST_KICK = "        u += moved\n        v += dt / 2 * a\n"
SECOND_KICK = "        u += beta * dt * dt * a\n        v += dt / 2 * a\n"


HISTORIC = (
    named(
        MPM,
        "nodal momentum weighted by the gradient of the shape function",
        (PASSES, PROJECTED, MASS_ALONE + PROJECTED_AGAIN.replace("at.", BY_GRADIENT)),
        (AFFINE, MOMENTUM, MOMENTUM.replace("at.", BY_GRADIENT)),
    ),
    named(
        MPM,
        "nodal momentum weighted by the shape function of the other node",
        (PASSES, PROJECTED, MASS_ALONE + PROJECTED_AGAIN.replace("at.", BY_OTHER)),
        (AFFINE, MOMENTUM, MOMENTUM.replace("at.", BY_OTHER)),
    ),
    named(
        MPM,
        "strain increment not multiplied by the time step",
        (PASSES, f"USL)):\n{20 * ' '}{STRAINED}", f"USL)):\n{20 * ' '}{TOO_FAR}"),
        (PASSES, f"limits))\n{8 * ' '}{STRAINED}", f"limits))\n{8 * ' '}{TOO_FAR}"),
    ),
    named(
        MPM,
        "factor 2 G applied to the engineering shear strain",
        (SMALL_STRAIN, LINEAR, LINEAR.replace("2 * shear", "4 * shear")),
    ),
    named(
        MPM,
        "stored particle stress multiplied by the particle volume m/rho",
        (PASSES, "zero))\n            with when((step", "zero))\n" + indent(SCALED, 4 * " ") + "            with when((step"),
        (PASSES, "F, zero))\n    return", "F, zero))\n" + SCALED + "    return"),
    ),
    named(MPM, "essential boundary condition applied to the nodal momentum but not to the force", (GRID, HELD, "")),
    named(
        TG, "Gauss point array indexed by the node number", (TG_LOOP, "= 0.5 * (U[e, k] + U[(e + 1) % nodes, k])", "= U[e, k]")
    ),
)
"""Faults found in the GeHoJerez codes."""

MATERIAL_POINT = (
    named(
        MPM, "shear modulus instead of twice the shear modulus", (SMALL_STRAIN, LINEAR, LINEAR.replace("2 * shear", "shear"))
    ),
    named(MPM, "both Lame constants halved", (SMALL_STRAIN, LINEAR, "return shifted(0.5 * lame * trace(eps), shear, eps)")),
    named(MPM, "first Lame constant omitted, linear law", (SMALL_STRAIN, LINEAR, "return shifted(0.0, 2 * shear, eps)")),
    named(
        MPM, "shear modulus halved, neo-Hookean law", (HYPERELASTIC, NEO_HOOKEAN, NEO_HOOKEAN.replace("shear", "0.5 * shear"))
    ),
    named(
        MPM,
        "first Lame constant omitted, neo-Hookean law",
        (HYPERELASTIC, NEO_HOOKEAN, NEO_HOOKEAN.replace("(lame * log(J) - shear)", "-shear")),
    ),
    named(
        MPM,
        "second Piola-Kirchhoff stress used as the first, in one dimension",
        (TENSORS, "full(sigma), cofactor(F)", "full(sigma), tuple(c / F[0] for c in cofactor(F))"),
    ),
    named(MPM, "Lame constants lambda and mu swapped", (LAW, CONSTANTS, SWAPPED)),
    named(MPM, "sign of the internal force reversed", (DEFORMATION, "constant(-V, like)", "constant(V, like)")),
    named(MPM, "particle volume not updated in the updated Lagrangian formulation", (DEFORMATION, VOLUME, "V0")),
    named(MPM, "particle volume updated in the total Lagrangian formulation", (DEFORMATION, VOLUME, "V0 * det(F)")),
    named(
        MPM,
        "deformation gradient updated by addition instead of multiplication, updated Lagrangian",
        (DEFORMATION, "lambda: deform(increment, F)", "lambda: axpy(1.0, increment, F)"),
        (
            DEFORMATION,
            "F[0] * det(axpy(1.0, increment, identity(increment)))",
            "F[0] + sum(increment[:: {4: 3, 9: 4}[len(increment)]])",
        ),
    ),
    named(
        MPM,
        "FLIP update adds the nodal velocity instead of its increment",
        (PASSES, KICKED, KICKED.replace("axpy(leap, a, before)", "axpy(1.0, moved, before)")),
    ),
    named(
        MPM,
        "FLIP and PIC swapped",
        (PASSES, "v = axpy(scheme.flip, ", "v = axpy(1 - scheme.flip, "),
        (PASSES, "scale(1 - scheme.flip, moved)", "scale(scheme.flip, moved)"),
    ),
    named(
        MPM,
        "particle position updated with the particle velocity instead of the nodal velocity",
        (PASSES, MOVED, MOVED.replace("moved", "v")),
        (PASSES, "nodal), at.gather(grid, nodes.velocity)", "nodal), load_rows(state, some.numbers, column.velocity, zero)"),
    ),
    named(
        MPM,
        "stress-update schedules USF and USL swapped",
        (SOLVER, '"USF": passes.USF, "USL": passes.USL', '"USF": passes.USL, "USL": passes.USF'),
    ),
    named(
        MPM,
        "MUSL without the second projection of the momentum",
        (PASSES, "where(first_of_all, nodes.velocity, nodes.projected)", "nodes.velocity"),
    ),
    named(
        MPM,
        "strain increment computed from the nodal velocities before their update",
        (GRID, KICK, KEPT + KICK),
        (PASSES, "gradient = at.gather_tensor(grid, nodes.velocity", "gradient = at.gather_tensor(grid, nodes.projected"),
        (LOOP, REPROJECT + REPROJECTED, ""),
    ),
    named(
        MPM,
        "acceleration taken from one node instead of interpolated",
        (PASSES, KICKED, KICKED.replace(" a,", " (nodes.acceleration[0, at.first],),")),
    ),
    named(
        MPM,
        "body force evaluated at spatial instead of material coordinates",
        (
            SOLVER,
            "spatial = isinstance(problem.body_force, Spatial)",
            "spatial = bool(problem.body_force) and points is reference",
        ),
    ),
    named(MPM, "body force not multiplied by the particle mass", (PASSES, "scale(m, b)", "scale(some.present, b)")),
    named(MPM, "body force omitted", (PASSES, "scale(m, b)", "scale(0.0, b)")),
    named(MPM, "sign of the traction reversed", (FACES, "force.append(sign * values)", "force.append(-sign * values)")),
    named(
        MPM, "traction applied one time step late", (GRID, "faces.force[face, n]", "faces.force[face, where(n > 0, n - 1, n)]")
    ),
    named(MPM, "essential boundary condition not applied to the nodal velocity", (GRID, "        velocity[c, i] = held\n", "")),
    named(MPM, "essential boundary conditions omitted", (FACES, "np.array(held, ", "np.array([], ")),
    named(
        MPM,
        "particle volume set to the volume of its cell",
        (SOLVER, PLACED, f"{PLACED}volume *= discretisation.ppc ** problem.dimension\n        "),
    ),
    named(
        MPM,
        "particles shifted from the centres of their subcells",
        (SOLVER, PLACED, f"{PLACED}reference -= 0.25 * discretisation.h / discretisation.ppc\n        "),
    ),
    named(MPM, "knots of the quadratic B-splines not clamped at the boundary", (BASIS, "np.clip(knots, 0, cells)", "knots")),
    named(
        MPM,
        "shape function gradient taken with respect to the local coordinate",
        (SPLINES, "(1.0 - xi, xi), (-grid.scale, grid.scale)", "(1.0 - xi, xi), (-1.0, 1.0)"),
        (SPLINES, "scale(grid.scale, axpy(xi, c2, inner))", "axpy(xi, c2, inner)"),
    ),
    named(MPM, "nodal masses not reset to zero", (GRID, CLEARED, KEEP_MASS)),
    named(MPM, "nodes of small mass treated as massless", (GRID, "MASSLESS = 1e-12", "MASSLESS = 1.2")),
    named(MPM, "full velocity update instead of the initial half step", (GRID, "(0.0, 0.5 * dt))", "(0.0, dt))")),
    named(MPM, "velocity recorded half a time step early", (GRID, "(0.5 * dt, dt)", "(0.0, dt)")),
    named(
        MPM,
        "PIC momentum loss at a fixed boundary missing from the impulse",
        (HISTORIES, " + (1.0 - scheme.flip) * added[c]", ""),
    ),
)

TAYLOR_GALERKIN = (
    named(TG, "dt instead of dt/2 in the predictor", (TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - dt * (")),
    named(TG, "predictor omitted", (TG_LOOP, "return U_k - 0.5 * dt * (", "return U_k - 0.0 * dt * (")),
    named(TG, "boundary flux omitted from the update", (TG_LOOP, CONTOUR, "")),
    named(
        TG,
        "boundary flux omitted from the update and the recorded balance",
        (TG_LOOP, CONTOUR + ACCOUNT, "                    pass\n"),
    ),
    named(TG, "normal reversed in the boundary flux", (TG_LOOP, "contour = normal * dot", "contour = -normal * dot")),
    named(TG, "sign of the incoming characteristic reversed", (TG_SOLVER, "nZ = normal *", "nZ = -normal *")),
    named(TG, "boundary value taken half a time step early", (TG_LOOP, "datum[face, 2 * n + 1]", "datum[face, 2 * n]")),
    named(TG, "one mass pass too few", (TG_LOOP, "for sweep in range(passes)", "for sweep in range(max(1, passes - 1))")),
    named(
        TG, "one row of the consistent element mass matrix doubled", (TG_LOOP, "MdU[i, k] += h / 6 *", "MdU[i, k] += h / 3 *")
    ),
    named(TG, "prescribed unknown not enforced in later passes", (TG_LOOP, "dU[i, k] += correction[face, k] * gap", "pass")),
    named(TG, "full nodal mass at the end nodes", (TG_SOLVER, "mass[[0, -1]] = 0.5 * h", "pass")),
    named(TG, "P-wave modulus halved", (TG_SOLVER, MODULUS, MODULUS.replace("-(", "-0.5 * ("))),
    named(TG, "first Lame constant omitted", (TG_SOLVER, MODULUS, MODULUS.replace("material.lame_lambda + ", ""))),
    named(TG, "density omitted from the momentum equation", (TG_SOLVER, "[-1 / rho, 0.0]", "[-1.0, 0.0]")),
    named(
        TG,
        "source term of the corrector taken at the start of the step",
        (TG_LOOP, "S = load[k] * b_half[e]", "S = load[k] * b[e]"),
    ),
)

FINITE_ELEMENT = (
    named(FEM, "Newmark beta 1/6 instead of 1/4", (FEM_SOLVER, '"newmark": 0.25', '"newmark": 1 / 6')),
    named(
        FEM, "sign of beta reversed in the predictor", (FEM_LOOP, "dt * dt * (0.5 - beta) * a", "dt * dt * (0.5 + beta) * a")
    ),
    named(
        FEM,
        "Newmark gamma 0.6 instead of 1/2",
        (FEM_LOOP, FIRST_KICK, FIRST_KICK.replace("dt / 2", "0.4 * dt")),
        (FEM_LOOP, SECOND_KICK, SECOND_KICK.replace("dt / 2", "0.6 * dt")),
    ),
    named(FEM, "effective matrix with beta dt K", (FEM_SOLVER, "mass + beta * dt**2 *", "mass + beta * dt *")),
    named(FEM, "mass lumped to its diagonal", (FEM_SOLVER, "diags_array(mass.sum(axis=1))", "diags_array(mass.diagonal())")),
    named(
        FEM, "mass matrix not multiplied by the density", (FEM_SOLVER, "mass = law.density * (mass if", "mass = 1.0 * (mass if")
    ),
    named(FEM, "P-wave modulus halved", (FEM_LOOP, "return (lame + 2 * shear) * e,", "return 0.5 * (lame + 2 * shear) * e,")),
    named(
        FEM, "first Lame constant omitted, linear law", (FEM_LOOP, "return (lame + 2 * shear) * e,", "return 2 * shear * e,")
    ),
    named(
        FEM,
        "shear modulus halved, neo-Hookean law",
        (FEM_LOOP, FEM_NEO_HOOKEAN, FEM_NEO_HOOKEAN.replace("shear", "0.5 * shear")),
    ),
    named(FEM, "first Lame constant omitted, neo-Hookean law", (FEM_LOOP, FEM_NEO_HOOKEAN, "return shear * e * (2 + e) / F,")),
    named(FEM, "sign of the traction reversed", (FEM_SOLVER, "normal * condition.value(t)", "-normal * condition.value(t)")),
    named(FEM, "body force omitted", (FEM_SOLVER, "(law.density * weight) @ values", "(0.0 * weight) @ values")),
    named(FEM, "body force not multiplied by the density", (FEM_SOLVER, "(law.density * weight) @ values", "weight @ values")),
    named(
        FEM,
        "quadrature weight omitted from the internal force",
        (FEM_LOOP, "+= mesh.weight[i, q] * mesh.gradient[i, q, k] * stress", "+= mesh.gradient[i, q, k] * stress"),
    ),
    named(FEM, "fixed end nodes kept in the factorised matrix", (FEM_SOLVER, "free[[0, -1]] = ~held", "pass")),
)

NAMED = (*HISTORIC, *MATERIAL_POINT, *IN_SPACE, *TAYLOR_GALERKIN, *FINITE_ELEMENT)

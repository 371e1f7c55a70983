"""Named faults of the material point method that one dimension does not show, and those at nodes of small mass."""

from mpmverify.selftest.faults import named

MPM = "mpm"
AFFINE, DEFORMATION, FACES, GRID, HISTORIES, HYPERELASTIC, PASSES, SOLVER, SPLINES = (
    f"mpm/{name}.py"
    for name in (
        "affine",
        "deformation",
        "faces",
        "grid",
        "histories",
        "hyperelastic",
        "passes",
        "solver",
        "splines",
    )
)
STRAINED = "    F = deformed(scheme, increment, before)\n"
TURNED = "tuple({0}[len(zero) * (k % len(zero)) + k // len(zero)] for k in range(len({0})))"
UNSPUN = f"tuple(0.5 * (a + b) for a, b in zip(increment, {TURNED.format('increment')}, strict=True))"
HELD = "for node in from_face.ravel() for c in range(problem.dimension)]"
KEPT = "columns(kept, quotient(m * grid.scale, D))"
MOVED = "at.gather_tensor(grid, nodal), at.gather(grid, nodes.velocity)"
YEOH = "shear + x * (4 * second + 6 * third * x)"
HENCKY = "shifted(lame * log(J) / J, shear / J, logarithm(b, J))"

IN_SPACE = (
    named(
        MPM,
        "nodes of small mass at rest",
        (GRID, "(limited if grid.kind.fitted else SMALLEST) * heaviest", "limited * heaviest"),
    ),
    named(
        MPM,
        "particles on cell edges without a function there",
        (SPLINES, "minimum(maximum(a, EDGE), 1 - 2**-53)", "minimum(maximum(a, 0.0), 1.0)"),
    ),
    named(
        MPM,
        "body force dropped at nodes of small mass",
        (GRID, "where(mass > least.velocity, force / mass, 0.0)", "where(mass > least.force, force / mass, 0.0)"),
    ),
    named(
        MPM,
        "velocity gradient transposed",
        (DEFORMATION, STRAINED, f"    increment = {TURNED.format('increment')}\n{STRAINED}"),
    ),
    named(
        MPM,
        "only the symmetric part of the velocity gradient in the deformation gradient",
        (DEFORMATION, STRAINED, STRAINED.replace("increment", UNSPUN)),
    ),
    named(
        MPM,
        "particles moved by their own velocity in the MUSL schedule",
        (
            PASSES,
            MOVED,
            MOVED.replace("at.gather(grid, nodes.velocity)", "load_rows(state, some.numbers, column.velocity, zero)"),
        ),
    ),
    named(MPM, "clamped face holds the normal component only", (FACES, HELD, HELD.replace("range(problem.dimension)", "(k,)"))),
    named(MPM, "traction applied to twice the area", (FACES, "area.append(sum(", "area.append(2 * sum(")),
    named(MPM, "values beyond a joined end lost", (GRID, "values[c, image] += values[c, ghost]", "values[c, image] += 0.0")),
    named(
        MPM,
        "affine part of APIC transposed",
        (AFFINE, KEPT, KEPT.replace("kept,", f"{TURNED.format('kept').replace('zero', 'D')},")),
    ),
    named(
        MPM,
        "shear stress of plane strain with the wrong sign in the internal force",
        (DEFORMATION, "full(sigma))\n    V =", "full((*sigma[: len(like)], *[-s for s in sigma[len(like) :]])))\n    V ="),
    ),
    named(
        MPM,
        "second coefficient of the Yeoh law omitted",
        (HYPERELASTIC, YEOH, YEOH.replace("4 * second + ", "")),
    ),
    named(
        MPM,
        "logarithm omitted in the Hencky law",
        (HYPERELASTIC, HENCKY, "shifted((lame * log(J) - shear) / J, shear / J, b)"),
    ),
    named(
        MPM,
        "heat of the first strip of particles alone",
        (HISTORIES, "running[TURNED] += strips.sums[s, HEAT]", "running[TURNED] += where(s < 1, strips.sums[s, HEAT], 0.0)"),
    ),
    named(
        MPM,
        "body force at the positions of other particles after they were sorted",
        (SOLVER, "points[particles.place] = particles.position", "points[:] = particles.position"),
    ),
    named(
        MPM,
        "body force of the first steps again in every block of steps",
        (SOLVER, "points, times[done:end])", "points, times[: end - done])"),
    ),
)

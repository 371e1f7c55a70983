"""A material point code of a stranger: plane strain, updated Lagrangian, explicit, FLIP, on hat functions or quadratic B-splines.

It is written from a textbook (Sulsky, Chen and Schreyer 1994; Zhang, Chen and Liu, "The Material Point Method") and the handbook alone.
Particle velocities are half a step behind the positions: a step has the forces at its start and moves by the velocities of its middle.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from mpmverify.problem import (
    Fixed,
    LinearElastic,
    NeoHookean,
    Periodic,
    Traction,
    Velocity,
    output_steps,
    place_particles,
    require,
)
from mpmverify.solution import RunError, Solution, Status, Work

I = np.eye(2)  # noqa: E741 - the unit tensor


def hat(s):
    return np.maximum(1 - abs(s), 0), np.where(abs(s) < 1, -np.sign(s), 0)


def spline(s):
    a = abs(s)
    return np.where(a < 0.5, 0.75 - a**2, (1.5 - a) ** 2 / 2), np.where(a < 0.5, -2 * s, np.sign(s) * (a - 1.5))


class Grid:
    """Nodes at the corners of the cells and one row more on every side; what each node moves with, and with which sign.

    A node beyond a joined end is the one inside. A node beyond a wall is the mirror image of the one inside: what points into the wall
    has the other sign, at a clamped one all components have. On the wall these components are zero.
    """

    def __init__(self, problem, h, cells):
        self.lower, self.h, self.nodes = np.array(problem.lower), h, np.array(cells) + 2
        self.width, self.count = cells[1] + 3, (cells[0] + 3) * (cells[1] + 3)
        self.period = np.array(
            [n if problem.boundary[axis + "-"] == Periodic() else np.inf for axis, n in zip("xy", cells, strict=True)]
        )
        to, signs = [], []
        for axis, n in enumerate(cells):
            ends = [problem.boundary["xy"[axis] + side] for side in "-+"]
            node, sign = np.arange(-1, n + 2), np.ones((n + 3, 2))
            if ends[0] == Periodic():
                node = node % n
            for end, beyond, wall, inside in ((ends[0], 0, 1, 1), (ends[1], n + 2, n + 1, n - 1)):
                if isinstance(end, (Velocity, Fixed)):
                    held = [0, 1] if end == Fixed() else [axis]
                    node[beyond] = inside
                    sign[beyond, held], sign[wall, held] = -1, 0
            to.append(node + 1)
            signs.append(sign)
        self.to = (to[0][:, None] * self.width + to[1]).ravel()
        self.sign = (signs[0][:, None] * signs[1]).reshape(-1, 2)

    def weights(self, x, basis):
        """Matrices (points, nodes) of the functions and their derivatives at the points x."""
        size, function = {"linear": (2, hat), "quadratic": (3, spline)}[basis]
        s = (x - self.lower) / self.h
        s = np.where(np.isfinite(self.period), np.mod(s, self.period), s)
        first = np.floor(s - (size - 2) / 2).astype(int)
        offset = np.arange(size)
        N, D = function(s[:, :, None] - first[:, :, None] - offset)
        if not ((first >= -1) & (first + size <= self.nodes)).all():
            raise RunError(Status.UNSTABLE, "a particle left the grid")
        nodes = (first[:, 0, None, None] + 1 + offset[:, None]) * self.width + first[:, 1, None, None] + 1 + offset
        start, shape = np.arange(len(x) + 1) * size**2, (len(x), self.count)
        pairs = (N[:, 0], N[:, 1]), (D[:, 0] / self.h, N[:, 1]), (N[:, 0], D[:, 1] / self.h)
        return [csr_array(((a[:, :, None] * b[:, None]).ravel(), nodes.ravel(), start), shape) for a, b in pairs]

    def gather(self, values, sign):
        """Sums at the nodes of what moves with them."""
        return np.stack([np.bincount(self.to, s * v, self.count) for s, v in zip(sign.T, values.T, strict=True)], 1)


@dataclass(frozen=True)
class OwnPlane:
    """The code; `musl` maps the velocities back to the nodes before the strain, `judged` are the fields whose orders it declares."""

    basis: str = "quadratic"
    musl: bool = False
    judged: tuple[str, ...] = ("displacement", "velocity", "stress", "displacement_gradient")
    conserves: frozenset[str] = frozenset({"mass", "momentum"})

    @property
    def name(self):
        return f"own-plane-{self.basis}-{'musl' if self.musl else 'usl'}"

    @property
    def orders(self):
        strain = 2 if self.basis == "quadratic" else 1
        orders = {"displacement": 2, "velocity": 2, "stress": strain, "displacement_gradient": strain}
        return {quantity: order for quantity, order in orders.items() if quantity in self.judged}

    def solve(self, problem, discretisation):
        law, faces = problem.material, problem.boundary
        walls = all(end in (Periodic(), Fixed(), Velocity()) or isinstance(end, Traction) for end in faces.values())
        suits = problem.dimension == 2 and type(law) in (NeoHookean, LinearElastic) and walls
        require(suits, self.name, problem, "neo-Hookean or linear elastic bodies in plane strain between walls at rest")
        h, (steps, dt) = discretisation.h, discretisation.time_steps(problem)
        grid = Grid(problem, h, discretisation.cells(problem))
        X, V0 = place_particles(problem, discretisation)
        m, lame, mu = law.density * V0, law.lame_lambda, law.shear_modulus
        x, v = X + problem.initial_field("displacement", X), problem.initial_field("velocity", X)
        F = I + problem.initial_field("displacement_gradient", X).reshape(-1, 2, 2)
        stress = problem.initial_field("stress", X)[:, [0, 2, 2, 1]].reshape(-1, 2, 2)
        loads = [
            (self.loaded(problem, face, h / discretisation.ppc, grid), end.value)
            for face, end in faces.items()
            if isinstance(end, Traction)
        ]
        shown, fields, impulse, work = output_steps(steps, problem.outputs), [], np.zeros(2), 0.0
        histories = {"time": dt * np.arange(steps + 1)}
        for n in range(steps + 1):
            J = np.linalg.det(F)
            V, t = V0 * J, n * dt
            if type(law) is NeoHookean:
                b = F @ F.swapaxes(1, 2)
                stress = (lame * np.log(J)[:, None, None] * I + mu * (b - I)) / J[:, None, None]
                stored = mu / 2 * (np.trace(b, axis1=1, axis2=2) - 2 - 2 * np.log(J)) + lame / 2 * np.log(J) ** 2
            else:
                pressure = lame / (2 * (lame + mu)) * np.trace(stress, axis1=1, axis2=2)
                strain = (stress - pressure[:, None, None] * I) / (2 * mu)
                stored = (stress * strain).sum((1, 2)) / 2

            # forces at the nodes
            N, N_x, N_y = grid.weights(x, self.basis)
            f_ext = N.T @ (m[:, None] * problem.force(X, x, t))
            for area, pressure in loads:
                f_ext += area * pressure(np.array([t]))[0]
            f = f_ext - N_x.T @ (V[:, None] * stress[:, 0]) - N_y.T @ (V[:, None] * stress[:, 1])
            M = N.T @ m
            mass = grid.gather(M[:, None], np.ones((grid.count, 1)))
            mass[mass < 1e-12 * m.max()] = np.inf
            a = grid.sign * (grid.gather(f, grid.sign) / mass)[grid.to]
            force = f_ext.sum(0) + (M[:, None] * a - f).sum(0)  # of loads, and of walls by what they hold back

            # the state at the end of the last step
            v_now = v + dt / 2 * (N @ a) * (n > 0)
            v_node = grid.sign * (grid.gather(N.T @ (m[:, None] * v), grid.sign) / mass)[grid.to]
            half = dt / 2 * (n > 0)
            impulse, work = impulse + half * force, work + half * (f_ext * v_node).sum()
            now = {
                "mass": m.sum(),
                "kinetic_energy": (m @ v_now**2).sum() / 2,
                "strain_energy": V0 @ stored,
                "external_work": work,
                "angular_momentum": m @ (x[:, 0] * v_now[:, 1] - x[:, 1] * v_now[:, 0]),
                **dict(zip(("momentum_x", "momentum_y", "impulse_x", "impulse_y"), (*(m @ v_now), *impulse), strict=True)),
            }
            for key, value in now.items():
                histories.setdefault(key, np.zeros(steps + 1))[n] = value
            if n in shown:
                cauchy = stress.reshape(-1, 4)[:, [0, 3, 1]]
                fields.append((x, V, x - X, v_now, cauchy, (F - I).reshape(-1, 4)))
            if n == steps:
                break

            # the step
            kick = dt if n else dt / 2
            v = v + kick * (N @ a)
            v_node = v_node + kick * a
            impulse, work = impulse + dt / 2 * force, work + dt / 2 * (f_ext * v_node).sum()
            x = x + dt * (N @ v_node)
            if self.musl:
                v_node = grid.sign * (grid.gather(N.T @ (m[:, None] * v), grid.sign) / mass)[grid.to]
            L = np.stack([N_x @ v_node, N_y @ v_node], 2)  # dv_i/dx_j
            F = F + dt * L @ F
            if type(law) is not NeoHookean:
                D, W = (L + L.swapaxes(1, 2)) / 2, (L - L.swapaxes(1, 2)) / 2
                rate = 2 * mu * D + lame * np.trace(D, axis1=1, axis2=2)[:, None, None] * I
                stress = stress + dt * (rate + W @ stress - stress @ W)
        position, weight, u, velocity, cauchy, gradient = (np.array(values) for values in zip(*fields, strict=True))
        returned = {"displacement": u, "velocity": velocity, "stress": cauchy, "displacement_gradient": gradient}
        time = histories["time"][shown]
        return Solution(time, dt, X, position, weight, returned, histories, Work(steps, steps * len(X)))

    def loaded(self, problem, face, width, grid):
        """Area of the loaded sides of bodies along the outer normal, spread over the nodes as that of points on them."""
        axis, along = ("xy".index(face[0]), 1 - "xy".index(face[0]))
        area = np.zeros((grid.count, 2))
        for block in problem.touched(face):
            count = round((block.upper[along] - block.lower[along]) / width)
            points, normal = np.zeros((count, 2)), np.zeros((count, 2))
            points[:, axis] = (problem.lower if face[1] == "-" else problem.upper)[axis]
            points[:, along] = block.lower[along] + (np.arange(count) + 0.5) * width
            normal[:, axis] = width if face[1] == "+" else -width
            area += grid.weights(points, self.basis)[0].T @ normal
        return area

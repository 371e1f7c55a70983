import numpy as np
from scipy.sparse import csr_array

from mpmverify.criteria import Order
from mpmverify.problem import NeoHookean, Ring, output_steps, require
from mpmverify.solution import Solution, Work


def spline(s):  # quadratic B-spline and its slope at a distance of s cells from its node
    a = abs(s)
    return np.where(a < 0.5, 0.75 - a**2, (1.5 - a) ** 2 / 2), np.where(a < 0.5, -2 * s, np.sign(s) * (a - 1.5))


class OwnMPM:  # total Lagrangian MPM with FLIP and MUSL: the weights are those of the undeformed body
    name, orders, conserves = "own-mpm", {"displacement": 2}, frozenset()

    def solve(self, problem, discretisation):
        suits = isinstance(problem.shape, Ring) and isinstance(problem.material, NeoHookean)
        require(suits, self.name, problem, "a neo-Hookean ring with free surfaces")
        law, h, ppc = problem.material, discretisation.h, discretisation.ppc
        (nx, ny), (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)

        lower = problem.lower + h / ppc * np.argwhere(np.ones((nx * ppc, ny * ppc)))
        V, X = problem.shape.parts(lower, lower + h / ppc)  # area and centroid of each particle
        V, X = V[V > 0, None], X[V > 0]
        first = np.rint((X - problem.lower) / h).astype(int) - 1
        nodes, weights = [], []
        for offset in np.ndindex(3, 3):  # the nine nodes around a particle
            (Nx, Ny), (Dx, Dy) = spline(((X - problem.lower) / h - first - offset).T)
            nodes.append((first + offset) @ (ny + 1, 1))
            weights.append((Nx * Ny, Dx * Ny / h, Nx * Dy / h))
        at = np.tile(np.arange(len(X)), 9), np.ravel(nodes)
        N, N_x, N_y = (csr_array((np.ravel(w), at)) for w in zip(*weights, strict=True))  # (particles, nodes)
        m = law.density * V
        M = np.maximum(N.T @ m, np.finfo(float).tiny)

        u, v, F = np.zeros((steps + 1, *X.shape)), problem.initial_field("velocity", X), np.tile(np.eye(2), (len(X), 1, 1))
        for n in range(steps):
            F_T, J = np.linalg.inv(F).swapaxes(1, 2), np.linalg.det(F)[:, None, None]
            P = law.lame_lambda * np.log(J) * F_T + law.shear_modulus * (F - F_T)
            b = problem.body_force(X, np.array([n * dt]))[0]
            f = N.T @ (m * b) - N_x.T @ (V * P[:, :, 0]) - N_y.T @ (V * P[:, :, 1])
            dv = (dt if n else dt / 2) * f / M  # velocities are half a step ahead
            u[n + 1] = u[n] + dt * (N @ (N.T @ (m * v) / M + dv))
            v += N @ dv
            v_node = N.T @ (m * v) / M
            F += dt * np.stack([N_x @ v_node, N_y @ v_node], axis=2)

        time, shown = dt * np.arange(steps + 1), output_steps(steps, problem.outputs)
        weight, fields = np.tile(V.T, (len(shown), 1)), {"displacement": u[shown]}
        return Solution(time[shown], dt, X, X + u[shown], weight, fields, {"time": time}, Work(steps, steps * len(X)))


def test_own_mpm(verify):
    second = Order("displacement", "L2-max", 1.8, 2.2, "second order: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360")
    verify(OwnMPM(), study="generalised-vortex", case="1 rad", criteria=[second])

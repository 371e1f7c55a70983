"""Stored deformation of particles: F where the law or the particle domain needs it, otherwise J = det F only."""

import numpy as np
import pytest
from from_python import entries
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpmverify.problem import Problem, Velocity
from mpmverify.problem.material import KelvinVoigt, LinearElastic, NeoHookean
from mpmverify.solvers import mpm
from mpmverify.solvers.mpm import MaterialPoint

deformation = entries(mpm.deformation)
pairs = st.sampled_from([1, 2, 3]).flatmap(lambda d: st.tuples(*2 * [arrays(float, (d, d), elements=st.floats(-0.2, 0.2))]))


@given(gradients=pairs, formulation=st.sampled_from(["updated", "total"]))
def test_j_updated_alone_is_the_determinant_of_the_updated_f(gradients, formulation):
    F, increment, d = np.eye(len(gradients[0])) + gradients[0], gradients[1], len(gradients[0])
    faces = dict.fromkeys([axis + side for axis in "xyz"[:d] for side in "-+"], Velocity())
    scheme = MaterialPoint(formulation=formulation)._scheme(
        Problem("box", (0.0,) * d, (1.0,) * d, LinearElastic(1.0, 1.0), faces, 1.0)
    )
    J = float(np.linalg.det(F))
    (alone,) = deformation.deformed(scheme, tuple(increment.ravel().tolist()), (J,))
    after = np.reshape(deformation.deformed(scheme, tuple(increment.ravel().tolist()), tuple(F.ravel().tolist())), (d, d))
    if formulation == "updated":
        assert after == pytest.approx((np.eye(d) + increment) @ F, abs=1e-14)
        assert alone == pytest.approx(np.linalg.det(after), rel=1e-12, abs=1e-13)
    else:
        assert after == pytest.approx(F + increment, abs=1e-14)
        assert alone == (J if d > 1 else after[0, 0])


@pytest.mark.parametrize(
    ("basis", "material", "dimension", "count"),
    [
        ("linear", LinearElastic(1.0, 1.0), 3, 1),
        ("cubic", LinearElastic(1.0, 1.0), 2, 1),
        ("tls-cubic", LinearElastic(1.0, 1.0), 2, 1),
        ("linear", LinearElastic(1.0, 1.0), 1, 1),
        ("linear", KelvinVoigt(1.0, 1.0, viscosity=0.1), 2, 4),
        ("linear", NeoHookean(1.0, 1.0), 3, 9),
        ("cpgimp", LinearElastic(1.0, 1.0), 2, 4),
        ("cpdi", LinearElastic(1.0, 1.0), 3, 9),
    ],
)
def test_particles_store_f_only_where_the_law_or_the_domain_needs_it(basis, material, dimension, count):
    faces = dict.fromkeys([axis + side for axis in "xyz"[:dimension] for side in "-+"], Velocity())
    stretched = {"displacement_gradient": lambda X: np.full((len(X), dimension**2), 0.1)}
    problem = Problem("box", (0.0,) * dimension, (1.0,) * dimension, material, faces, 1.0, stretched)
    particles = MaterialPoint(basis=basis)._particles(problem, np.full((2, dimension), 0.3), np.ones(2))
    F = np.eye(dimension) + 0.1
    assert pytest.approx(np.tile([np.linalg.det(F)] if count == 1 else F.ravel(), (2, 1)), rel=1e-14) == particles.F

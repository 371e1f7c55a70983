"""Constitutive laws of the material point: what mechanics asks of each, in one, two and three dimensions."""

import math
from dataclasses import fields, replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from from_python import entries
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import mpmverify.problem.material
from mpmverify.errors import UsageError
from mpmverify.exact.homogeneous import Homogeneous
from mpmverify.exact.motion import initial_velocity
from mpmverify.problem import Block, Discretisation, Problem, Traction
from mpmverify.problem.material import (
    Hencky,
    KelvinVoigt,
    LinearElastic,
    Maxwell,
    NeoHookean,
    NeoHookeanSplit,
    PlaneStress,
    SaintVenantKirchhoff,
    Yeoh,
)
from mpmverify.solvers import mpm
from mpmverify.solvers.mpm.constitution import LAWS, FiniteStrain, Linear

constitution = entries(mpm.constitution)
DT = 0.01
PARAMETERS = {"viscosity": 0.4, "relaxation_time": 0.05}
"""Of materials that ask for more than E, rho and nu; others get 0.3."""


def example(kind):
    """A material of a kind, with a value for each parameter that has no default."""
    own = [field.name for field in fields(kind) if field.kw_only]
    return kind(7.0, 2.0, 0.3, **{name: PARAMETERS.get(name, 0.3) for name in own})


MATERIALS = [example(kind) for kind in LAWS]
HYPERELASTIC = [material for material in MATERIALS if isinstance(LAWS[type(material)], FiniteStrain)]
SMALL_STRAIN = [material for material in MATERIALS if material not in HYPERELASTIC]
MODULUS = 10.0
"""lambda + 2 mu is 9.42 or, in plane stress, 7.69 [Pa]: what stress is measured in."""


def name(material):
    return type(material).__name__


all_hyperelastic = pytest.mark.parametrize("material", HYPERELASTIC, ids=name)
all_small_strain = pytest.mark.parametrize("material", SMALL_STRAIN, ids=name)
all_materials = pytest.mark.parametrize("material", MATERIALS, ids=name)
dimensions = st.sampled_from([1, 2, 3])


def tensors_of(size, dimensions=dimensions):
    """Matrices whose entries are below a size."""
    return dimensions.flatmap(lambda d: arrays(float, (d, d), elements=st.floats(-size, size)))


displacement_gradients = tensors_of(0.2)
increments = dimensions.flatmap(lambda d: st.tuples(*3 * [arrays(float, (d, d), elements=st.floats(-0.01, 0.01))]))
seeds = st.integers(0, 2**32 - 1)


def components(A):
    """Symmetric matrix as a tuple, (xx,), (xx, yy, xy) or (xx, yy, zz, xy, yz, zx)."""
    return tuple(
        ((A + A.T) / 2)[
            {1: ([0], [0]), 2: ([0, 1, 0], [0, 1, 1]), 3: ([0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0])}[len(A)]
        ].tolist()
    )


def matrix(values):
    """Tuple as a matrix."""
    places = {
        1: [[0]],
        3: [[0, 2], [2, 1]],
        4: [[0, 1], [2, 3]],
        6: [[0, 3, 5], [3, 1, 4], [5, 4, 2]],
        9: np.arange(9).reshape(3, 3),
    }
    return np.array(values)[np.array(places[len(values)])]


def row_major(A):
    return tuple(np.ravel(A).tolist())


def stress(material, F, increment=None, sigma=None, dt=DT):
    """Cauchy stress, a matrix, after a step to F that strains by an increment."""
    increment = np.zeros_like(F) if increment is None else increment
    sigma = np.zeros_like(F) if sigma is None else sigma
    found = constitution.stress(*constitution.constitution(material), components(sigma), row_major(F), row_major(increment), dt)
    return matrix(found)


def strain_energy(material, F, sigma=None):
    sigma = np.zeros_like(F) if sigma is None else sigma
    return constitution.strain_energy(*constitution.constitution(material), components(sigma), row_major(F))


def dissipation(material, sigma, increment, dt=DT):
    return constitution.dissipation(*constitution.constitution(material), components(sigma), row_major(increment), dt)


def first_strain(material, H, dt=DT):
    """Stress once a body at rest has taken the displacement gradient H in a step."""
    return stress(material, np.eye(len(H)) + H, H, dt=dt)


def hooke(material, H):
    return material.lame_lambda * np.trace(H) * np.eye(len(H)) + material.shear_modulus * (H + H.T)


def rotation(d, seed):
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(d, d)))
    return Q * np.linalg.det(Q) if d != 2 else Q @ np.diag([1, np.linalg.det(Q)])


def embedded(H):
    """Displacement gradient in space, of a body that does not strain out of the line or plane."""
    out = np.zeros((3, 3))
    out[: len(H), : len(H)] = H
    return out


# The table of laws.


def test_every_elastic_material_has_its_law():
    laws = [constitution.constitution(material)[0] for material in MATERIALS]
    declared = {
        kind for kind in vars(mpmverify.problem.material).values() if isinstance(kind, type) and issubclass(kind, LinearElastic)
    }
    assert set(LAWS) == {type(material) for material in MATERIALS} == declared
    assert len(set(laws)) == len(laws) - 1  # plane stress is linear elastic
    linear = [type(material) for material, law in zip(MATERIALS, laws, strict=True) if isinstance(law, Linear)]
    assert linear == [LinearElastic, PlaneStress]
    assert [constitution.finite_strain(law) for law in laws] == [material in HYPERELASTIC for material in MATERIALS]


# Finite strain.


@all_materials
@given(d=dimensions)
def test_an_unstrained_body_has_no_stress_and_no_energy(material, d):
    assert np.abs(stress(material, np.eye(d))).max() < 1e-15 * MODULUS
    assert abs(strain_energy(material, np.eye(d))) < 1e-15 * MODULUS


@all_hyperelastic
@given(H=displacement_gradients, seed=seeds)
def test_the_stress_turns_with_the_body(material, H, seed):
    F, Q = np.eye(len(H)) + H, rotation(len(H), seed)
    sigma = stress(material, F)
    assert stress(material, Q @ F) == pytest.approx(Q @ sigma @ Q.T, abs=1e-13 * MODULUS)
    assert stress(material, F @ Q) == pytest.approx(sigma, abs=1e-13 * MODULUS)  # isotropic
    assert strain_energy(material, Q @ F) == pytest.approx(strain_energy(material, F), abs=1e-13 * MODULUS)


@all_small_strain
@pytest.mark.parametrize("d", [2, 3])
def test_a_law_of_small_strain_takes_a_rotation_for_a_strain(material, d):
    turned = np.eye(d)
    turned[:2, :2] = [[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]]
    assert np.abs(first_strain(material, turned - np.eye(d))).max() > 1e-2 * MODULUS
    assert not constitution.finite_strain(constitution.constitution(material)[0])


@all_hyperelastic
@given(H=displacement_gradients)
def test_stress_is_the_derivative_of_the_energy(material, H):
    """J sigma = dW/dF F^T, and P = dW/dF."""
    d, step = len(H), 1e-5
    F = np.eye(d) + H
    P = np.zeros((d, d))
    for place in np.ndindex(d, d):
        change = np.zeros((d, d))
        change[place] = step
        P[place] = (strain_energy(material, F + change) - strain_energy(material, F - change)) / (2 * step)
    sigma = stress(material, F)
    assert np.linalg.det(F) * sigma == pytest.approx(P @ F.T, abs=1e-7 * MODULUS)
    law, _ = constitution.constitution(material)
    found = constitution.reference_stress(law, components(sigma), row_major(F))
    assert matrix(found) == pytest.approx(P, abs=1e-7 * MODULUS)


@all_hyperelastic
@given(H=displacement_gradients)
def test_energy_is_positive_in_any_strain(material, H):
    assert strain_energy(material, np.eye(len(H)) + H) >= -1e-15 * MODULUS


@all_materials
@given(H=tensors_of(1.0), size=st.sampled_from([1e-2, 1e-3, 1e-4]))
def test_small_strains_are_strains_of_hookes_law(material, H, size):
    """To second order in the strain, and without the viscous part, which is measured by itself."""
    elastic = stress(material, np.eye(len(H)) + size * H, size * H, dt=1e-9 if isinstance(material, Maxwell) else 1e9)
    assert np.abs(elastic - size * hooke(material, H)).max() <= 50 * MODULUS * size**2


@all_hyperelastic
@given(H=tensors_of(0.2, st.sampled_from([1, 2])))
def test_a_plane_or_a_line_strains_as_a_body_in_space(material, H):
    d, space = len(H), embedded(H)
    F, inside = np.eye(d) + H, stress(material, np.eye(3) + space)
    assert stress(material, F) == pytest.approx(inside[:d, :d], abs=1e-13 * MODULUS)
    assert strain_energy(material, F) == pytest.approx(strain_energy(material, np.eye(3) + space), abs=1e-13 * MODULUS)


@all_hyperelastic
@given(H=displacement_gradients)
def test_an_inverted_point_says_so_in_every_component(material, H):
    F = np.eye(len(H)) + H
    inverted, flat = F.copy(), F.copy()
    inverted[0] *= -1
    flat[0] = 0
    for bad in (inverted, flat, F * np.nan):
        assert np.isnan(stress(material, bad)).all()
        assert np.isnan(strain_energy(material, bad))


@all_small_strain
def test_a_law_of_small_strain_does_not_see_the_volume(material):
    assert np.isfinite(stress(material, -np.eye(2))).all()


def test_uniaxial_forms_of_the_field():
    """P of one dimension as the literature writes it."""
    F, lame, mu = 1.3, HYPERELASTIC[0].lame_lambda, HYPERELASTIC[0].shear_modulus
    E, bulk, x = (F * F - 1) / 2, lame + 2 * mu / 3, F ** (-2 / 3) * (F * F + 2) - 3
    expected = {
        NeoHookean: lame * math.log(F) / F + mu * (F - 1 / F),
        NeoHookeanSplit: bulk / 2 * (F - 1 / F) + 2 * mu / 3 * F ** (-2 / 3) * (F - 1 / F),
        Hencky: (lame + 2 * mu) * math.log(F) / F,
        SaintVenantKirchhoff: (lame + 2 * mu) * E * F,
        Yeoh: bulk / 2 * (F - 1 / F) + 4 / 3 * (mu / 2 + 0.6 * x + 0.9 * x * x) * F ** (-2 / 3) * (F - 1 / F),
    }
    for material in HYPERELASTIC:
        assert stress(material, np.array([[F]])).item() == pytest.approx(expected[type(material)], rel=1e-14), name(material)


# Small strain.


@pytest.mark.parametrize("material", [law for law in SMALL_STRAIN if not isinstance(law, PlaneStress)], ids=name)
@given(H=tensors_of(0.2, st.sampled_from([1, 2])))
def test_small_strain_in_a_plane_or_a_line_is_that_in_space(material, H):
    d, space, sigma = len(H), embedded(H), hooke(material, H)
    inside = stress(material, np.eye(3) + space, 0.1 * space, hooke(material, space))
    assert stress(material, np.eye(d) + H, 0.1 * H, sigma) == pytest.approx(inside[:d, :d], abs=1e-13 * MODULUS)
    energy = strain_energy(material, np.eye(d) + H, sigma)
    assert energy == pytest.approx(strain_energy(material, np.eye(3) + space, hooke(material, space)), abs=1e-13 * MODULUS)


@given(H=tensors_of(0.2, st.just(2)))
def test_plane_stress_is_a_body_in_space_without_normal_stress(H):
    plate, body = PlaneStress(7.0, 2.0, 0.3), LinearElastic(7.0, 2.0, 0.3)
    space = embedded(H)
    space[2, 2] = -body.lame_lambda / (body.lame_lambda + 2 * body.shear_modulus) * np.trace(H)
    sigma, inside = first_strain(plate, H), first_strain(body, space)
    assert inside[2] == pytest.approx(0, abs=1e-14 * MODULUS)
    assert sigma == pytest.approx(inside[:2, :2], abs=1e-14 * MODULUS)
    energies = strain_energy(plate, np.eye(2), sigma), strain_energy(body, np.eye(3), inside)
    assert energies[0] == pytest.approx(energies[1], abs=1e-14 * MODULUS)


@all_small_strain
@given(H=displacement_gradients)
def test_energy_of_the_elastic_part_is_half_of_stress_times_strain(material, H):
    sigma = hooke(material, H)
    energy = strain_energy(material, np.eye(len(H)) + H, sigma)
    assert energy == pytest.approx(np.sum(sigma * H) / 2, abs=1e-14 * MODULUS)


def gauss(step, increment):
    """Work over a step of constant rate of a stress that is a function of the part of the step that has passed."""
    points, weights = np.polynomial.legendre.leggauss(12)
    return sum(w / 2 * np.sum(step((1 + x) / 2) * increment) for x, w in zip(points, weights, strict=True))


@all_small_strain
@given(steps=increments, slow=st.floats(0.01, 100))
def test_work_over_a_closed_cycle_is_dissipated(material, steps, slow):
    """Four increments that add up to nothing: work = stored + dissipated over each, with work from the stress by quadrature."""
    steps = [*steps, -sum(steps)]
    dt = slow * DT
    d = len(steps[0])
    F, sigma = np.eye(d), np.zeros((d, d))
    for increment in steps:

        def within(part, F=F, sigma=sigma, increment=increment):
            return stress(material, F + part * increment, part * increment, sigma, part * dt)

        before = strain_energy(material, F, sigma)
        lost = dissipation(material, sigma, increment, dt)
        F, sigma, work = F + increment, within(1.0), gauss(within, increment)
        assert work == pytest.approx(strain_energy(material, F, sigma) - before + lost, abs=1e-14 * MODULUS)
        assert lost >= -1e-17 * MODULUS
        assert lost == 0 or isinstance(material, KelvinVoigt | Maxwell)
    assert np.abs(F - np.eye(d)).max() < 1e-15


@given(steps=increments, dt=st.floats(1e-4, 10))
def test_maxwell_loses_twice_its_stored_energy_in_a_relaxation_time(steps, dt):
    """D = integral of sigma : C^-1 : sigma/tau."""
    material = Maxwell(7.0, 2.0, 0.3, relaxation_time=0.05)
    increment, sigma = steps[0], hooke(material, steps[1])
    F = np.eye(len(increment))
    points, weights = np.polynomial.legendre.leggauss(60)
    power = [
        2 / 0.05 * strain_energy(material, F, stress(material, F, part * increment, sigma, part * dt))
        for part in (1 + points) / 2
    ]
    assert dissipation(material, sigma, increment, dt) == pytest.approx(dt / 2 * weights @ power, rel=1e-9, abs=1e-17)


@given(H=displacement_gradients, steps=st.integers(1, 9), held=st.floats(1e-6, 3))
def test_maxwell_relaxes_by_the_exponential_whatever_the_steps(H, steps, held):
    material = Maxwell(7.0, 2.0, 0.3, relaxation_time=0.5)
    F, start = np.eye(len(H)) + H, hooke(material, H)
    sigma = start
    for _ in range(steps):
        sigma = stress(material, F, 0 * H, sigma, held / steps)
    assert sigma == pytest.approx(math.exp(-held / 0.5) * start, abs=1e-14 * MODULUS)
    sigma = 0 * H
    for _ in range(steps):
        sigma = stress(material, F, H / steps, sigma, held / steps)
    assert sigma == pytest.approx(-math.expm1(-held / 0.5) * 0.5 / held * start, abs=1e-14 * MODULUS)


@given(H=displacement_gradients, L=st.floats(-2, 2))
def test_kelvin_voigt_is_a_spring_beside_a_dashpot(H, L):
    material = KelvinVoigt(7.0, 2.0, 0.3, viscosity=0.4)
    rate = L * H
    spring, dashpot = hooke(material, H), 0.4 * hooke(material, rate) / (material.density * material.wave_speed**2)
    sigma = stress(material, np.eye(len(H)) + H, rate * DT)
    assert sigma == pytest.approx(spring + dashpot, abs=1e-13 * MODULUS)
    if len(H) == 1:
        assert sigma == pytest.approx(material.density * material.wave_speed**2 * H + 0.4 * rate, abs=1e-13 * MODULUS)


# Waves.


def standing_wave(material, k, end, steps, q, v):
    """Amplitude q of u = q(t) sin(kx) at the end, and its velocity half a step before, by the leapfrog scheme."""
    dt = end / steps
    sigma = stress(material, np.array([[1 + k * q]]))  # at rest, or not strained
    for n in range(steps):
        v -= (dt if n else dt / 2) * k / material.density * sigma.item()
        q += dt * v
        sigma = stress(material, np.array([[1 + k * q]]), np.array([[dt * k * v]]), sigma, dt)
    return q, v


def test_the_standing_wave_of_a_kelvin_voigt_bar():
    """Of first order in time: the rate that the stress takes is half a step old."""
    material, k, end = KelvinVoigt(7.0, 2.0, 0.3, viscosity=0.4), 2.0, 2.0
    g = material.viscosity * k**2 / (2 * material.density)
    w = math.sqrt((material.wave_speed * k) ** 2 - g**2)
    exact = 1e-3 * math.exp(-g * end) * (math.cos(w * end) + g / w * math.sin(w * end))
    errors = [abs(standing_wave(material, k, end, steps, 1e-3, 0.0)[0] - exact) for steps in (400, 800, 1600)]
    assert errors[-1] < 5e-3 * 1e-3
    assert [a / b for a, b in pairwise(errors)] == pytest.approx([2, 2], rel=0.05)


def test_the_standing_wave_of_a_maxwell_bar():
    """Of second order in time."""
    material, k, end = Maxwell(7.0, 2.0, 0.3, relaxation_time=0.9), 2.0, 2.0
    tau, W = 0.9, math.sqrt((material.wave_speed * k) ** 2 - 1 / (4 * 0.9**2))
    errors = []
    for steps in (400, 800, 1600):
        t = end - end / steps / 2
        exact = 1e-3 * math.exp(-t / (2 * tau)) * (math.cos(W * t) + math.sin(W * t) / (2 * tau * W))
        errors.append(abs(standing_wave(material, k, end, steps, 0.0, 1e-3)[1] - exact))
    assert errors[-1] < 1e-5 * 1e-3
    assert [a / b for a, b in pairwise(errors)] == pytest.approx([4, 4], rel=0.05)


@pytest.mark.parametrize("viscosity", [0.01, 0.4, 10.0])
def test_the_step_that_a_viscosity_allows(viscosity):
    material, k = KelvinVoigt(7.0, 2.0, 0.3, viscosity=viscosity), 2.0
    omega = material.wave_speed * k
    xi = material.retardation_time * omega / 2
    limit = 2 / omega * (math.sqrt(1 + xi**2) - xi)
    below, above = (abs(standing_wave(material, k, 2000 * part * limit, 2000, 1e-3, 0.0)[0]) for part in (0.99, 1.01))
    assert below < 0.1
    assert above > 1e3


def acoustic_tensor(material, n):
    """Of waves along n in a body at rest, by differences: column j is the traction on n of the increment e_j n^T."""
    d, step = len(n), 1e-6
    dt = 1e9 if isinstance(material, KelvinVoigt) else 1e-12  # the elastic part alone
    columns = [
        (first_strain(material, step * A, dt) - first_strain(material, -step * A, dt)) @ n for A in np.eye(d)[:, :, None] * n
    ]
    return np.array(columns).T / (2 * step)


@all_materials
@given(d=dimensions, seed=seeds)
def test_speeds_of_waves_are_those_of_the_acoustic_tensor(material, d, seed):
    n = rotation(d, seed)[0]
    squares = np.linalg.eigvalsh(acoustic_tensor(material, n)) / material.density
    expected = [material.shear_wave_speed] * (d - 1) + [material.wave_speed]
    assert np.sqrt(squares) == pytest.approx(expected, rel=1e-8)


# Materials.


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_a_viscous_material_refuses_what_is_no_viscosity(value):
    for make, what in (
        (partial(KelvinVoigt, viscosity=value), "viscosity"),
        (partial(Maxwell, relaxation_time=value), "relaxation"),
    ):
        with pytest.raises(UsageError, match=f"the {what}.* must be positive and finite"):
            make(1.0, 1.0)


@pytest.mark.parametrize(
    ("second", "third", "why"),
    [(math.nan, 0.0, "must be finite"), (0.0, -0.1, "soften"), (-0.1, 0.0, "soften"), (-1.0, 1 / 1.5, "soften")],
)
def test_a_yeoh_body_refuses_to_soften_without_bound(second, third, why):
    with pytest.raises(UsageError, match=why):
        Yeoh(2.0, 1.0, second=second, third=third)  # mu = 1
    assert Yeoh(2.0, 1.0, second=-1.0, third=0.7).third == 0.7


@all_materials
@pytest.mark.parametrize(("youngs_modulus", "poissons_ratio"), [(0.0, 0.3), (1.0, 0.5), (1.0, -1.0), (math.nan, 0.3)])
def test_a_material_refuses_moduli_without_stiffness(material, youngs_modulus, poissons_ratio):
    with pytest.raises(UsageError, match="Young's modulus"):
        replace(material, youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio)


def test_the_heat_of_a_viscous_body_is_that_of_its_current_volume():
    """A heavy free bar is drawn to one and a half times its length, at a power of theta (lambda + 2 mu)/(1 + t)^2 per volume."""
    law = KelvinVoigt(1.0, 1e6, 0.3, viscosity=0.7)
    motion = Homogeneous(law, ((1.0,),), (1.0,))
    free, drawn = {"x-": Traction(), "x+": Traction()}, initial_velocity(motion)
    problem = Problem("drawn bar", (0.0,), (2.0,), law, free, 0.5, drawn, shape=Block((0.5,), (1.5,)))
    heat = []
    for h in (1 / 32, 1 / 64):
        solution = mpm.MaterialPoint("USL").solve(problem, Discretisation(h, 0.01 * law.wave_speed / h, 2))
        heat.append(solution.histories["dissipated_energy"][-1])
    exact = law.retardation_time * (law.lame_lambda + 2 * law.shear_modulus) * math.log(1.5)
    assert 2 * heat[1] - heat[0] == pytest.approx(exact, rel=0.01), "the surface is off by O(h)"

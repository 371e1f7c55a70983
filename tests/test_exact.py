"""Every closed form satisfies its governing equations and the initial and boundary conditions of its problem."""

import dataclasses
import math
import pickle

import numpy as np
import pytest
import sympy
from arrays import assert_times_are_independent
from latex2mathml.converter import convert

from mpmverify.errors import UsageError
from mpmverify.exact.advection import CosineHill, FourierMode, Gaussian, PeriodicImages, Step, advection
from mpmverify.exact.deck import deck
from mpmverify.exact.driven_bar import driven_bar
from mpmverify.exact.elastic_bar import RampLoad, SineLoad, SmoothPulse, StepLoad, elastic_bar
from mpmverify.exact.manufactured import manufactured
from mpmverify.exact.open_bar import open_bar
from mpmverify.exact.steffen import steffen
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Absorbing, Inflow, LinearElastic, NeoHookean, Periodic, Traction, Transport, Velocity

STIFF = {"length": 2.5, "youngs_modulus": 7.0, "density": 3.0, "end_time": 9.0}
C = math.sqrt(7.0 / 3.0)


def bar_case(load, feature, breaks=(0.0,), **options):
    """Return a case whose fronts leave x = L at the breaks of the load and follow both characteristics, with images every 2L."""
    problem = elastic_bar(load, **options)
    L, c = problem.problem.upper[0], problem.problem.material.wave_speed
    return problem, feature, tuple(L + s * c * b for b in breaks for s in (-1, 1)), 2 * L


# problem, feature length [m], positions of the non-smooth points on a characteristic [m], their period [m]
CASES = {
    "hill": (advection(), 0.25, (0.25, 0.75), 1.0),
    "hill, upstream": (advection(CosineHill(0.3, 0.4), velocity=-0.7), 0.4, (-0.1, 0.7), 1.0),
    "gaussian": (advection(Gaussian()), 0.1, (), 1.0),
    "gaussian, fast": (advection(Gaussian(0.9, 0.15), velocity=2.0, end_time=3.3), 0.15, (), 1.0),
    "mode 1": (advection(FourierMode()), 0.3, (), 1.0),
    "mode 3": (advection(FourierMode(3), velocity=-1.5), 0.1, (), 1.0),
    "front": (advection(Step()), 0.1, (0.25,), 9.0),
    "front, upstream": (advection(Step(0.7, 0.2, 1.5), velocity=-1.0), 0.1, (0.7,), 9.0),
    "step": bar_case(StepLoad(), 0.1),
    "step, stiff": bar_case(StepLoad(-2.0), 0.1, **STIFF),
    "ramp": bar_case(RampLoad(), 0.1, (0.0, 0.3)),
    "ramp, stiff": bar_case(RampLoad(3.0, 0.7), 0.1, (0.0, 0.7), **STIFF),
    "pulse": bar_case(SmoothPulse(), 0.08, ()),
    "pulse, stiff": bar_case(SmoothPulse(0.5, 1.5, 0.2), 0.2 * C, (), **STIFF),
    "sine": bar_case(SineLoad(), 0.1),
    "sine, stiff": bar_case(SineLoad(2.0, 5.0), 0.2, **STIFF),
    "deck": (deck(), 1.0, (-1.0, 0.0, 1.0), 16.0),
    "deck, fine": (deck(length=5.0, h=0.25), 0.25, (-0.25, 0.0, 0.25), 10.0),
    "deck, stiff": (deck(length=3.0, h=0.5, steps=60, youngs_modulus=4.0, density=2.0), 0.5, (-0.5, 0.0, 0.5), 6.0),
    "mode 1, fixed": (axial_vibration(), 5.0, (), 1.0),
    "mode 3, fixed": (axial_vibration(3, v0=-0.01), 1.5, (), 1.0),
    "mode 1, free": (axial_vibration(ends="fixed-free"), 5.0, (), 1.0),
    "mode 2, free": (axial_vibration(2, "fixed-free", length=2.0, youngs_modulus=3.0, density=5.0, v0=1e-3), 0.2, (), 1.0),
    "mode 1, periodic": (axial_vibration(ends="periodic"), 4.0, (), 1.0),
    "mode 2, periodic": (axial_vibration(2, "periodic", length=2.0, youngs_modulus=3.0, v0=1e-3), 0.2, (), 1.0),
    "driven": (driven_bar(), 0.2, (), 1.0),
    "driven, accelerated": (driven_bar(start=0.6), 0.2, (), 1.0),
    "driven, loaded at the left": (driven_bar("x-", poissons_ratio=-0.2, lower=-2.0), 0.2, (), 1.0),
    "open": (open_bar(), 0.2, (), 1.0),
    "manufactured, small": (manufactured(), 0.2, (), 1.0),
    "manufactured, large": (manufactured(0.05), 0.2, (), 1.0),
    "manufactured, nu": (manufactured(0.2, poissons_ratio=0.3), 0.1, (), 1.0),
    "manufactured, auxetic": (
        manufactured(-0.1, youngs_modulus=3.0, density=2.0, poissons_ratio=-0.2, end_time=4.0),
        0.1,
        (),
        1.0,
    ),
    "steffen": (steffen(), 0.1, (), 1.0),
}
every_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
every_problem = pytest.mark.parametrize("verification", [case[0] for case in CASES.values()], ids=CASES.keys())


def at(field, x, t):
    """Values (N,) at the N events (x_i, t_i)."""
    return np.einsum("iik->i", field(x[:, None], t))


def difference(f, delta):
    """Central difference of eighth order of f(offset)."""
    return sum(w * (f(k * delta) - f(-k * delta)) for k, w in enumerate((4 / 5, -1 / 5, 4 / 105, -1 / 280), 1)) / delta


def events(case, count=150):
    """Return random events whose difference stencils stay in the domain and off every front, and the stencil steps in x and t."""
    verification, feature, breaks, period = case
    problem, delta = verification.problem, 0.02 * feature
    c = problem.material.wave_speed
    rng = np.random.default_rng(1)
    x = rng.uniform(problem.lower[0] + 5 * delta, problem.upper[0] - 5 * delta, count)
    t = rng.uniform(5 * delta / c, problem.end_time, count)
    smooth = np.ones(count, dtype=bool)
    for phase in (x - c * t, x + c * t):
        for b in breaks:
            smooth &= np.abs(np.mod(phase - b + period / 2, period) - period / 2) > 5 * delta
    assert smooth.sum() > count / 3
    return x[smooth], t[smooth], delta, delta / c


def assert_balance(scale, *terms):
    """Assert that the terms sum to zero, relative to the largest of them or to the scale."""
    assert np.max(np.abs(sum(terms))) <= 1e-9 * max(scale, *(np.max(np.abs(term)) for term in terms))


def neo_hookean_stress(material, F):
    """P = dW/dF of W = mu/2 (F^2 - 1 - 2 ln F) + lambda/2 (ln F)^2, derived by sympy."""
    f, mu, lame = sympy.symbols("F mu lambda", positive=True)
    energy = mu / 2 * (f**2 - 1 - 2 * sympy.log(f)) + lame / 2 * sympy.log(f) ** 2
    return sympy.lambdify((f, mu, lame), sympy.diff(energy, f))(F, material.shear_modulus, material.lame_lambda)


@every_case
def test_governing_equations(case):
    problem, fields = case[0].problem, case[0].exact.fields
    x, t, dx, dt = events(case)
    d_t = {q: difference(lambda s, f=f: at(f, x, t + s), dt) for q, f in fields.items()}
    d_x = {q: difference(lambda s, f=f: at(f, x + s, t), dx) for q, f in fields.items()}
    size = {q: np.max(np.abs(at(f, x, t))) / problem.lengths[0] for q, f in fields.items()}
    law = problem.material
    if isinstance(law, Transport):
        assert_balance(size["u"], d_t["u"], law.velocity * d_x["u"])
        return
    force = 0.0 if problem.body_force is None else np.einsum("iik->i", problem.body_force(x[:, None], t))
    assert_balance(size["stress"], law.density * d_t["velocity"], -d_x["stress"], -law.density * force)
    modulus = law.lame_lambda + 2 * law.shear_modulus
    if not isinstance(law, NeoHookean):
        assert_balance(modulus * size["velocity"], d_t["stress"], -modulus * d_x["velocity"])
    if "displacement" in fields:
        assert_balance(size["displacement"], d_t["displacement"], -at(fields["velocity"], x, t))
        finite = isinstance(law, NeoHookean)
        strain = d_x["displacement"]
        stress = neo_hookean_stress(law, 1 + strain) if finite else modulus * strain
        assert_balance(0.0, stress, -at(fields["stress"], x, t))


@every_problem
def test_initial_conditions(verification):
    problem = verification.problem
    X = np.random.default_rng(2).uniform(problem.lower[0], problem.upper[0], (200, 1))
    assert set(problem.initial) <= set(verification.exact.fields)
    for quantity, field in verification.exact.fields.items():
        scale = np.max(np.abs(field(X, np.linspace(0, problem.end_time, 50))))
        assert np.allclose(field(X, np.zeros(1))[0], problem.initial_field(quantity, X), rtol=0, atol=1e-14 * scale)


@every_problem
def test_boundary_conditions(verification):
    problem, fields = verification.problem, verification.exact.fields
    t = np.random.default_rng(3).uniform(0, problem.end_time, 200)
    faces = {"x-": problem.lower, "x+": problem.upper}
    values = {face: {q: field(np.array([corner]), t)[:, 0, 0] for q, field in fields.items()} for face, corner in faces.items()}
    X = np.linspace(*problem.lower, *problem.upper, 50)[:, None]
    scale = {q: np.max(np.abs(field(X, t))) for q, field in fields.items()}
    for face, condition in problem.boundary.items():
        match condition:
            case Traction(value):
                quantity = "stress"
            case Velocity(value):
                quantity = "velocity"
                if "displacement" in fields:
                    assert np.allclose(
                        values[face]["displacement"], value.integral(t), rtol=0, atol=1e-14 * scale["displacement"]
                    )
            case Inflow(value):
                quantity = "u"
                assert (problem.material.velocity > 0) == (face == "x-")
            case Absorbing():
                law = problem.material
                entering = (
                    values[face]["stress"] + {"x-": -1, "x+": 1}[face] * law.density * law.wave_speed * values[face]["velocity"]
                )
                assert np.allclose(entering, 0, rtol=0, atol=1e-13 * scale["stress"])
                continue
            case Periodic():
                for name in fields:
                    assert np.allclose(values["x-"][name], values["x+"][name], rtol=0, atol=1e-13 * scale[name])
                continue
            case _:
                continue
        assert np.allclose(values[face][quantity], value(t), rtol=0, atol=1e-13 * scale[quantity])


@every_case
def test_declared_regularity_is_that_of_the_fields(case):
    """The L1 norm of the fourth difference falls as h^min(s, 4), averaged over the position of the fronts between the points."""
    verification, feature, *_ = case
    problem = verification.problem
    t = np.array([0.3718 * problem.end_time])
    declared = verification.exact.derivatives
    for quantity, field in verification.exact.fields.items():
        expected = declared + (quantity == "displacement")
        errors = []
        for h in feature / np.array([60.0, 120.0]):
            shifted = [np.arange(problem.lower[0] + offset * h, problem.upper[0], h) for offset in np.linspace(0.05, 0.95, 10)]
            errors.append(h * np.mean([np.abs(np.diff(field(x[:, None], t)[0, :, 0], n=4)).sum() for x in shifted]))
        assert abs(math.log2(errors[0] / errors[1]) - min(expected, 4)) < 0.25, quantity


@every_problem
def test_fields_are_finite_values_of_the_declared_shape(verification):
    problem = verification.problem
    X = np.linspace(*problem.lower, *problem.upper, 7)[:, None]
    t = np.array([-1.0, 0.0, 0.5, 1.0, 40.0]) * problem.end_time
    for field in verification.exact.fields.values():
        assert field(X, t).shape == (5, 7, 1)
        assert np.isfinite(field(X, t)).all()
        assert_times_are_independent(field, X, t, 3)
    if problem.body_force is not None:
        assert problem.body_force(X, t).shape == (5, 7, 1)


@every_problem
def test_problems_are_frozen_and_picklable(verification):
    assert pickle.loads(pickle.dumps(verification)) == verification
    problem = verification.problem
    data = [*problem.initial.values(), *problem.boundary.values(), *verification.exact.fields.values()]
    while data:
        value = data.pop()
        assert value.__dataclass_params__.frozen
        for field in dataclasses.fields(value):
            content = getattr(value, field.name)
            if dataclasses.is_dataclass(content):
                data.append(content)
            else:
                assert isinstance(content, int | float | str)


@every_problem
def test_the_description_of_a_problem_is_complete_and_renders_as_mathml(verification):
    assert verification.exposes.endswith(".")
    assert verification.exact.citation
    assert len(verification.equations) >= 4
    for equation in verification.equations:
        assert "$" not in equation
        mathml = convert(equation)
        assert "\\" not in mathml
        assert "merror" not in mathml


@pytest.mark.parametrize("name", sorted(CASES.keys() - {"deck"} - {name for name in CASES if name.startswith("manufactured")}))
def test_no_field_vanishes_at_the_final_time(name):
    """Errors at the final time are relative to the field there; the deck and the manufactured bar are judged over all times."""
    problem, exact = CASES[name][0].problem, CASES[name][0].exact
    X = np.linspace(*problem.lower, *problem.upper, 400)[:, None]
    for field in exact.fields.values():
        norms = np.sqrt(np.mean(field(X, np.linspace(0, problem.end_time, 200)) ** 2, axis=(1, 2)))
        assert norms[-1] > 0.05 * norms.max()


def test_periodic_gaussian_is_smooth_across_the_ends_of_the_domain():
    profile = PeriodicImages(Gaussian(0.95, 0.15))
    s = np.linspace(-0.2, 0.2, 41)
    images = sum(np.exp(-(((s - 0.95 - n) / 0.15) ** 2)) for n in range(-6, 7))
    assert np.allclose(profile(1 + s), images, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: advection(velocity=0.0), "velocity"),
        (lambda: advection(Gaussian(0.5, 0.8)), "narrow"),
        (lambda: advection(CosineHill(5.0)), "centre"),
        (lambda: SmoothPulse(1.0, 0.5, 0.1), "six widths"),
        (lambda: deck(length=1.0, h=2.0), "deck"),
        (lambda: deck(steps=1), "steps"),
        (lambda: axial_vibration(0), "mode"),
        (lambda: axial_vibration(ends="free-free"), "free-free"),
        (lambda: manufactured(0.32), "amplitude"),
        (lambda: manufactured(0.0), "amplitude"),
        (lambda: Transport(math.nan), "velocity of transport must be finite"),
        (lambda: Transport(math.inf), "velocity of transport must be finite"),
        (lambda: dataclasses.replace(advection().problem, outputs=0), "at least 1 output interval, not 0"),
        (lambda: dataclasses.replace(advection().problem, lower=(), upper=(), boundary={}), "give the box one to three sides"),
        (lambda: dataclasses.replace(advection().problem, lower=(1.0,)), "upper bounds above its lower bounds"),
        *(
            (lambda material=material, values=values: material(*values), "must be positive and finite, and -1 < nu < 1/2: ")
            for material in (LinearElastic, NeoHookean)
            for values in ((0.0, 1.0), (math.inf, 1.0), (1.0, -1.0), (1.0, math.nan), (1.0, 1.0, 0.5), (1.0, 1.0, -1.0))
        ),
    ],
)
def test_invalid_arguments_raise_a_usage_error(make, message):
    with pytest.raises(UsageError, match=message):
        make()

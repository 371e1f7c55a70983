"""Closed forms of all shipped problems solve their equations, by differences that share nothing with their derivation; wrong ones do not."""

import dataclasses
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from mpmverify import studies
from mpmverify.adapters.check_problem import check_problem, not_looked_at
from mpmverify.cli import cli
from mpmverify.problem import Constant, Fixed, Traction, Velocity

PROBLEMS = {f"{name}, {case.name}": case.problem for name in studies.NAMES for case in studies.get(name).cases}


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_closed_form_of_a_shipped_problem_solves_its_equations(name):
    assert check_problem(PROBLEMS[name]) == []


def with_field(problem, quantity, change):
    exact = problem.exact.fields[quantity]
    fields = {**problem.exact.fields, quantity: lambda X, t: change(exact(X, t), X, t)}
    return dataclasses.replace(problem, exact=dataclasses.replace(problem.exact, fields=fields))


def with_statement(problem, **changes):
    return dataclasses.replace(problem, problem=dataclasses.replace(problem.problem, **changes))


BAR, BOX, VORTEX = (PROBLEMS[name] for name in ("driven-bar, loaded-right", "plane-waves, box", "generalised-vortex, 1 rad"))
CUBOID, WAVE, SOFT = (PROBLEMS[name] for name in ("plane-waves, yeoh-cuboid", "advection, gaussian", "plane-waves, maxwell"))
LAYER, SPIN = PROBLEMS["plane-waves, clamped"], PROBLEMS["moving-bodies, disk"]
law = BOX.problem.material

WRONG = {
    "a velocity 1 % too large": (with_field(BOX, "velocity", lambda v, X, t: 1.01 * v), "v = du/dt"),
    "a wrong Poisson's ratio": (
        with_statement(BOX, material=dataclasses.replace(law, poissons_ratio=0.301)),
        "the stress of the material",
    ),
    "a wrong density": (with_statement(BOX, material=dataclasses.replace(law, density=2.001)), "rho dv/dt"),
    "no body force": (with_statement(VORTEX, body_force=None), "rho dv/dt"),
    "a stress of the wrong sign": (with_field(CUBOID, "stress", lambda s, X, t: -s), "the stress of the material"),
    "a transposed gradient": (
        with_field(
            CUBOID, "displacement_gradient", lambda H, X, t: H.reshape(*H.shape[:2], 3, 3).swapaxes(2, 3).reshape(H.shape)
        ),
        "H = du/dX",
    ),
    "another start": (with_statement(BOX, initial={**BOX.problem.initial, "velocity": np.zeros_like}), "the initial velocity"),
    "another load": (
        with_statement(BAR, boundary={**BAR.problem.boundary, "x+": Traction(Constant(1.0))}),
        "the traction at x+",
    ),
    "a moving wall": (
        with_statement(BOX, boundary={**BOX.problem.boundary, "y-": Velocity(Constant(0.1))}),
        "the velocity at y-",
    ),
    "a clamped wall": (with_statement(BOX, boundary={**BOX.problem.boundary, "x-": Fixed()}), "the velocity along x-"),
    "a slip wall": (with_statement(LAYER, boundary={**LAYER.problem.boundary, "y-": Velocity()}), "no shear traction at y-"),
    "a wave that runs too fast": (
        with_statement(
            WAVE, material=dataclasses.replace(WAVE.problem.material, velocity=1.01 * WAVE.problem.material.velocity)
        ),
        "u_t + a u_x",
    ),
    "another relaxation time": (
        with_statement(SOFT, material=dataclasses.replace(SOFT.problem.material, relaxation_time=0.29)),
        "the stress of the material",
    ),
    "a stress at a free circle": (
        with_field(VORTEX, "stress", lambda s, X, t: s + np.array([1.0, 1.0, 0.0])),
        "no traction at the circle",
    ),
    "NaN": (with_field(BOX, "stress", lambda s, X, t: s * np.nan), "is not finite"),
    "a missing axis": (with_field(BOX, "stress", lambda s, X, t: s[..., 0]), "has the shape"),
    "a slow spin": (with_field(SPIN, "velocity", lambda v, X, t: 0.999 * v), "v = du/dt"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_closed_form_is_told(name):
    problem, said = WRONG[name]
    remarks = check_problem(problem)
    assert any(said in remark.what for remark in remarks), remarks


def bare(problem, *quantities):
    fields = {name: field for name, field in problem.exact.fields.items() if name in quantities}
    return dataclasses.replace(problem, exact=dataclasses.replace(problem.exact, fields=fields))


@pytest.mark.parametrize("quantities", [("displacement",), ("displacement", "velocity"), ("velocity", "stress")])
@pytest.mark.parametrize("name", ["plane-waves, box", "generalised-vortex, 1 rad"])
def test_a_closed_form_with_few_fields_is_put_into_the_balance_of_momentum(quantities, name):
    right = bare(PROBLEMS[name], *quantities)
    if name.startswith("generalised") and "displacement" not in quantities:
        assert "the balance of momentum" in not_looked_at(right)[0]
        return
    assert check_problem(right) == []
    assert not any("momentum" in missing for missing in not_looked_at(right))
    heavier = dataclasses.replace(right.problem.material, density=1.3 * right.problem.material.density)
    remarks = check_problem(with_statement(right, material=heavier))
    assert any("rho dv/dt" in remark.what for remark in remarks), remarks


def test_what_a_closed_form_has_no_fields_for_is_said():
    assert not_looked_at(BOX) == not_looked_at(WAVE) == []
    assert len(not_looked_at(bare(BOX, "velocity"))) == 1
    assert len(not_looked_at(bare(BOX, "stress"))) == 2


MODULE = """
import dataclasses

from mpmverify.exact.vortex import generalised_vortex

RIGHT = generalised_vortex(0.5)
WRONG = dataclasses.replace(RIGHT, problem=dataclasses.replace(RIGHT.problem, body_force=None))
"""


@pytest.mark.parametrize(
    ("name", "status", "said"),
    [("RIGHT", 0, "every equation that was looked at holds"), ("WRONG", 1, "WRONG: rho dv/dt = Div P + rho b")],
)
def test_the_command_takes_a_problem(name, status, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / f"form_{name}.py").write_text(MODULE, encoding="utf-8")
    result = CliRunner().invoke(cli, ["check", f"form_{name}.py:{name}"])
    assert (result.exit_code, said in result.output) == (status, True), result.output

"""A first look at a solver: mistakes planted in right solutions are found with their cause, and right solutions are not."""

import dataclasses
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from click.testing import CliRunner

from mpmverify import studies
from mpmverify.adapters.check import check
from mpmverify.adapters.mistakes import Run
from mpmverify.cli import cli
from mpmverify.criteria import EnergyConserved, EnergyDecays, EnergyDrift, Stall
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.energies import energy_drift
from mpmverify.criteria.evidence import Level, evidence_of
from mpmverify.criteria.histories import moved_momentum
from mpmverify.errors import UsageError
from mpmverify.execution.verify import verify
from mpmverify.solvers.mpm import PIC, MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin

RIGHT = MaterialPoint("USL", formulation="total")


def case(study: str, name: str):
    (found,) = (one for one in studies.get(study).cases if one.name == name)
    return found


PLANE_WAVES = studies.get("plane-waves")
BOX, BAR, RING = case("plane-waves", "box"), case("driven-bar", "loaded-right"), case("generalised-vortex", "0.05 rad")


@dataclass(frozen=True)
class Mistaken:
    """The right solver, and a mistake in what it returns."""

    mistake: Callable
    name: str = "mistaken"
    orders: dict = dataclasses.field(default_factory=lambda: {"displacement": 2})
    conserves: frozenset = frozenset({"momentum"})

    def solve(self, problem, level):
        solution = RIGHT.solve(problem, level)
        return dataclasses.replace(solution, **self.mistake(solution, problem, level))


def field(quantity, change):
    return lambda s, p, at: {"fields": {**s.fields, quantity: change(s.fields[quantity], s, p, at)}}


def late(quantity, steps):
    """Values of the exact field some steps later, as a solver without any error would have them."""

    def change(values, s, p, at):
        return BOX.problem.exact.fields[quantity](s.reference, s.time + steps * s.dt)

    return field(quantity, change)


def history(names, change):
    return lambda s, p, at: {"histories": {n: change(v) if n in names else v for n, v in s.histories.items()}}


def without(*names):
    return lambda s, p, at: {"histories": {n: v for n, v in s.histories.items() if n not in names}}


P_WAVE = 7.0 * (1 - 0.3) / ((1 + 0.3) * (1 - 0.6))
MISTAKES = {
    "the sign of stress": (field("stress", lambda f, *_: -f), "the stress is -0.99", "positive in tension"),
    "units of stress": (field("stress", lambda f, *_: f / 1e6), "the stress is 9.9", "units"),
    "a wrong modulus": (field("stress", lambda f, *_: f * 7.0 / P_WAVE), "the stress is 0.74", "P waves"),
    "twice": (field("velocity", lambda f, *_: 2 * f), "the velocity is 2", "counted twice"),
    "an increment": (field("velocity", lambda f, s, *_: f * s.dt), "the velocity is 0.0", "an increment, not a rate"),
    "half a step": (late("velocity", -0.5), "the velocity fits the exact one half a step earlier", "return v + a dt/2"),
    "half a step late": (late("velocity", 0.5), "the velocity fits the exact one half a step later", "return v + a dt/2"),
    "a step": (late("displacement", 1.0), "the displacement fits the exact one a step later", "the time of another step"),
    "one array": (
        field("displacement", lambda f, *_: np.broadcast_to(f[-1], f.shape).copy()),
        "the displacement is the same at all output times",
        "store a copy",
    ),
    "nothing": (field("stress", lambda f, *_: 0 * f), "the stress is zero at all times", "never updated"),
    "exchanged": (
        field("velocity", lambda f, *_: f[..., ::-1].copy()),
        "velocity_x and velocity_y are exchanged",
        "velocity_x, velocity_y",
    ),
    "shear first": (
        field("stress", lambda f, *_: f[..., [2, 1, 0]].copy()),
        "stress_xx and stress_xy are exchanged",
        "stress_xx",
    ),
    "positions at the start": (
        lambda s, p, at: {"position": np.broadcast_to(s.reference, s.position.shape).copy()},
        "position - reference differs",
        "those of the start",
    ),
    "impulse of the other sign": (
        history(("impulse",), lambda v: -v),
        "momentum does not follow the impulse",
        "the impulse has the other sign",
    ),
    "impulse of one force": (history(("impulse",), lambda v: 0.9 * v), "momentum does not follow", "all external forces"),
    "momentum of the wrong mass": (
        history(("momentum_x", "impulse_x"), lambda v: 3 * v + 1.0),
        "momentum_x is not the sum",
        "density x volume x velocity",
    ),
    "no impulse": (without("impulse_y"), "lacks the history impulse_y", "leave the promise out"),
    "the field that is declared": (
        lambda s, p, at: {"fields": {"stress": s.fields["stress"]}},
        "an order of the displacement and returns none",
        "leave its order out",
    ),
    "volumes of cells": (
        lambda s, p, at: {"weight": s.weight * at.ppc**2},
        "its first weights sum to 6",
        "not of its cell",
    ),
    "masses": (lambda s, p, at: {"weight": 2 * s.weight}, "weights sum to 3", "not a mass"),
    "flat": (field("velocity", lambda f, *_: f[..., 0]), "expected", "has every array with its shape"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_found_with_its_cause(name):
    mistake, what, cause = MISTAKES[name]
    remarks = check(Mistaken(mistake), BAR if "impulse " in name else BOX)
    assert any(what in remark.what and cause in remark.cause for remark in remarks), remarks


@pytest.mark.parametrize(
    "solver", [RIGHT, MaterialPoint("MUSL"), MaterialPoint("USF", PIC), MaterialPoint("USL", basis="quadratic")]
)
@pytest.mark.parametrize("where", [BOX, BAR], ids=lambda one: one.name)
def test_nothing_is_found_in_a_right_solver(solver, where):
    assert check(solver, where) == []
    assert check(TaylorGalerkin(passes=3), BAR) == []


def test_an_error_that_no_level_changes_is_found():
    class Deaf(Mistaken):
        def solve(self, problem, level):
            coarsest = BOX.ladder_in_h().levels[0]
            return dataclasses.replace(RIGHT.solve(problem, dataclasses.replace(level, h=coarsest.h * 2)), dt=1e-3)

    remarks = check(Deaf(None), BOX)
    assert any("does not fall" in remark.what and "take h or dt from the level" in remark.cause for remark in remarks), remarks


@pytest.mark.parametrize(
    ("where", "unit", "lost"), [(BOX, 1e-8, True), (case("large-deformation", "square"), 1e-4, False)], ids=["small", "large"]
)
def test_an_error_that_grows_with_the_steps_may_be_that_of_single_precision_where_the_motion_is_small(where, unit, lost):
    def rounded(s, p, at):
        quantum = unit * len(s.histories["time"])
        u = np.round(s.fields["displacement"] / quantum) * quantum
        return {"position": s.reference + u, "fields": {**s.fields, "displacement": u}}

    remarks = check(Mistaken(rounded), where)
    (found,) = (remark for remark in remarks if "the error of the displacement does not fall" in remark.what)
    assert "solves another problem" in found.cause
    assert ("single precision" in found.cause) == lost


def test_an_exception_comes_with_the_lines_of_its_author():
    def fails(s, p, at):
        return {"weight": s.weight[:, : 1 / 0]}

    (remark,) = check(Mistaken(fails), BOX)
    assert remark.crashed
    assert "s.weight[:, : 1 / 0]" in remark.what
    assert "ZeroDivisionError" in remark.what
    assert "numpy" not in remark.what


def test_declarations_are_looked_at_first():
    orders, conserves = (
        dataclasses.replace(Mistaken(None), **{name: value}) for name, value in (("orders", 2), ("conserves", "mass"))
    )
    assert "orders is 2" in check(orders, BOX)[0].what
    assert "conserves is 'mass'" in check(conserves, BOX)[0].what


def test_the_histories_of_a_declared_energy_must_be_there():
    def kept(*left_out):
        return lambda s, *_: {"histories": {name: h for name, h in s.histories.items() if name not in left_out}}

    promised = frozenset({"energy"})
    assert check(Mistaken(kept(), conserves=promised), BOX) == []
    (remark,) = check(Mistaken(kept("external_work"), conserves=promised), BOX)
    assert remark.what == "it declares that it conserves energy, and lacks the history external_work"


def test_a_refusal_is_an_error():
    with pytest.raises(UsageError, match="cannot solve"):
        check(TaylorGalerkin(passes=1), RING)


MODULE = """
import dataclasses

from mpmverify import studies
from mpmverify.solvers.mpm import MaterialPoint

WAVES = studies.get("plane-waves")
TWO_CASES = dataclasses.replace(WAVES, name="waves", cases=tuple(c for c in WAVES.cases if c.name in ("box", "plane-stress")))

RIGHT = MaterialPoint("USL", formulation="total")


class Doubled:
    name, orders, conserves = "doubled", {"displacement": 2}, frozenset()

    def solve(self, problem, level):
        solution = RIGHT.solve(problem, level)
        return dataclasses.replace(solution, fields={**solution.fields, "stress": 2 * solution.fields["stress"]})


class Raising(Doubled):
    def solve(self, problem, level):
        raise KeyError("lost")
"""


@pytest.mark.parametrize(
    ("name", "status", "said"),
    [
        ("RIGHT", 0, "box: nothing found"),
        ("Doubled", 1, "waves, box: WRONG: the stress is 1.997 times the exact one. Likely cause: it is counted twice."),
        ("Raising", 3, "KeyError: 'lost'"),
        ("None", 2, "has no attribute 'None'"),
    ],
)
def test_the_command_says_what_is_wrong(name, status, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / f"checked_{name}.py").write_text(MODULE, encoding="utf-8")
    result = CliRunner().invoke(cli, ["check", f"checked_{name}.py:{name}", f"checked_{name}.py:TWO_CASES"])
    assert result.exit_code == status, result.output
    assert said in " ".join(result.output.split())
    assert "Traceback" not in result.output


def test_histories_of_zeros_balance_and_are_no_momentum():
    def zeros(s, p, at):
        silent = {"momentum", "impulse"}
        return {"histories": {name: 0 * values if name in silent else values for name, values in s.histories.items()}}

    found = {}
    finest = BAR.ladder_in_h().levels[3].h

    def some(s, p, at):
        return zeros(s, p, at) if at.h == finest else {}

    for name, mistake in (("right", lambda s, p, at: {}), ("zeros", zeros), ("some", some)):
        findings = verify(Mistaken(mistake, name), studies.get("driven-bar"), "loaded-right")
        found[name] = {finding.criterion: finding for finding in findings}
    (balance,) = (criterion for criterion in found["right"] if "momentum" in criterion)
    assert found["right"][balance].verdict == "PASS"
    for wrong in ("zeros", "some"):
        assert found[wrong][balance].verdict == "FAIL"
        assert "is not the sum of density x volume x velocity over the sample points" in found[wrong][balance].reason


def test_the_ends_alone_are_no_outputs():
    def ends(s, p, at):
        return {"time": s.time[[0, -1]], "position": s.position[[0, -1]], "weight": s.weight[[0, -1]]} | {
            "fields": {name: values[[0, -1]] for name, values in s.fields.items()}
        }

    (finding, *_) = verify(Mistaken(ends), studies.get("driven-bar"), "loaded-right")
    assert finding.verdict == "ERROR"
    assert "it returned 2 outputs: the problem asks for 33, and 5 are needed" in finding.reason


# Harness: what criteria and readers measure.


def solved(case_, level: int = 0):
    setting = Setting(case_.problem, case_.ladder_in_h().levels[level])
    return RIGHT.solve(case_.problem.problem, setting.discretisation), setting


def test_heat_counts_in_the_energy_of_viscous_bodies_alone():
    solution, setting = solved(BOX)
    warm = dataclasses.replace(solution, histories={**solution.histories, "dissipated_energy": solution.histories["time"]})
    assert energy_drift(warm, setting) == energy_drift(solution, setting)


@pytest.mark.parametrize("criterion", [EnergyDrift(1.8, "s"), EnergyConserved("s"), EnergyDecays("s")])
def test_energies_that_are_made_up_are_not_conserved(criterion):
    """Constant ones are not those of the points, and an external work without a load takes nothing from the balance."""
    promised = frozenset({"energy"})

    def constant(s, *_):
        one, zero = np.ones_like(s.histories["time"]), np.zeros_like(s.histories["time"])
        return {"histories": {**s.histories, "kinetic_energy": one, "strain_energy": zero, "external_work": zero}}

    (finding,) = verify(Mistaken(constant), PLANE_WAVES, "box", criteria=[criterion])
    assert finding.verdict == "FAIL"
    assert finding.reason.startswith(
        "the kinetic energy is not the sum of mass x |velocity|^2 / 2 over the sample points: off by up to"
    )
    assert "of the points" in check(Mistaken(constant, conserves=promised), BOX)[0].what

    def lost(s, *_):
        lost = 0.3 * s.histories["time"] / s.histories["time"][-1]
        energy = (1 - lost) * s.histories["strain_energy"]
        work = energy + s.histories["kinetic_energy"]
        return {"histories": {**s.histories, "strain_energy": energy, "external_work": work - work[0]}}

    (finding,) = verify(Mistaken(lost), PLANE_WAVES, "box", criteria=[criterion])
    assert finding.verdict == "FAIL"
    assert check(Mistaken(lost, conserves=promised), BOX) == []


def test_right_energies_of_rare_samples_and_of_solvers_without_velocities_are_not_blamed():
    def of_displacements(s, *_):
        return {"fields": {"displacement": s.fields["displacement"]}}

    (finding,) = verify(Mistaken(of_displacements), PLANE_WAVES, "box", criteria=[EnergyDrift(1.5, "s")])
    assert finding.verdict == "PASS"
    rare = MaterialPoint(record_every=50)
    (finding,) = verify(rare, studies.get("axial-vibration"), "small-strain", criteria=[EnergyDrift(1.8, "s")])
    assert "sample points" not in finding.reason


@pytest.mark.parametrize("criterion", [EnergyDrift(1.8, "s"), EnergyConserved("s"), EnergyDecays("s")])
def test_a_large_strain_energy_or_external_work_hides_nothing(criterion):
    def large(s, *_):
        one = np.ones_like(s.histories["time"])
        return {"histories": {**s.histories, "kinetic_energy": 0 * one, "strain_energy": 1e20 * one, "external_work": 0 * one}}

    def worked(s, *_):
        time = s.histories["time"]
        return {"histories": {**s.histories, "external_work": -(1e6 * np.linspace(0, 1, len(time)) ** 2)}}

    for lie in (large, worked):
        (finding,) = verify(Mistaken(lie), PLANE_WAVES, "box", criteria=[criterion])
        assert finding.verdict == "FAIL"


def test_what_moves_is_of_the_mass_at_the_start():
    solution, setting = solved(BOX)
    heavier = solution.weight.copy()
    heavier[-1] *= 2
    density = setting.problem.problem.material.density
    assert moved_momentum(dataclasses.replace(solution, weight=heavier), density) == moved_momentum(solution, density)


def test_a_stall_has_a_known_size_on_both_of_the_finest_levels():
    h, errors = np.array([0.1, 0.05, 0.025, 0.0125]), np.array([0.5, 0.5, 0.5, 0.15])
    stall = Stall("u", "L2", 5.0, 0.1, 0.2, "")
    levels = [
        Level("hill", "s", "nu", size, 0.5, 1, "", dt=size / 2, errors={"u": (np.full(4, e), np.ones(4))}, outcome="completed")
        for size, e in zip(h, errors, strict=True)
    ]
    assert stall.judge(evidence_of(levels))[0] == "FAIL"


def test_a_product_counts_shear_stresses_twice():
    solution, setting = solved(BOX)
    run = Run(setting.problem, setting.discretisation, solution, ())
    shear = np.zeros_like(solution.fields["stress"])
    shear[..., 2] = 1.0
    normal = np.zeros_like(shear)
    normal[..., 0] = 1.0
    assert run.product("stress", shear, shear) == pytest.approx(2 * run.product("stress", normal, normal))

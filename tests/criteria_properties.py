"""Properties of the criteria on histories and outcomes, each a function of a copy of the package."""

from collections.abc import Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
from convergence_properties import COARSEST, FINEST, H, same
from judgement_properties import evidence, sampled

from mpmverify.criteria import evidence as stored
from mpmverify.criteria.criterion import Setting
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.judgement.findings import judge_criterion
from mpmverify.problem import Discretisation, LinearElastic, Problem, Traction
from mpmverify.solution import Solution

# Properties of the criteria on histories and outcomes.

MATERIAL = LinearElastic(3.0, 2.0)
BAR = Problem("bar", (0.0,), (1.0,), MATERIAL, {"x-": Traction(), "x+": Traction()}, 1.0)
SETTING = Setting(VerificationProblem(BAR, ExactSolution({}, ""), "", ()), Discretisation(0.5, 0.5))
STOCKS = ("mass", "momentum", "kinetic_energy", "strain_energy")


def verdict_on(criterion: Any, *solutions: Solution) -> tuple[str, str]:
    """Verdict and reason on a series of solutions, one for each level."""
    return verdict_on_metrics(criterion, *(criterion.measure(solution, SETTING) for solution in solutions))


def verdict_on_metrics(criterion: Any, *measured: Mapping[str, float]) -> tuple[str, str]:
    names = {name for metrics in measured for name in metrics}
    metrics = {name: np.array([entry.get(name, np.nan) for entry in measured]) for name in names}
    h = 0.5 ** np.arange(len(measured))
    levels = stored.Evidence(h, h, h, np.ones(len(h), int), ("completed",) * len(h), metrics=metrics)
    verdict, reason = judge_criterion(criterion, levels)
    return verdict.value, reason


def with_history(solution: Solution, **histories: Any) -> Solution:
    return replace(solution, histories=dict(solution.histories) | histories)


def histories_are_sums_of_the_fields(c: ModuleType) -> None:
    sound, criterion = sampled(), c.FieldSums(STOCKS, "")
    assert verdict_on(criterion, sound)[0] == "PASS"
    for stock in STOCKS:
        wrong = with_history(sound, **{stock: sound.histories[stock] * (1 + 1e-9)})
        assert verdict_on(criterion, wrong)[0] == "FAIL"
        assert verdict_on(criterion, sound, wrong)[0] == "FAIL"
        nothing = with_history(sound, **{stock: np.zeros(5)})
        assert verdict_on(criterion, nothing)[0] == "FAIL"
    later = replace(sound, fields=dict(sound.fields) | {"velocity": sound.fields["velocity"][[1, 1, 2]]})
    assert verdict_on(criterion, later)[0] == "FAIL"
    part = c.FieldSums(STOCKS[:1], "").measure(sound, SETTING)
    assert verdict_on_metrics(criterion, part)[0] == "ERROR", "measured before another stock was declared"


def a_zero_momentum_with_zero_impulse_is_detected(c: ModuleType) -> None:
    empty = with_history(sampled(), momentum=np.zeros(5), impulse=np.zeros(5))
    assert verdict_on(c.Balance("momentum", "impulse", ""), empty)[0] == "FAIL"
    verdict, reason = verdict_on(c.FieldSums(("mass", "momentum"), ""), empty)
    assert verdict == "FAIL"
    assert "of momentum" in reason


def round_off_of_the_momentum_scales_with_what_moves(c: ModuleType) -> None:
    """Momenta that cancel leave round-off of their own size, whatever histories are there, and a defect of 1e-9 of it is none."""
    sound, v = sampled(), np.array([[3.0, -3.0, 0.0]] * 3)[:, :, None]
    sound = replace(sound, weight=np.full((3, 3), 1 / 3), fields={"velocity": v})
    moved = sound.reference + sound.time[:, None, None] * v
    for fields in ({"velocity": v}, {}):
        for defect, expected in ((1e-16, "PASS"), (1e-9, "FAIL")):
            balanced = replace(
                sound, position=moved, fields=fields, histories={"time": sound.histories["time"], "impulse": np.zeros(5)}
            )
            off = with_history(balanced, momentum=np.array([0.0, 0.0, defect, 0.0, 0.0]))
            size = MATERIAL.density * (3.0 + 3.0) / 3
            same(c.Balance("momentum", "impulse", "").measure(off, SETTING)["momentum_defect"], defect / size, rtol=1e-12)
            assert verdict_on(c.Balance("momentum", "impulse", ""), off)[0] == expected


def missing_fields_and_histories_are_named_and_do_not_pass(c: ModuleType) -> None:
    sound, criterion = sampled(), c.FieldSums(STOCKS, "")
    for quantity in ("velocity", "stress"):
        poorer = replace(sound, fields={name: values for name, values in sound.fields.items() if name != quantity})
        for solutions in ([poorer], [sound, poorer]):
            verdict, reason = verdict_on(criterion, *solutions)
            assert verdict == "ERROR"
            assert reason.endswith(f"the solver does not return the {quantity}")
    for stock in STOCKS:
        verdict, reason = verdict_on(
            criterion, replace(sound, histories={k: h for k, h in sound.histories.items() if k != stock})
        )
        assert verdict == "ERROR"
        assert reason.startswith(f"{stock} cannot be compared")
        assert "does not return this history" in reason
    verdict, reason = verdict_on(criterion, replace(sound, time=np.array([0.0, 0.6, 1.0])))
    assert verdict == "ERROR"
    assert "output time" in reason
    rest = replace(sound, fields={name: 0 * values for name, values in sound.fields.items()})
    verdict, reason = verdict_on(criterion, with_history(rest, **{stock: np.zeros(5) for stock in STOCKS[1:]}))
    assert verdict == "ERROR"
    assert "zero throughout" in reason


def energy_that_increases_again_does_not_decay(c: ModuleType) -> None:
    def falling(*total: float) -> Solution:
        moved = sampled()
        strain = 10 + np.array(total) - moved.histories["kinetic_energy"]
        return with_history(moved, strain_energy=strain, external_work=np.zeros(5))

    assert verdict_on(c.EnergyDecays(""), falling(5, 4, 3, 3, 1))[0] == "PASS"
    assert verdict_on(c.EnergyDecays(""), falling(5, 2, 3, 3, 1))[0] == "FAIL"
    assert verdict_on(c.EnergyDecays(""), falling(5, 4, 3, 3, 3.1))[0] == "FAIL"


def energies_that_are_made_up_do_not_balance(c: ModuleType) -> None:
    """Kinetic energies of another motion, and losses that are called external work of a body without loads."""
    sound = sampled()
    kinetic = sound.histories["kinetic_energy"]
    balanced = {"strain_energy": 10 - kinetic, "external_work": np.zeros(5)}
    lossy = {"strain_energy": 10 - kinetic - np.linspace(0, 1, 5), "external_work": -np.linspace(0, 1, 5)}
    for criterion in (c.EnergyConserved(""), c.EnergyDrift(1.8, "")):
        assert verdict_on(criterion, with_history(sound, **balanced))[0] == "PASS"
        assert verdict_on(criterion, with_history(sound, **lossy))[0] != "PASS"
    assert verdict_on(c.EnergyConserved(""), with_history(sound, **lossy))[0] == "FAIL"
    for criterion in (c.EnergyConserved(""), c.EnergyDrift(1.8, ""), c.EnergyDecays("")):
        assert verdict_on(criterion, with_history(sound, **balanced, kinetic_energy=9 * kinetic))[0] == "FAIL"
        halved = {"kinetic_energy": 2 * kinetic, "strain_energy": kinetic.max() * 2.5 - 2 * kinetic}
        assert verdict_on(criterion, with_history(sound, **balanced | halved))[0] == "FAIL", "kinetic energies without the half"
        hidden = with_history(sound, kinetic_energy=0 * kinetic, strain_energy=1e20 + 0 * kinetic, external_work=0 * kinetic)
        assert verdict_on(criterion, hidden)[0] == "FAIL"
        assert (
            verdict_on(c.EnergyDecays(""), with_history(sound, **balanced | {"external_work": -np.linspace(0, 1, 5)}))[0]
            == "FAIL"
        )
        constant = with_history(sound, kinetic_energy=10 + 0 * kinetic, strain_energy=0 * kinetic, external_work=0 * kinetic)
        assert verdict_on(criterion, constant)[0] == "FAIL"


def a_stall_has_a_known_size(c: ModuleType) -> None:
    """A body that never moves stalls at the error 1; of the two finest levels both count, and of a size the finest one alone."""
    stall, size = c.Stall("u", "L2", 0.5, 0.05, 0.2, ""), c.Size("u", "L2", 0.05, 0.2, "")
    for error, expected in ((0.1, "PASS"), (1.0, "FAIL"), (0.01, "FAIL")):
        assert stall.judge(evidence(stored, 0 * H + error))[0] == expected
        assert size.judge(evidence(stored, np.where(FINEST, error, 0.1 + H)))[0] == expected
        assert stall.judge(evidence(stored, np.where(H == 0.04, error, 0.1)))[0] != ("FAIL" if expected == "PASS" else "PASS")
    assert c.Size("u", "L2", 0.05, 0.2, "", 0.5).judge(evidence(stored, np.where(COARSEST, 0.1, 1.0)))[0] == "PASS"
    assert c.Size("u", "L2", 0.05, 0.2, "", 0.3).judge(evidence(stored, 0 * H + 0.1))[0] == "INCONCLUSIVE"


def unstable_runs_must_be_reported_as_unstable(c: ModuleType) -> None:
    def ended(*outcomes: str) -> str:
        nu = np.full(len(outcomes), 1.1)
        return c.Unstable(1.0, "").judge(stored.Evidence(nu, nu, nu, nu.astype(int), outcomes))[0].value

    assert ended("unstable; at step 2", "unstable; at step 5") == "PASS"
    assert ended("unstable; at step 2", "completed") == "FAIL"
    assert ended("unstable; at step 2", "crashed; it raised") == "ERROR"
    assert ended("non-finite; at step 2") == "ERROR"


def totals_are_exact_at_every_step(c: ModuleType) -> None:
    exact = ExactSolution({}, "", totals={"momentum": lambda t: 3.0 * t[:, None]})
    setting = Setting(VerificationProblem(BAR, exact, "", ()), Discretisation(0.5, 0.5))
    criterion, sound = c.ExactTotal("momentum", ""), sampled()
    for k in range(6):
        momentum = 3.0 * sound.histories["time"] + 1e-9 * (np.arange(5) == k)
        measured = criterion.measure(with_history(sound, momentum=momentum), setting)
        assert verdict_on_metrics(criterion, measured)[0] == ("FAIL" if k < 5 else "PASS")

"""`verify`: the orders and invariants that a solver declares must be measured, and nothing passes without being judged."""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from faulty_solvers import BEHAVIOURS, Scripted, ladder, plan, study, transported
from hypothesis import given
from hypothesis import strategies as st

from mpmverify import studies
from mpmverify.convergence import verdict
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Balance, Dispersion, EnergyConserved, EnergyDrift, Exact, ExactTotal, Order
from mpmverify.criteria.evidence import evidence_of
from mpmverify.criteria.expectations import MARGIN, expectations, order_band
from mpmverify.errors import UsageError
from mpmverify.exact.advection import Gaussian, Inflow, advection
from mpmverify.exact.elastic_bar import RampLoad, SmoothPulse, StepLoad, elastic_bar
from mpmverify.execution.runner import run
from mpmverify.execution.verify import verify
from mpmverify.problem import Constant, Discretisation, Outflow
from mpmverify.solution import ADVICE
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.study import Refinement, design, halving, in_time

HILL = study()


@dataclass(frozen=True)
class Claiming(Scripted):
    """Scripted solver with declared orders and invariants that may differ from the real ones."""

    claimed: float = 2.0
    of: str = "u"
    kept: tuple[str, ...] = ("mass",)

    @property
    def orders(self):
        return {self.of: self.claimed} if self.of else {}

    @property
    def conserves(self):
        return frozenset(self.kept)


class Plain:
    """Solver that is not a dataclass."""

    name = "plain"
    orders = {"u": 2.0}  # noqa: RUF012 - as a user would write it
    conserves = frozenset()

    def solve(self, problem, discretisation):
        return transported(problem, discretisation, discretisation.h**2)


def verdicts(solver, **choices):
    return {finding.criterion: finding.verdict for finding in verify(solver, HILL, **choices)}


# Expectations.


@given(st.floats(0.5, 8.0), st.floats(1.0, 20.0))
def test_the_band_of_orders_does_not_rise_with_fewer_derivatives(order, derivatives):
    low, high = order_band(order, derivatives)
    smooth = order_band(order, math.inf)
    assert smooth == pytest.approx((order - MARGIN, order + MARGIN))
    assert low < high
    assert low <= smooth[0]
    assert high <= smooth[1]
    rougher = order_band(order, derivatives / 2 + 0.5)
    assert rougher[0] <= low
    assert rougher[1] <= high


@pytest.mark.parametrize(
    ("order", "derivatives", "theory"), [(1, 1, 1 / 2), (1, 2, 1), (2, 1, 1 / 2), (2, 1, 5 / 8), (2, 2, 4 / 3), (2, 3, 2)]
)
def test_orders_from_the_literature_are_inside_the_band_by_a_margin(order, derivatives, theory):
    low, high = order_band(order, derivatives)
    assert low + 0.1 < theory < high - 0.1


@pytest.mark.parametrize(
    ("problem", "expected"),
    [
        (elastic_bar(StepLoad()), {"velocity": ("L1", 1 / 3, 2 / 3 + MARGIN), "displacement": ("L1", 1.0, 4 / 3 + MARGIN)}),
        (elastic_bar(RampLoad()), {"velocity": ("L1", 1.0, 4 / 3 + MARGIN), "displacement": ("L1", 5 / 3, 2 + MARGIN)}),
        (
            elastic_bar(SmoothPulse()),
            {"velocity": ("L2", 2 - MARGIN, 2 + MARGIN), "displacement": ("L2", 2 - MARGIN, 2 + MARGIN)},
        ),
    ],
    ids=["step", "ramp", "pulse"],
)
def test_expected_orders_follow_from_the_smoothness_of_each_quantity(problem, expected):
    @dataclass(frozen=True)
    class Bar(Scripted):
        @property
        def orders(self):
            return {"u": 1.0, "velocity": 2.0, "displacement": 2.0}

    found = {
        c.quantity: (c.norm, c.low, c.high)
        for c in expectations(Bar(), problem, "L1" if np.isfinite(problem.exact.derivatives) else "L2")
        if isinstance(c, Order)
    }
    assert found.keys() == expected.keys(), "the problem has no field u, so that its order is not expected"
    for quantity, (norm, *edges) in expected.items():
        assert found[quantity][0] == norm
        assert found[quantity][1:] == pytest.approx(edges, abs=1e-3)


def test_a_declared_energy_is_kept_at_the_order_of_the_motion_less_a_half():
    def lows(problem, kept, **choices):
        solver = Claiming(kept=kept, **choices)
        return [c.low for c in expectations(solver, problem, "L2") if isinstance(c, EnergyDrift)]

    smooth = studies.get("axial-vibration").cases[0].problem
    assert lows(smooth, ("energy",), of="velocity") == [pytest.approx(2.0 - 0.15 - 0.5)]
    assert lows(smooth, ("mass", "momentum"), of="velocity") == []
    assert lows(elastic_bar(), ("energy",), of="velocity") == [0.25], "a jump leaves the order next to nothing"
    assert lows(advection(Gaussian()), ("energy",), of="u") == [], "a scalar has none"


def test_the_expected_balances_depend_on_the_problem():
    def balances(problem, kept=("mass", "momentum")):
        solver = Claiming(of="u" if "u" in problem.exact.fields else "velocity", kept=kept)
        return [(c.stock, c.source_term) for c in expectations(solver, problem, "L2") if isinstance(c, Balance)]

    assert balances(elastic_bar()) == [("mass", ""), ("momentum", "impulse")]
    assert balances(elastic_bar(), ("momentum",)) == [("momentum", "impulse")]
    periodic = advection(Gaussian())
    assert balances(periodic) == [("mass", "")]
    boundary = {"x-": Inflow(Constant(0.0)), "x+": Outflow()}
    assert balances(replace(periodic, problem=replace(periodic.problem, boundary=boundary))) == [("mass", "inflow")]


@pytest.mark.parametrize("case", ["step", "ramp", "pulse"])
def test_taylor_galerkin_keeps_its_declared_orders(case):
    """Taylor-Galerkin declares order 2 of stress and velocity: at a jump, at a kink and on smooth data."""
    from mpmverify.solvers.taylor_galerkin import TaylorGalerkin

    found = verify(TaylorGalerkin(passes=1), studies.get("elastic-bar"), case)
    assert [finding.verdict for finding in found] == [Verdict.PASS] * 3


def test_taylor_galerkin_with_another_declared_order_fails_on_smooth_data():
    """At a jump the orders of all schemes are close together and tell little."""
    from mpmverify.solvers.taylor_galerkin import TaylorGalerkin

    @dataclass(frozen=True)
    class Boasting(TaylorGalerkin):
        @property
        def orders(self):
            return {"stress": 3.0, "velocity": 1.0}

    found = verify(Boasting(passes=1), studies.get("elastic-bar"), "pulse")
    assert [finding.verdict for finding in found] == [Verdict.FAIL, Verdict.FAIL, Verdict.PASS]


@dataclass(frozen=True)
class Declaring:
    """Solver with any declared orders and invariants."""

    orders: Any = field(default_factory=lambda: {"u": 2.0})
    conserves: Any = frozenset({"mass"})
    name: str = "declaring"

    def solve(self, problem, discretisation):
        return transported(problem, discretisation, discretisation.h**2)


# Verdicts.


def test_a_solver_with_correct_declarations_passes():
    assert verdicts(Scripted()) == {"order of u in L2-max in [1.85, 2.15]": Verdict.PASS, "mass conserved": Verdict.PASS}
    assert verdicts(Plain()) == {"order of u in L2-max in [1.85, 2.15]": Verdict.PASS}


@pytest.mark.parametrize("claimed", [1.0, 1.7, 2.3, 3.0])
def test_a_measured_order_that_differs_from_the_declared_one_fails(claimed):
    found = verify(Claiming(claimed=claimed), HILL)
    assert [finding.verdict for finding in found] == [Verdict.FAIL, Verdict.PASS]


@pytest.mark.parametrize("behaviour", sorted(BEHAVIOURS.keys() - {"good", "dies", "hangs", "dawdles"}))
def test_a_failed_run_is_an_error_with_its_outcome(behaviour):
    found = verify(Scripted(behaviour), HILL)
    assert [finding.verdict for finding in found] == [Verdict.ERROR] * 2
    for finding in found:
        assert "\n" not in finding.reason
        assert "every level: " in finding.reason or "h=0.03125: " in finding.reason


def test_one_failed_level_makes_the_verdict_an_error():
    assert set(verdicts(Scripted("nan", below=0.04)).values()) == {Verdict.ERROR}


def test_a_missing_quantity_or_history_is_an_error():
    assert verdicts(Claiming(kept=("mass",), of="u"), criteria=[Order("velocity", "L2", 1, 3, "ours")]) == {
        "order of velocity in L2 in [1, 3]": Verdict.ERROR
    }

    class Forgetful(Plain):
        conserves = frozenset({"mass"})

        def solve(self, problem, discretisation):
            good = super().solve(problem, discretisation)
            return replace(good, histories={"time": good.histories["time"]})

    assert verdicts(Forgetful())["mass conserved"] is Verdict.ERROR


ENERGIES = {"kinetic_energy", "strain_energy", "external_work"}


@pytest.mark.parametrize(
    ("criterion", "needed"),
    [
        (Balance("momentum", "impulse", "s"), {"momentum", "impulse"}),
        (Balance("angular_momentum", "", "s"), {"angular_momentum"}),
        (ExactTotal("momentum", "s"), {"momentum"}),
        (ExactTotal("angular_momentum", "s"), {"angular_momentum"}),
        (EnergyDrift(1.8, "s"), ENERGIES),
        (EnergyConserved("s"), ENERGIES),
    ],
)
@pytest.mark.parametrize("stored", [False, True])
def test_the_reason_names_the_history_that_the_solver_does_not_return(criterion, needed, stored, tmp_path):
    if stored:
        (judged,) = run([study(criteria=(criterion,))], plan(tmp_path))
        finding = judged.findings[0]
    else:
        (finding,) = verify(Scripted(), HILL, criteria=[criterion])
    assert finding.verdict is Verdict.ERROR
    assert "was not measured on this series: the solver does not return it" in finding.reason
    assert all(f"'{name}'" in finding.reason for name in needed)


def test_the_reason_names_the_fields_that_both_solutions_have():
    (finding,) = verify(Scripted(), HILL, criteria=[Order("velocity", "L2", 1, 3, "ours")])
    cause = "'velocity' was not measured on this series: the solver does not return it, the exact solution does not have it (both have u)"
    assert finding.reason.startswith(cause)
    (finding,) = verify(Scripted(), HILL, criteria=[Dispersion("tg-lumped", "velocity", 1.0, 1e-9, "ours")])
    assert "made of the field 'velocity' of a bar at every time step, was not measured on this series" in finding.reason


def test_the_advice_to_an_unstable_run_holds_for_a_scalar_that_has_no_energy():
    assert all("energy" not in advice for advice in ADVICE.values())


def test_a_solver_may_declare_another_order_of_coarse_levels():
    @dataclass(frozen=True)
    class Falling(Claiming):
        claimed: float = 1.0

        @property
        def coarse_orders(self):
            return {"u": 2.5}

    assert verdicts(Falling()) == {"order of u in L2-max in [0.85, 2.65]": Verdict.PASS, "mass conserved": Verdict.PASS}


@dataclass(frozen=True)
class Rounding(Plain):
    """Second order down to the rounding of single precision, where its error rises again."""

    told: float = 1e-12

    @property
    def round_off(self):
        return self.told

    @property
    def conserves(self):
        return frozenset({"mass"})

    def solve(self, problem, discretisation):
        h = discretisation.h
        return transported(problem, discretisation, 0.1 * h**2 + 2e-7 * (1 + np.sin(50 / h)))


def test_a_solver_may_declare_the_rounding_of_single_precision():
    """Its order is judged above the rounding, and what it conserves to it; at the rounding of double precision it has none."""
    judged = verify(Rounding(told=5e-6), HILL, refinement=ladder(8))
    assert {f.criterion: f.verdict for f in judged} == {
        "order of u in L2-max in [1.85, 2.15] above 5e-06": Verdict.PASS,
        "mass conserved to 5e-06": Verdict.PASS,
    }
    assert "at round-off" in judged[0].reason
    (untold, _) = verify(Rounding(), HILL, refinement=ladder(8))
    assert untold.verdict is not Verdict.PASS
    (bound,) = {c.bound for c in expectations(Rounding(told=5e-6), HILL.cases[0].problem, "L2-max") if isinstance(c, Balance)}
    assert bound == 5e-6


def test_round_off_on_a_coarse_level_is_no_order():
    """It is where a wrong error happens to vanish: the finer ones say nothing of it."""
    found, reason = verdict([1 / 8, 1 / 16, 1 / 32, 1 / 64], [9e-6, 8e-3, 2e-3, 5e-4], band=(1.85, 2.15), round_off=1e-5)
    assert found is Verdict.INCONCLUSIVE
    assert "at h=0.125 the error is at round-off, and not on finer levels" in reason


@pytest.mark.parametrize("orders", [{"u": -3.0}, {"u": "1"}, {"entropy": 1.0}, ["u"]])
def test_orders_of_coarse_levels_are_checked_as_formal_ones(orders):
    class Coarse(Plain):
        coarse_orders = orders

    with pytest.raises(UsageError, match=r"declares (the order|its coarse orders)"):
        verify(Coarse(), HILL)


def test_rounding_hides_no_error_of_a_percent():
    with pytest.raises(UsageError, match=r"declares the round-off 0\.01: it must be a relative error up to 1e-05"):
        verify(Rounding(told=0.01), HILL)
    with pytest.raises(UsageError, match=r"a relative error of 0\.01 is not round-off: give at most 1e-05"):
        Order("u", "L2", 1.9, 2.1, "", 0.01)


def test_a_case_may_know_that_its_orders_scatter():
    (case,) = HILL.cases
    scattered = replace(HILL, cases=(replace(case, margin=0.3),))
    assert [f.criterion for f in verify(Plain(), scattered)] == ["order of u in L2-max in [1.7, 2.3]"]


def test_an_order_is_inconclusive_for_zero_errors_or_two_levels():
    class Perfect(Plain):
        def solve(self, problem, discretisation):
            return transported(problem, discretisation, 0.0)

    assert set(verdicts(Perfect()).values()) == {Verdict.INCONCLUSIVE}
    assert verdicts(Perfect(), criteria=[Exact("u", "Linf", 1e-12, "exact by construction")]) == {
        "u exact in Linf to 1e-12": Verdict.PASS
    }
    assert set(verdicts(Plain(), refinement=ladder(2)).values()) == {Verdict.INCONCLUSIVE}
    assert set(verdicts(Plain(), refinement=ladder(2), tier="full").values()) == {Verdict.PASS}


def test_verify_reuses_no_earlier_run():
    """A solver in a rebuilt library has the same Python source."""
    behaviour = ["good"]

    class Rebuilt(Plain):
        def solve(self, problem, discretisation):
            return BEHAVIOURS[behaviour[0]](super().solve(problem, discretisation))

    assert set(verdicts(Rebuilt()).values()) == {Verdict.PASS}
    behaviour[0] = "nan"
    assert set(verdicts(Rebuilt()).values()) == {Verdict.ERROR}


@pytest.mark.parametrize(
    ("solver", "choices", "sentence"),
    [
        (object(), {}, "object is not a solver: it lacks name, orders, conserves, solve"),
        (Scripted, {}, "Scripted is a class: give an instance of it"),
        (Declaring(orders=[("u", 2.0)]), {}, "declares its orders as [('u', 2.0)]: give a mapping of quantity to order"),
        (Declaring(orders={"u": True}), {}, "declares the order True of u: an order must be positive and finite"),
        (Declaring(orders={"u": "2"}), {}, "declares the order '2' of u: an order must be positive and finite"),
        (Declaring(orders={3: 2.0}), {}, "declares the order of the unknown quantity 3: choose from u"),
        (Declaring(conserves="mass"), {}, "declares that it conserves 'mass': give a set of names"),
        (Declaring(conserves={"mass", 3}), {}, "conserves the unknown 3: choose from mass, momentum"),
        (Scripted(), {"tier": "Full"}, "there is no tier 'Full': choose from quick, full"),
        (Claiming(of=""), {}, "declares no order of u, the fields of the problem"),
        (Claiming(of="stress"), {}, "declares no order of u, the fields of the problem"),
        (
            Claiming(of="temperature"),
            {},
            "declares the order of the unknown quantity 'temperature': choose from u, displacement",
        ),
        (Claiming(claimed=math.nan), {}, "declares the order nan of u: an order must be positive and finite"),
        (Claiming(claimed=0.0), {}, "declares the order 0.0 of u: an order must be positive and finite"),
        (Claiming(kept=("mass", "charm")), {}, "conserves the unknown 'charm': choose from mass, momentum"),
        (Scripted(), {"criteria": ()}, "no criterion is given for solver 'scripted-good'"),
        (Scripted(), {"case": "valley"}, "study 'scripted' has no case 'valley': choose from hill"),
        (Plain(), {"timeout": 60.0, "criteria": None}, None),
    ],
)
def test_a_usage_error_says_why_nothing_can_be_judged(solver, choices, sentence):
    if sentence is None:
        local = type("Local", (Plain,), {})()
        with pytest.raises(
            UsageError, match=r"cannot be sent to a worker process .*: define it in a module, or give no timeout"
        ):
            verify(local, HILL, **choices)
        return
    with pytest.raises(UsageError) as caught:
        verify(solver, HILL, **choices)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_study_with_several_cases_needs_the_name_of_one():
    with pytest.raises(UsageError, match="study 'elastic-bar' has several cases: choose from step, ramp, pulse"):
        verify(Scripted(), studies.get("elastic-bar"))


@pytest.mark.parametrize(
    "refinement",
    [in_time(1.0, 8, quick=3, full=3, courant=0.5), halving(1.0, 8, quick=3, full=3, courant=0.5, courant_power=1)],
)
def test_declared_orders_need_a_ladder_in_h_at_one_courant_number(refinement):
    """On any other refinement a scheme of another order could pass, or the correct one fail."""
    with pytest.raises(UsageError, match=r"is not a ladder in h at one Courant number, .* give such a ladder by refinement="):
        verify(Plain(), HILL, refinement=refinement)
    given = verify(Plain(), HILL, refinement=refinement, criteria=[Order("u", "L2", 1.85, 2.15, "ours")])
    assert [finding.refinement for finding in given] == [refinement.label]


def test_a_design_is_refused_and_by_default_the_first_ladder_in_h_is_used():
    sources = studies.get("error-sources")
    with pytest.raises(UsageError, match="'3 h x 4 dt' on case 'h-and-dt' is not a ladder in h"):
        verify(MaterialPoint(), sources, "h-and-dt", refinement=sources.cases[0].series[0].refinement)
    (case,) = HILL.cases
    both = (replace(case.series[0], refinement=design(1.0, cells=(8, 16), courant=(0.5, 0.25))), *case.series)
    found = verify(Plain(), replace(HILL, cases=(replace(case, series=both),)))
    assert [(finding.refinement, finding.verdict) for finding in found] == [(ladder().label, Verdict.PASS)]


def test_with_a_time_limit_a_run_that_hangs_or_exits_is_an_error():
    for behaviour, outcome in (("hangs", "timed out; no result within 1 s"), ("dies", "the process died with exit status 3")):
        found = verify(Scripted(behaviour, below=0.04), HILL, timeout=1.0)
        assert [finding.verdict for finding in found] == [Verdict.ERROR] * 2
        assert all(outcome in finding.reason for finding in found)
    assert set(verdicts(Scripted(), timeout=60.0).values()) == {Verdict.PASS}


# Evidence.


def test_a_quantity_missing_on_one_level_is_absent_and_a_missing_metric_is_nan():
    from mpmverify.criteria.evidence import Level

    norms = (np.ones(4), np.ones(4))
    levels = [
        Level("c", "s", "r", 0.2, 0.5, 1, "a", errors={"u": norms, "stress": norms}, metrics={"mass_defect": 0.0}),
        Level("c", "s", "r", 0.1, 0.5, 1, "b", errors={"u": norms}),
    ]
    seen = evidence_of(levels)
    assert seen.error.keys() == seen.reference.keys() == {"u"}
    assert seen.error["u"].shape == (2, 4)
    assert seen.metrics["mass_defect"][0] == 0
    assert np.isnan(seen.metrics["mass_defect"][1])


def test_levels_that_differ_in_the_seed_alone_are_judged_by_what_needs_no_order():
    levels = tuple(Discretisation(1 / 8, 0.5, 2, jitter=0.1, seed=seed) for seed in (1, 2))
    found = verify(
        Plain(), HILL, refinement=Refinement("seeds", levels, 2), criteria=[Balance("mass", "", "conservation form")]
    )
    assert [finding.verdict for finding in found] == [Verdict.PASS]


# What a case knows of its problem.


def test_a_case_names_the_norm_of_its_fields():
    (case,) = HILL.cases
    assert case.norm == "L2-max"
    assert [f.criterion for f in verify(Plain(), replace(HILL, cases=(replace(case, norm="L2"),)))] == [
        "order of u in L2 in [1.85, 2.15]"
    ]
    step = studies.get("elastic-bar").cases[0]
    assert step.norm == "L1"
    for wrong, norm in ((case, "L3"), (step, "L2")):
        with pytest.raises(UsageError, match=f"cannot be judged in the norm '{norm}': choose "):
            replace(wrong, norm=norm)


def test_a_case_may_name_the_ladder_of_strangers():
    (case,) = HILL.cases
    named = replace(HILL, cases=(replace(case, ladder=halving(1.0, 16, quick=4, full=4, courant=0.25)),))
    assert {(f.refinement, f.verdict) for f in verify(Plain(), named)} == {("nu_C=0.25", Verdict.PASS)}
    assert {f.refinement for f in verify(Plain(), named, refinement=ladder())} == {ladder().label}

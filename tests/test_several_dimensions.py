"""Bodies in one, two and three dimensions: from the solver through runs, datasets and verdicts to the report."""

import json
from dataclasses import replace

import netCDF4
import numpy as np
import pytest
from faulty_solvers import plan
from sampled_solvers import Everywhere, Sampled
from stored_results import tree_of

from mpmverify import studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Balance, FieldSums, Order
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.norms import errors
from mpmverify.dataset.files import Results
from mpmverify.dataset.runs import read_run
from mpmverify.dataset.tables import read_tables
from mpmverify.errors import UsageError
from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.ring import expanding_ring
from mpmverify.exact.steffen import steffen
from mpmverify.exact.vortex import generalised_vortex
from mpmverify.execution.evaluation import SHOWN_OUTPUTS
from mpmverify.execution.runner import run, tasks_of
from mpmverify.execution.verify import verify
from mpmverify.problem import Discretisation, components
from mpmverify.problem.quantities import history_units, multiplicity
from mpmverify.reports import render
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Series, Study, halving

BAR, SQUARE, CUBE, RING, VORTEX = steffen(), axis_aligned(2), axis_aligned(3), expanding_ring(), generalised_vortex()
MADE = "made so"
BALANCES = (Balance("mass", "", MADE), Balance("momentum", "impulse", MADE))


def case(name, problem, solver, quantities=("displacement", "velocity", "stress", "displacement_gradient")):
    norm = "L2-max" if problem.problem.shape else "L2"
    criteria = (*(Order(quantity, norm, 1.8, 2.2, MADE) for quantity in quantities), *BALANCES)
    cells = {"cube": 4, "ring": 20, "vortex": 40}.get(name, 8)
    refinement = halving(problem.problem.lengths[0], cells, quick=3, full=3, courant=0.5)
    return Case(name, problem, (Series(solver, refinement, criteria),), "displacement")


def study(*cases):
    return Study("several", "Several", "Bodies in one, two and three dimensions.", cases)


def good(*problems):
    table = {"bar": BAR, "square": SQUARE, "cube": CUBE, "ring": RING, "vortex": VORTEX}
    return [case(name, table[name], Sampled(table[name])) for name in problems]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Return the results of solvers without a fault, one study per body, with their report."""
    path = tmp_path_factory.mktemp("several")
    table = {}
    for body in good("bar", "square", "cube", "ring", "vortex"):
        declared = Study(body.name, body.name, "A body.", (body,))
        (table[body.name],) = run([declared], plan(path))
    render(Results(path))
    return Results(path), table


@pytest.mark.parametrize("name", ["bar", "square", "cube", "ring", "vortex"])
def test_solvers_without_a_fault_pass(stored, name):
    findings = [f for f in stored[1][name].findings if f.gate == "verification"]
    assert len(findings) == 6
    assert {f.verdict for f in findings} == {Verdict.PASS}, [str(f) for f in findings]


@pytest.mark.parametrize(
    ("behaviour", "verdict", "reason"),
    [
        ("stress-out-of-order", Verdict.FAIL, "order of stress in L2"),
        ("turned-displacement", Verdict.FAIL, "order of displacement in L2"),
        ("shear-error", Verdict.FAIL, "order of stress in L2"),
        ("stress-of-nine", Verdict.ERROR, "its stress has 9 components instead of stress_xx, stress_yy, stress_xy"),
        ("flat-velocity", Verdict.ERROR, "its velocity has 1 components instead of velocity_x, velocity_y"),
        ("flat-points", Verdict.ERROR, "its points have 1 coordinates in 2 dimensions"),
        ("momentum-without-axis", Verdict.ERROR, "unknown history 'momentum': known are time, mass, momentum_x, momentum_y,"),
        ("lacks-momentum-y", Verdict.ERROR, "the histories 'momentum' and 'impulse', was not measured"),
        ("lacks-impulse-y", Verdict.ERROR, "the histories 'momentum' and 'impulse', was not measured"),
        ("loses-momentum-y", Verdict.FAIL, "momentum less impulse conserved"),
        ("mass-of-the-box", Verdict.FAIL, "mass conserved"),
        ("weight-of-the-box", Verdict.ERROR, "its first weights sum to 2, and the measure of the box is 1"),
    ],
)
def test_solvers_with_a_fault_do_not_pass(behaviour, verdict, reason):
    findings = verify(Sampled(SQUARE, behaviour), study(*good("square")))
    wrong = [f for f in findings if f.verdict is not Verdict.PASS]
    assert wrong
    assert {f.verdict for f in wrong} == {verdict}
    assert all(reason in str(f) for f in wrong), [str(f) for f in wrong]


def test_the_weights_of_a_ring_must_sum_to_its_area():
    (finding, *_) = verify(Sampled(RING, "weight-of-the-box"), study(*good("ring")))
    assert "its first weights sum to 1.25663706, and the measure of the body is 0.628318531" in finding.reason


def test_the_outputs_in_two_dimensions_that_are_shown_are_read_back_bit_for_bit_with_its_units(stored):
    results, _ = stored
    task = next(
        task for task in tasks_of(Study("ring", "ring", "A body.", tuple(good("ring"))), plan(results.path)) if task.shown
    )
    back = read_run(results.run(task.key), task.key).solution
    whole = task.solver.solve(task.problem.problem, task.discretisation)
    outputs = np.unique(np.round(np.linspace(0, len(whole.time) - 1, min(len(whole.time), SHOWN_OUTPUTS[2]))).astype(int))
    made = whole.excerpt(outputs, np.arange(len(whole.histories["time"])))
    assert {name: (values.shape, values.tobytes()) for name, values in back.arrays().items()} == {
        name: (values.shape, values.tobytes()) for name, values in made.arrays().items()
    }
    with netCDF4.Dataset(results.run(task.key)) as file:
        assert file["weight"].units == "m2"
        assert file["stress"].long_name == "stress xx, stress yy, stress xy"
        units = {name: file[f"history_{name}"].units for name in ("mass", "momentum_y", "impulse_x", "strain_energy")}
    assert units == {"mass": "kg m-1", "momentum_y": "kg s-1", "impulse_x": "kg s-1", "strain_energy": "J m-1"}


@pytest.mark.parametrize(
    ("dimension", "mass", "momentum", "energy"),
    [(1, "kg m-2", "kg m-1 s-1", "J m-2"), (2, "kg m-1", "kg s-1", "J m-1"), (3, "kg", "kg m s-1", "J")],
)
def test_units_of_histories_are_per_cross_section_per_thickness_or_of_the_whole_body(dimension, mass, momentum, energy):
    units = history_units(dimension)
    assert units["mass"] == mass
    assert {units[name] for name in components("momentum", dimension)} == {momentum}
    assert {units[name] for name in ("kinetic_energy", "strain_energy", "external_work")} == {energy}
    assert history_units(dimension, transported=True)["mass"] == units["inflow"] == {1: "m", 2: "m2", 3: "m3"}[dimension]


@pytest.mark.parametrize(("name", "suffix"), [("bar", ""), ("square", "_2d"), ("cube", "_3d"), ("ring", "_2d")])
def test_snapshots_hold_every_component_by_its_name(stored, name, suffix):
    problem = {"bar": BAR, "square": SQUARE, "cube": CUBE, "ring": RING}[name]
    group = tree_of(stored[0].study(name))["sampled-good"]
    shots, histories = group[f"snapshots{suffix}"].to_dataset(), group[f"histories{suffix}"].to_dataset()
    assert len(group.children) == 2
    dimension, size, size_of = problem.problem.dimension, shots.row_size.values, Sampled(problem).size
    X = np.stack([shots[axis].values for axis in components("reference", dimension)], axis=1)[: size[0]]
    for quantity, field in problem.exact.fields.items():
        exact = field(X, shots.time.values)
        for k, component in enumerate(components(quantity, dimension)):
            stored_exact = shots[f"{component}_exact"]
            np.testing.assert_array_equal(stored_exact.values.reshape(len(size), -1), exact[..., k].astype(np.float32))
            assert stored_exact.attrs["units"] == shots[f"{component}_error"].attrs["units"]
            np.testing.assert_allclose(shots[f"{component}_error"], shots.h.values[0] ** 2 * size_of(quantity), rtol=1e-6)
    assert len(size) == (9 if dimension == 1 else SHOWN_OUTPUTS[dimension]), "outputs over the whole run, in every dimension"
    assert {histories[f"history_{momentum}"].attrs["units"] for momentum in components("momentum", dimension)} == {
        history_units(dimension)[components("momentum", dimension)[0]]
    }


def test_tables_and_pages_contain_bodies_of_every_dimension(stored):
    results, _ = stored
    tables = read_tables([results.study(name) for name in ("bar", "square", "cube", "ring")])
    assert {key.study for key, _, _ in tables.errors} == {"bar", "square", "cube", "ring"}
    for name in ("square", "cube", "ring"):
        page = (results.report / f"{name}.html").read_text(encoding="utf-8")
        assert "order of displacement_gradient" in page
        assert "Numerical and exact profile" not in page, "a profile has one coordinate"
    assert "Ring(center=(0.0, 0.0), inner=0.4, outer=0.6)" in (results.report / "ring.html").read_text(encoding="utf-8")
    assert "Numerical and exact profile" in (results.report / "bar.html").read_text(encoding="utf-8")


def test_one_solver_may_be_judged_on_bodies_of_several_dimensions(tmp_path):
    """Histories of a bar and of a square have different units and are separate variables."""
    anywhere = Everywhere((BAR, SQUARE, CUBE))
    cases = [case(name, problem, anywhere) for name, problem in (("bar", BAR), ("square", SQUARE), ("cube", CUBE))]
    (judged,) = run([study(*cases)], plan(tmp_path))
    assert {f.verdict for f in judged.findings if f.gate == "verification"} == {Verdict.PASS}
    group = tree_of(Results(tmp_path).study("several"))["everywhere"]
    assert set(group.children) == {f"{part}{suffix}" for part in ("snapshots", "histories") for suffix in ("", "_2d", "_3d")}
    masses = {suffix: group[f"histories{suffix}"]["history_mass"].attrs["units"] for suffix in ("", "_2d", "_3d")}
    assert masses == {"": "kg m-2", "_2d": "kg m-1", "_3d": "kg"}
    render(Results(tmp_path))
    page = (tmp_path / "report" / "several.html").read_text(encoding="utf-8")
    figures = [json.loads(part.partition("</script>")[0]) for part in page.split('class="figures">')[1:]]
    titles = [[chart["title"] for chart in figure["series"][0]["histories"]] for figure in figures]
    assert "Momentum less impulse" in titles[0]
    assert {"Momentum x", "Momentum y less impulse y"} <= set(titles[1])
    assert "Momentum z less impulse z" in titles[2]
    assert "kg s⁻¹" in str(figures[1]["series"][0]["histories"])


def test_norms_of_a_tensor_count_every_entry():
    level = Discretisation(1 / 8, 0.5)
    for problem, quantity in ((SQUARE, "stress"), (CUBE, "stress"), (VORTEX, "stress"), (CUBE, "displacement_gradient")):
        solution = Sampled(problem).solve(problem.problem, level)
        dimension = problem.problem.dimension
        error, size = errors(solution, problem.exact)[quantity]
        # The error is the same in all entries of the full tensor.
        exact = problem.exact.fields[quantity](solution.reference, solution.time)
        np.testing.assert_allclose(error, dimension * level.h**2 * Sampled(problem).size(quantity), rtol=1e-12)
        full = np.zeros((*exact.shape[:2], dimension, dimension))
        for k, name in enumerate(components(quantity, dimension)):
            i, j = ("xyz".index(axis) for axis in name[-2:])
            full[..., i, j] = exact[..., k]
            if quantity == "stress":
                full[..., j, i] = exact[..., k]
        largest = np.linalg.norm(full, axis=(2, 3)).max()
        assert size[2] == pytest.approx(largest, rel=1e-12)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_components_of_every_quantity(dimension):
    counts = {"u": 1, "displacement": dimension, "velocity": dimension, "displacement_gradient": dimension**2, "mass": 1}
    counts["stress"] = dimension * (dimension + 1) // 2
    for quantity, count in counts.items():
        names = components(quantity, dimension)
        assert len(set(names)) == len(names) == count
        assert (names == (quantity,)) == (count == 1)
    assert multiplicity("stress", dimension).sum() == dimension**2
    assert multiplicity("displacement_gradient", dimension).sum() == dimension**2


@pytest.mark.parametrize("solver", [FiniteElement(1, "lumped", "central-differences"), TaylorGalerkin(1)])
@pytest.mark.parametrize("problem", [SQUARE, CUBE, RING])
def test_one_dimensional_solvers_refuse_other_dimensions(solver, problem):
    with pytest.raises(UsageError, match=r"cannot solve .*: it takes .*one.dimension"):
        solver.solve(problem.problem, Discretisation(1 / 8, 0.2))


def test_the_finite_element_reference_converges_on_the_bar_that_starts_deformed():
    criteria = (Order("displacement", "L2", 2.9, 3.1, "P2"), Order("stress", "L2", 1.9, 2.1, "P2"))
    solver = FiniteElement(2, "consistent", "central-differences")
    refinement = halving(1.0, 8, quick=4, full=4, courant=0.2, courant_power=0.5)
    findings = verify(solver, study(*good("bar")), refinement=refinement, criteria=criteria)
    assert [f.verdict for f in findings] == [Verdict.PASS, Verdict.PASS], [str(f) for f in findings]


@pytest.mark.parametrize(("case", "dimension"), [("clamped", 2), ("clamped-cuboid", 3)])
def test_histories_are_sums_of_the_fields_in_every_direction(case, dimension):
    """Of a body that starts deformed, with volumes that change: each history, and each direction of the momentum, is compared."""
    known = {one.name: one for one in studies.get("plane-waves").cases}[case]
    level = max(known.series[0].refinement.levels, key=lambda one: one.h)
    solution, setting = MaterialPoint("MUSL").solve(known.problem.problem, level), Setting(known.problem, level)
    stocks = ("mass", "momentum", "kinetic_energy", "strain_energy")
    criterion = FieldSums(stocks, "")
    assert len(criterion.measure(solution, setting)) == len(stocks)
    assert max(criterion.measure(solution, setting).values()) < 1e-12
    for stock in stocks:
        for name in components(stock, dimension):
            history = solution.histories[name]
            moved = np.max(np.abs([solution.histories[one] for one in components(stock, dimension)]))
            wrong = replace(solution, histories=dict(solution.histories) | {name: history + 1e-6 * moved})
            assert criterion.measure(wrong, setting)[f"{stock}_sum_defect"] > 1e-9, name

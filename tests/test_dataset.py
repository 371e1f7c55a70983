"""The file of a study: its groups, units, attributes and texts, also for other tools, and its findings."""

import dataclasses
import json
import re
import subprocess
import sys
import time

import netCDF4
import numpy as np
import pytest
import xarray as xr
from faulty_solvers import Scripted, ladder, plan, study
from stored_results import CRITERION_OF_EACH_KIND, MIXED, tree_of

from mpmverify.criteria import (
    CRITERIA,
)
from mpmverify.criteria.evidence import SeriesId
from mpmverify.dataset.criteria import criterion_table, read_criteria
from mpmverify.dataset.files import Results, check_ours
from mpmverify.dataset.fits import read_orders
from mpmverify.dataset.levels import read_levels
from mpmverify.dataset.statement import statement
from mpmverify.dataset.study import read_study, read_study_groups, solvers, stored_findings
from mpmverify.dataset.tree import Group, read_groups, text, variable, write_groups
from mpmverify.errors import UsageError
from mpmverify.execution.gate import accept, gate, judged
from mpmverify.execution.runner import run
from mpmverify.judgement.baseline import Baseline
from mpmverify.problem import (
    UNITS,
    Absorbing,
    Block,
    Bodies,
    Constant,
    Disk,
    Inflow,
    NeoHookean,
    Problem,
    Traction,
    Transport,
    Velocity,
)
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin

EXACT = study(TaylorGalerkin(), name="real")


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    return folder, {entry.study: entry for entry in run([MIXED, EXACT], plan(folder))}


@pytest.fixture(scope="module", params=["mixed", "real"])
def path(request, stored):
    return stored[0] / f"{request.param}.nc"


def test_xarray_opens_the_tree_and_every_group(path):
    with xr.open_datatree(path) as tree:
        for group in tree.groups:
            with xr.open_dataset(path, group=group) as dataset:
                mine = tree[group].to_dataset(inherit=False)
                assert set(dataset.variables) == set(mine.variables)
                xr.testing.assert_equal(dataset, mine)


WORDS = Group(
    {
        "word": variable(("x", "y"), np.array([["", "é"], ["a b ", "x" * 300]]), {"long_name": "w"}),
        "number": variable("x", [1.5, np.nan], {"units": "m"}),
    },
    {
        "x": variable("x", [3, 4]),
        "mark": variable("y", text(["p", "q"])),
        "alone": variable("z", text(["r"])),
        "k": variable("x", [1, 2], {"units": "1"}),
    },
    {"title": "é", "count": 3},
)
NOTHING = Group({"void": variable("none", text([])), "hollow": variable("none", [])})


def test_xarray_reads_groups_with_their_coordinates_texts_and_attributes(tmp_path):
    made = {"/": WORDS, "/a": NOTHING, "/a/b": WORDS}
    write_groups(tmp_path / "t.nc", made)
    tree = xr.DataTree.from_dict({place: xr.Dataset(*map(dict, vars(group).values())) for place, group in made.items()})
    with xr.open_datatree(tmp_path / "t.nc") as back:
        assert back.groups == tree.groups
        for place in made:
            mine, other = tree[place].to_dataset(inherit=False), back[place].to_dataset(inherit=False)
            assert set(mine.coords) == set(other.coords)
            other.attrs.pop("checksum", None)
            xr.testing.assert_identical(mine, other)


def test_groups_are_read_back_as_they_were_written(tmp_path):
    made = {"/": WORDS, "/a": NOTHING, "/a/b": WORDS}
    write_groups(tmp_path / "t.nc", made)
    with netCDF4.Dataset(tmp_path / "t.nc") as file:
        _, back = read_groups(file)
    assert list(back) == list(made)
    for place, group in made.items():
        found = back[place].variables
        assert list(found) == [*group.variables, *group.coordinates]
        for name, (dimensions, values, attributes) in (*group.variables.items(), *group.coordinates.items()):
            assert found[name].dimensions == dimensions
            assert found[name].values.dtype.kind == values.dtype.kind
            np.testing.assert_array_equal(found[name].values, values)
            assert attributes.items() <= found[name].attributes.items()
        assert group.attributes.items() <= back[place].attributes.items()


def test_variables_that_disagree_on_a_dimension_are_not_written(tmp_path):
    wrong = Group({"a": variable("x", [1.0]), "b": variable("x", [1.0, 2.0])})
    with pytest.raises(ValueError, match="b has 2 values along x, where others have 1"):
        write_groups(tmp_path / "t.nc", {"/": wrong})


def test_what_is_read_of_a_study_is_what_xarray_reads(path):
    groups, tree = read_study_groups(path), tree_of(path)
    assert set(groups) == set(tree.groups)
    for place, group in groups.items():
        other = tree[place].to_dataset(inherit=False)
        assert group.columns.keys() == set(other.variables)
        for name, values in group.columns.items():
            np.testing.assert_array_equal(values, other[name].values)
        assert (
            group.units.items() >= {name: v.attrs["units"] for name, v in other.variables.items() if "units" in v.attrs}.items()
        )


def test_a_file_may_be_open_many_times(stored):
    """With strings of variable length the netCDF library would kill the process here."""
    program = (
        "import sys, xarray as xr; tree = xr.open_datatree(sys.argv[1])\n"
        "for _ in range(3):\n    for group in tree.groups: xr.open_dataset(sys.argv[1], group=group)"
    )
    assert subprocess.run([sys.executable, "-c", program, stored[0] / "mixed.nc"], check=False).returncode == 0


def test_every_solver_is_a_group_with_errors_by_level(stored):
    with xr.open_datatree(stored[0] / "mixed.nc") as tree:
        assert list(tree.children) == list(MIXED.solvers())
        for dataset in tree.children.values():
            assert dataset["error"].dims == ("level", "quantity", "norm")
            assert {"h", "dt", "courant", "ppc", "case", "refinement"} <= set(dataset["error"].coords)
            np.testing.assert_array_equal(dataset["h"], [level.h for level in ladder().tier("quick")])
            assert dataset["norm"].values.tolist() == ["L1", "L2", "Linf", "L2-max"]


def test_the_stored_errors_are_those_of_the_scripted_solver(stored):
    """The solver adds an error of h^2 everywhere, which is its value in every norm on the unit interval."""
    with xr.open_datatree(stored[0] / "mixed.nc") as tree:
        good = tree["scripted-good"]
        h = good["h"].values
        for norm in good["norm"].values:
            np.testing.assert_allclose(good["error_absolute_u"].sel(norm=norm), h**2, rtol=1e-12)
        assert (good["error"].sel(quantity="u") == good["error_absolute_u"] / good["exact_norm_u"]).all()
        assert good["error_absolute_u"].attrs["units"] == good["exact_norm_u"].attrs["units"] == UNITS["u"]
        assert (good["run"] == [path.stem for path in map(Results(stored[0]).run, good["run"].values) if path.exists()]).all()


def test_netcdf4_reads_the_same_numbers_and_texts(path):
    with netCDF4.Dataset(path) as file, xr.open_datatree(path) as tree:
        for name, group in file.groups.items():
            for variable in ("error", "h", "outcome", "run", "verdict_reason"):
                np.testing.assert_array_equal(np.ma.getdata(group[variable][...]), tree[name][variable].values)


def test_every_numeric_variable_has_units(path):
    with xr.open_datatree(path) as tree:
        for node in tree.subtree:
            dataset = node.to_dataset(inherit=False)
            assert {n for n, v in dataset.variables.items() if v.dtype.kind in "iufm" and not v.attrs.get("units")} == set()
            assert not {n for n, v in dataset.variables.items() if v.dtype.kind in "mM"}, "no time is decoded as a date"


ATTRIBUTES = ("title", "summary", "keywords", "source", "history", "date_created", "creator_name", "id")
PROVENANCE = ("mpmverify_kind", "mpmverify_schema", "commit", "commit_state", "versions", "platform")


def test_global_attributes_are_those_of_cf_and_acdd_with_provenance(path):
    run_path = next((path.parent / "runs").iterdir())
    for file, kind in ((path, "study"), (run_path, "run")):
        attributes = check_ours(file, kind)
        assert attributes["Conventions"] == "CF-1.11, ACDD-1.3"
        assert [name for name in (*ATTRIBUTES, *PROVENANCE) if attributes.get(name) in (None, "")] == []
        made = time.strptime(attributes["date_created"], "%Y-%m-%dT%H:%M:%SZ")
        assert attributes["history"].startswith(attributes["date_created"])
        assert abs(time.mktime(made) - time.mktime(time.gmtime())) < 3600
        assert re.fullmatch(r"[0-9a-f]{40}|none", attributes["commit"])
        assert attributes["commit_state"] in ("clean", "dirty", "installed")
        versions = dict(entry.split(" ", 1) for entry in attributes["versions"].split(", "))
        assert versions["numpy"] == np.__version__
        assert versions["xarray"] == xr.__version__
        assert {"python", "scipy", "numba", "scikit-fem", "netCDF4"} <= versions.keys()
    assert check_ours(path, "study")["seeds"]


def test_row_sizes_of_ragged_arrays_sum_to_their_length(path):
    with xr.open_datatree(path) as tree:
        assert any("snapshots" in node.children for node in tree.children.values())
        for node in tree.children.values():
            for name, child in node.children.items():
                row = child["row_size"]
                assert row.attrs["sample_dimension"] == "obs"
                assert int(row.sum()) == child.sizes["obs"], name
                assert (row > 0).all()
                for values in child.dataset.variables.values():
                    assert len(values.dims) == 1


def test_snapshots_hold_the_profiles_of_the_runs(stored):
    """In each row the numerical profile differs from the exact one by the error of the solver."""
    with xr.open_datatree(stored[0] / "mixed.nc") as tree:
        shots = tree["scripted-good/snapshots"].load()
        ends = np.cumsum(shots["row_size"].values)
        for end, size, h, t in zip(ends, shots["row_size"].values, shots["h"].values, shots["time"].values, strict=True):
            row = shots.to_dataset().isel(obs=slice(end - size, end))
            np.testing.assert_allclose(row["u_error"], h**2, rtol=1e-6)
            assert np.all(np.diff(row["reference"]) > 0)
            assert 0 <= t <= MIXED.cases[0].problem.problem.end_time


def test_judging_a_stored_study_reproduces_its_findings(stored, path):
    groups = read_study_groups(path)
    assert stored_findings(groups) == stored[1][path.stem].findings
    again = judged(read_study(path), plan(stored[0]).baseline)
    assert again.findings == stored_findings(groups)
    orders = {}
    for solver, group in solvers(groups):
        orders |= read_orders(group, read_levels(solver, group))
    fits = {
        (series, " ".join(measure)): (found.fit.order, found.fit.low, found.fit.high)
        for series, measures in again.fits.items()
        for measure, found in measures.items()
        if found.fit
    }
    assert orders == fits


def test_a_restricted_run_states_its_restriction_and_the_missing_baseline_entries(tmp_path):
    whole, known = study(Scripted("good"), TaylorGalerkin(), name="whole"), Baseline(tmp_path / "baseline.json")
    list(run([whole], plan(tmp_path)))
    accept(known, [tmp_path / "whole.nc"], "the first")
    known.write()
    kept, other = tuple(whole.solvers())
    (entry,) = run([whole.restricted((kept,))], plan(tmp_path / "part", baseline=known))
    path = tmp_path / "part" / "whole.nc"
    groups = read_study_groups(path)
    assert groups["/"].attributes["restricted_to"] == kept
    assert entry.findings[-1].solver == other
    assert entry.findings[-1].reason.endswith(f"the run was restricted to {kept}: run the whole study")
    assert stored_findings(groups) == gate(path, known) == entry.findings
    assert gate(path, Baseline(tmp_path / "none"))[-1].solver == kept
    older = {name: value for name, value in groups["/"].attributes.items() if name not in ("restricted_to", "lacking")}
    found = stored_findings(groups | {"/": dataclasses.replace(groups["/"], attributes=older)})
    assert {finding.solver for finding in found} == {kept}, "a file without these attributes has no such finding"


@dataclasses.dataclass(frozen=True)
class Swell:
    """A load of a user."""

    largest_load: float = 1e7
    shift: float = -0.0
    periods: int = 3


class Opaque:
    """A class with the protocol of a load that is not a dataclass."""


def test_the_statement_of_a_problem():
    faces = {"x+": Traction(Swell()), "x-": Velocity(Constant(-0.0)), "y+": Traction(Constant(2e-6)), "y-": Absorbing()}
    box = Problem("p", (0.0, -1.0), (2.0, 1.5), NeoHookean(1e7, 1000.0, 0.3), faces, end_time=0.02)
    assert statement(box) == {
        "domain": "[0, 2] m x [-1, 1.5] m",
        "material": "neo-Hookean, E = 1e+07 Pa, ρ = 1000 kg/m³, ν = 0.3",
        "wave speed": "116.024 m/s",
        "final time": "0.02 s",
        "face x-": "velocity 0 m/s",
        "face x+": "traction [Pa]: swell, largest load = 1e+07, shift = 0, periods = 3",
        "face y-": "absorbing",
        "face y+": "traction 2e-06 Pa",
    }
    assert list(statement(box))[4:] == ["face x-", "face x+", "face y-", "face y+"]
    two = Bodies((Disk((0.5, 0.0), 0.25), Block((1.0, 0.0), (2.0, 1.0))))
    said = "disk, center = (0.5, 0.0), radius = 0.25 and block, lower = (1.0, 0.0), upper = (2.0, 1.0)"
    assert statement(dataclasses.replace(box, shape=two))["body"] == said
    faces = {"x-": Inflow(Constant(1.0)), "x+": Inflow(Opaque())}
    carried = statement(Problem("p", (0.0,), (1.0,), Transport(-1.0), faces, end_time=1.0))
    assert carried["material"] == "transport, a = -1 m/s"
    assert (carried["face x-"], carried["face x+"]) == ("inflow 1", "inflow: opaque")


def test_every_series_is_judged_by_its_criteria_and_the_baseline(stored):
    for declared in (MIXED, EXACT):
        found = stored[1][declared.name].findings
        for case, series in declared.series():
            mine = [f for f in found if (f.case, f.solver) == (case.name, series.solver.name)]
            assert [f.criterion for f in mine if f.gate == "verification"] == [c.title for c in series.criteria]
            assert [f.gate for f in mine].count("regression") == 1


def test_criteria_are_read_back_as_equal_values(tmp_path):
    assert {type(criterion) for criterion in CRITERION_OF_EACH_KIND} >= set(CRITERIA.values()) - {
        kind for kind in CRITERIA.values() if kind.__module__ != "mpmverify.criteria.sources"
    }
    declared = study(criteria=CRITERION_OF_EACH_KIND)
    list(run([declared], plan(tmp_path)))
    back = read_study(tmp_path / "scripted.nc").declared
    assert back == declared.criteria() == {SeriesId("hill", "scripted-good", ladder().label): CRITERION_OF_EACH_KIND}
    assert len({criterion for criteria in back.values() for criterion in criteria}) == len(CRITERION_OF_EACH_KIND), (
        "values can be hashed"
    )


def test_an_unknown_criterion_is_named():
    declared = {SeriesId("hill", "tg", "nu_C=1"): CRITERION_OF_EACH_KIND[:1]}
    column = criterion_table("tg", declared).columns
    stored = json.loads(column["criterion_json"].item()) | {"type": "Magic"}
    with pytest.raises(UsageError, match="the criterion 'Magic' of case 'hill' is unknown: choose from Order"):
        read_criteria("tg", column | {"criterion_json": text([json.dumps(stored)])})


def test_a_study_without_criteria_metrics_or_finished_runs_is_stored(tmp_path):
    declared = study(Scripted("raises"), criteria=())
    (entry,) = run([declared], plan(tmp_path))
    tree = tree_of(tmp_path / "scripted.nc")
    assert gate(tmp_path / "scripted.nc", Baseline(tmp_path / "none")) == entry.findings
    assert [finding.gate for finding in entry.findings] == ["regression"]
    assert tree["scripted-raises"]["error"].shape == (3, 0, 4)
    with xr.open_datatree(tmp_path / "scripted.nc") as opened:
        assert opened["scripted-raises"].sizes["level"] == 3

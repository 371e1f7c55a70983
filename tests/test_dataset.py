"""Result files: they are read back unchanged, also by other tools; files that mpmverify did not write are named and left alone."""

import dataclasses
import json
import os
import re
import resource
import signal
import stat
import subprocess
import sys
import time

import netCDF4
import numpy as np
import pytest
import xarray as xr
from faulty_solvers import Scripted, ladder, plan, study, transported

from mpmverify.atomic import write_atomic
from mpmverify.criteria import (
    CRITERIA,
    Amplification,
    Balance,
    EnergyDrift,
    Exact,
    FieldSums,
    Order,
    Published,
    Separated,
    Stall,
)
from mpmverify.criteria.evidence import SeriesId
from mpmverify.dataset.criteria import read_criteria, with_criteria
from mpmverify.dataset.files import Results, check_ours
from mpmverify.dataset.fits import read_orders
from mpmverify.dataset.levels import read_levels
from mpmverify.dataset.runs import Run, read_run, write_run
from mpmverify.dataset.statement import statement
from mpmverify.dataset.study import read_study, read_tree, solvers, stored_findings, write_study
from mpmverify.dataset.tree import write_tree
from mpmverify.errors import DamagedError, ResultsError, UsageError
from mpmverify.exact.advection import Gaussian, advection
from mpmverify.execution.gate import accept, gate, judged
from mpmverify.execution.runner import run
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.judging import judge
from mpmverify.problem import (
    UNITS,
    Absorbing,
    Block,
    Bodies,
    Constant,
    Discretisation,
    Disk,
    Inflow,
    NeoHookean,
    Problem,
    Traction,
    Transport,
    Velocity,
)
from mpmverify.solution import Outcome, Status, Work
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin

EXTREME = np.array([-0.0, 5e-324, np.nan, np.inf, -np.inf, 1 / 3, 9.969209968386869e36, 1e308])
"""Floats that are easily changed by a round trip; 9.97e36 is the fill value of netCDF."""


def solution(**changes):
    made = transported(advection(Gaussian()).problem, Discretisation(h=1 / len(EXTREME), courant=0.5), 0.01)
    return dataclasses.replace(made, **changes)


def run_of(made, **measured):
    return Run(made, **{"errors": {}, "metrics": {}, "shown": True} | measured)


def bits(arrays):
    return {name: (values.shape, values.tobytes()) for name, values in arrays.items()}


# One run.


@pytest.mark.parametrize("cells", [8, 3000], ids=["plain", "compressed"])
def test_a_run_is_read_back_bit_for_bit(tmp_path, cells):
    made = transported(advection(Gaussian()).problem, Discretisation(h=1 / cells, courant=0.5), 0.01)
    made.fields["u"].ravel()[: len(EXTREME)] = EXTREME
    made = dataclasses.replace(
        made, dt=1 / 3, work=Work(2**40, 2**50, 0.1 + 0.2), outcome=Outcome(Status.NON_FINITE, "at step 3, é", "take ß")
    )
    errors, metrics = {"u": (EXTREME[:4], EXTREME[4:])}, {f"m{k}": float(value) for k, value in enumerate(EXTREME)}
    write_run(tmp_path / "k.nc", "k", run_of(made, errors=errors, metrics=metrics), "title")
    read = read_run(tmp_path / "k.nc", "k")
    assert bits(dict(enumerate(read.errors["u"]))) == bits(dict(enumerate(errors["u"])))
    assert list(read.metrics) == list(metrics)
    np.testing.assert_array_equal(list(read.metrics.values()), list(metrics.values()))
    back = read.solution
    assert bits(back.arrays()) == bits(made.arrays())
    assert (back.dt, back.work, back.outcome) == (made.dt, made.work, made.outcome)
    assert list(back.fields) == list(made.fields)
    assert list(back.histories) == list(made.histories)


def test_a_run_without_detail_or_fields_is_read_back(tmp_path):
    made = solution(fields={}, outcome=Outcome(Status.UNSTABLE))
    write_run(tmp_path / "k.nc", "k", run_of(made), "title")
    back = read_run(tmp_path / "k.nc", "k").solution
    assert back.fields == {}
    assert back.outcome == made.outcome


def test_a_run_without_histories_is_read_back(tmp_path):
    made = solution().excerpt(np.array([-1]), None)
    write_run(tmp_path / "k.nc", "k", run_of(made, shown=False), "title")
    back = read_run(tmp_path / "k.nc", "k")
    assert bits(back.solution.arrays()) == bits(made.arrays())
    assert not back.shown


@pytest.mark.parametrize("moved", [0.0, 1e-20, 0.1])
def test_a_position_that_follows_from_the_displacement_is_not_stored(tmp_path, moved):
    still = solution()
    displacement = np.full_like(still.position, 1 / 3)
    for k, (fields, derived) in enumerate(
        (({"displacement": displacement}, still.reference + displacement), ({}, still.position))
    ):
        made = solution(fields=fields, position=derived + moved)
        write_run(tmp_path / f"{k}.nc", "k", run_of(made), "title")
        assert bits(read_run(tmp_path / f"{k}.nc", "k").solution.arrays()) == bits(made.arrays())
        with netCDF4.Dataset(tmp_path / f"{k}.nc") as file:
            assert ("position" in file.variables) == (moved == 0.1)


def test_a_changed_number_is_damage(tmp_path):
    """In fields, in the time step and in what was measured: the checksum is over all of them."""

    def changed(change):
        write_run(tmp_path / "k.nc", "k", run_of(solution(), errors={"u": (np.ones(4), np.ones(4))}), "title")
        with netCDF4.Dataset(tmp_path / "k.nc", "a") as file:
            change(file)
        with pytest.raises(DamagedError, match=r"k\.nc' is damaged: run `mpmverify run` again"):
            read_run(tmp_path / "k.nc", "k")

    changed(lambda file: file["u"].__setitem__((0, 0, 0), 7.0))
    changed(lambda file: file.setncattr("dt", 0.5))
    changed(lambda file: file.setncattr("errors", file.errors.replace("1.0", "0.5")))
    changed(lambda file: file.setncattr("status", "completed?"))
    changed(lambda file: file.setncattr("shown", 0))


def test_the_mass_history_has_the_unit_of_an_integral_for_a_scalar_and_of_a_mass_for_a_body(tmp_path):
    for quantity, units in (("u", "m"), ("displacement", "kg m-2")):
        write_run(tmp_path / f"{quantity}.nc", "k", run_of(solution(fields={quantity: solution().fields["u"]})), "title")
        with netCDF4.Dataset(tmp_path / f"{quantity}.nc") as file:
            assert file["history_mass"].units == units


def test_xarray_opens_a_run_with_units_on_every_variable(tmp_path):
    write_run(tmp_path / "k.nc", "k", run_of(solution()), "title")
    with xr.open_dataset(tmp_path / "k.nc") as dataset:
        assert {name for name, values in dataset.variables.items() if not values.attrs.get("units")} == set()
        assert {name for name, values in dataset.variables.items() if not values.attrs.get("long_name")} == set()
        assert {values.dtype.kind for values in dataset.variables.values()} == {"f"}, "no time is decoded as a date"
        assert dataset["u"].dims[:2] == ("time", "point")


def test_a_run_of_another_key_is_refused(tmp_path):
    write_run(tmp_path / "k.nc", "k", run_of(solution()), "title")
    with pytest.raises(DamagedError, match=r"k\.nc' is damaged"):
        read_run(tmp_path / "k.nc", "another")


def test_a_run_whose_variables_are_missing_is_damaged(tmp_path):
    path = tmp_path / "k.nc"
    write_run(path, "k", run_of(solution()), "title")
    with netCDF4.Dataset(path, "a") as file:
        file.renameVariable("weight", "wait")
    with pytest.raises(DamagedError, match=re.escape(f"'{path}' is damaged: run `mpmverify run` again")):
        read_run(path, "k")


# Atomic writing.


def test_a_writer_that_fails_leaves_nothing(tmp_path):
    def write(temporary):
        temporary.write_text("half")
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_atomic(tmp_path / "new" / "k.nc", write)
    assert list((tmp_path / "new").iterdir()) == []


def test_a_writer_that_fails_leaves_the_existing_file(tmp_path):
    path = tmp_path / "k.nc"
    write_run(path, "k", run_of(solution()), "title")
    before = path.read_bytes()
    with pytest.raises(KeyError):
        write_run(path, "k", run_of(solution(histories={"mass": np.ones(3)})), "title")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_readers_never_see_half_a_file(tmp_path):
    path = tmp_path / "k.nc"

    def write(temporary):
        temporary.write_text("half")
        assert not path.exists()
        assert temporary.parent == path.parent, "a move within one file system is atomic"
        assert Results(tmp_path).studies() == [], "a file that is being written is not listed as a study"
        temporary.write_text("whole")

    write_atomic(path, write)
    assert path.read_text() == "whole"


def test_the_temporary_file_of_a_killed_writer_is_not_listed_as_a_study(tmp_path):
    program = (
        "import sys, time; from pathlib import Path; from mpmverify.atomic import write_atomic\n"
        "def write(temporary):\n    temporary.write_text('half'); print('writing', flush=True); time.sleep(60)\n"
        "write_atomic(Path(sys.argv[1]), write)"
    )
    process = subprocess.Popen([sys.executable, "-c", program, str(tmp_path / "s.nc")], stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert not (tmp_path / "s.nc").exists()
    assert Results(tmp_path).studies() == []


def test_a_result_has_the_permissions_of_other_files(tmp_path):
    (tmp_path / "other").write_text("")
    write_run(tmp_path / "k.nc", "k", run_of(solution()), "title")
    assert stat.S_IMODE((tmp_path / "k.nc").stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a limit on the size of files")
def test_a_full_disk_raises_an_error_that_names_the_file(tmp_path):
    large = solution(fields={"u": np.random.default_rng(0).random((5, 8, 20000))})
    path, said = tmp_path / "k.nc", tmp_path / "said"
    said.touch()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))
        try:
            write_run(path, "k", run_of(large), "title")
        except BaseException as error:
            said.write_text(f"{type(error).__name__}: {error}")
        os._exit(0)
    os.waitpid(child, 0)
    assert said.read_text().startswith(f"ResultsError: cannot write '{path}' (")
    assert list(tmp_path.iterdir()) == [said]


# Files that mpmverify did not write, or wrote in another schema.


def foreign(path):
    xr.Dataset({"a": ("x", [1.0])}, attrs={"title": "somebody's work"}).to_netcdf(path)


def of_an_unknown_kind(path):
    write_run(path, "k", run_of(solution()), "title")
    with netCDF4.Dataset(path, "a") as file:
        file.mpmverify_kind = "neither"


def of_another_schema(path):
    write_run(path, "k", run_of(solution()), "title")
    with netCDF4.Dataset(path, "a") as file:
        file.mpmverify_kind, file.mpmverify_schema = path.stem, 99


def without_a_schema(path):
    with netCDF4.Dataset(path, "w") as file:
        file.mpmverify_kind = path.stem


def with_a_text_as_schema(path):
    with netCDF4.Dataset(path, "w") as file:
        file.mpmverify_kind, file.mpmverify_schema = path.stem, "latest"


def a_text(path):
    path.write_text("my notes")


def a_folder(path):
    path.mkdir()


FOREIGN_FILES = [
    foreign,
    of_an_unknown_kind,
    of_another_schema,
    without_a_schema,
    with_a_text_as_schema,
    a_text,
    a_folder,
]


@pytest.mark.parametrize("kind", ["run", "study"])
@pytest.mark.parametrize("make", FOREIGN_FILES)
def test_a_foreign_file_is_named_and_not_changed(tmp_path, make, kind):
    path = tmp_path / f"{kind}.nc"
    make(path)
    before = path.read_bytes() if path.is_file() else b""
    read = (lambda: read_run(path, "k")) if kind == "run" else (lambda: read_study(path))
    write = (
        (lambda: write_run(path, "k", run_of(solution()), "title"))
        if kind == "run"
        else (lambda: write_study(path, study(), [], {}, judge("scripted", {}, {}), tier="quick", inputs="", run=""))
    )
    for act in (read, write):
        with pytest.raises(ResultsError) as error:
            act()
        assert str(path) in str(error.value)
        assert "\n" not in str(error.value)
    assert (path.read_bytes() if path.is_file() else b"") == before


def cut_off(path):
    path.unlink(missing_ok=True)
    write_run(path, "k", run_of(solution()), "title")
    path.write_bytes(path.read_bytes()[:3000])


def cut_off_at_once(path):
    path.write_bytes(b"\x89HD")


def empty(path):
    path.write_bytes(b"")


def of_zeros(path):
    path.write_bytes(bytes(5000))


@pytest.mark.parametrize("kind", ["run", "study"])
@pytest.mark.parametrize("make", [cut_off, cut_off_at_once, empty, of_zeros])
def test_a_damaged_file_is_named_and_set_aside_when_it_is_written_anew(tmp_path, caplog, make, kind):
    path = tmp_path / f"{kind}.nc"
    read = (lambda: read_run(path, "k")) if kind == "run" else (lambda: read_study(path))
    write = (
        (lambda: write_run(path, "k", run_of(solution()), "title"))
        if kind == "run"
        else (lambda: write_study(path, study(), [], {}, judge("scripted", {}, {}), tier="quick", inputs="", run=""))
    )
    for aside in (tmp_path / f"{kind}.nc.damaged", tmp_path / f"{kind}.nc.damaged-2"):
        make(path)
        before = path.read_bytes()
        with pytest.raises(DamagedError, match=re.escape(f"'{path}' is damaged: run `mpmverify run` again")):
            read()
        assert path.read_bytes() == before
        write()
        assert aside.read_bytes() == before
        assert caplog.messages[-1] == f"'{path}' is damaged: it is set aside as '{aside.name}'."
        check_ours(path, kind)


@pytest.mark.parametrize("kind", ["run", "study"])
def test_a_missing_file_is_named(tmp_path, kind):
    with pytest.raises(ResultsError, match=r"missing\.nc' does not exist: run `mpmverify run` first"):
        check_ours(tmp_path / "missing.nc", kind)


# One study.

MIXED = study(Scripted("good"), Scripted("unstable", below=0.1), Scripted("raises", below=0.04), name="mixed")
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


def test_a_tree_is_read_back_with_its_coordinates_texts_and_attributes(tmp_path):
    texts = xr.Dataset(
        {
            "word": (("x", "y"), [["", "é"], ["a b ", "x" * 300]], {"long_name": "w"}),
            "number": ("x", [1.5, np.nan], {"units": "m"}),
        },
        coords={"x": [3, 4], "mark": ("y", ["p", "q"]), "alone": ("z", ["r"]), "k": ("x", [1, 2], {"units": "1"})},
        attrs={"title": "é", "count": 3},
    )
    nothing = xr.Dataset({"void": ("none", np.array([], dtype="U1")), "hollow": ("none", np.array([], dtype=float))})
    made = xr.DataTree.from_dict({"/": texts, "/a": nothing, "/a/b": texts})
    write_tree(tmp_path / "t.nc", made)
    with xr.open_datatree(tmp_path / "t.nc") as back:
        assert back.groups == made.groups
        for group in made.groups:
            one, other = made[group].to_dataset(inherit=False), back[group].to_dataset(inherit=False)
            assert set(one.coords) == set(other.coords)
            other.attrs.pop("checksum", None)
            xr.testing.assert_identical(one, other)


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
        for _, dataset in solvers(tree):
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
    tree = read_tree(path)
    assert stored_findings(tree) == stored[1][path.stem].findings
    again = judged(read_study(path), plan(stored[0]).baseline)
    assert again.findings == stored_findings(tree)
    orders = {}
    for solver, dataset in solvers(tree):
        orders |= read_orders(dataset, read_levels(solver, dataset))
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
    tree = read_tree(path)
    assert tree.attrs["restricted_to"] == kept
    assert entry.findings[-1].solver == other
    assert entry.findings[-1].reason.endswith(f"the run was restricted to {kept}: run the whole study")
    assert stored_findings(tree) == gate(path, known) == entry.findings
    assert gate(path, Baseline(tmp_path / "none"))[-1].solver == kept
    del tree.attrs["restricted_to"], tree.attrs["lacking"]
    assert {f.solver for f in stored_findings(tree)} == {kept}, "a file without these attributes has no such finding"


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


CRITERION_OF_EACH_KIND = (
    Order("u", "L2", 1.8, 2.2, 'a "source", é'),
    Stall("u", "L1", 0.5, 0.01, 0.9, "s"),
    Exact("u", "L2-max", 1e-12, "s"),
    Published("u", "L2", ((1 / 8, 4.471e-3), (1 / 3, 0.1 + 0.2)), 3, "s"),
    Separated("u", "L2", (("h", 1.8, 2.2), ("h/ppc", 1 / 3, 0.1 + 0.2)), "s"),
    Balance("mass", "", "s"),
    EnergyDrift(1.8, "s"),
    FieldSums(("mass", "momentum"), "s"),
    Amplification(3, 1e-12, "s"),
)


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
    dataset = with_criteria(xr.Dataset(), "tg", declared)
    stored = json.loads(dataset["criterion_json"].item()) | {"type": "Magic"}
    dataset["criterion_json"] = ("criterion", [json.dumps(stored)])
    with pytest.raises(UsageError, match="the criterion 'Magic' of case 'hill' is unknown: choose from Order"):
        read_criteria("tg", dataset)


def test_a_study_without_criteria_metrics_or_finished_runs_is_stored(tmp_path):
    declared = study(Scripted("raises"), criteria=())
    (entry,) = run([declared], plan(tmp_path))
    tree = read_tree(tmp_path / "scripted.nc")
    assert gate(tmp_path / "scripted.nc", Baseline(tmp_path / "none")) == entry.findings
    assert [finding.gate for finding in entry.findings] == ["regression"]
    assert tree["scripted-raises"]["error"].shape == (3, 0, 4)
    with xr.open_datatree(tmp_path / "scripted.nc") as opened:
        assert opened["scripted-raises"].sizes["level"] == 3


def test_a_study_file_that_was_changed_by_a_byte_is_refused_or_has_the_same_findings(tmp_path, stored):
    """Bytes that no value needs may change; any other change is told, in one sentence."""
    sound = (stored[0] / "mixed.nc").read_bytes()
    path = tmp_path / "mixed.nc"
    path.write_bytes(sound)
    findings = gate(path, Baseline(tmp_path / "none"))
    rng = np.random.default_rng(7)
    refusals = []
    for count in [1] * 60 + [40] * 20:
        damaged = bytearray(sound)
        for position in rng.integers(0, len(sound), count):
            damaged[position] ^= int(rng.integers(1, 256))
        path.write_bytes(damaged)
        try:
            assert gate(path, Baseline(tmp_path / "none")) == findings
        except (ResultsError, UsageError) as error:
            refusals.append(str(error))
    assert len(refusals) > 20
    assert not any("\n" in refusal for refusal in refusals)


@pytest.mark.parametrize("change", ["number", "text", "attribute", "bound"])
def test_a_value_that_was_changed_in_a_study_file_is_damage(change, tmp_path, stored):
    path = tmp_path / "mixed.nc"
    path.write_bytes((stored[0] / "mixed.nc").read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        group = next(iter(file.groups.values()))
        if change == "number":
            group.variables["error_absolute_u"][0] *= 1.0000001
        elif change == "text":
            group.variables["outcome"].set_auto_chartostring(False)
            group.variables["outcome"][0, 0] = b"C"
        elif change == "attribute":
            file.restricted_to = "nothing"
        else:
            stored_text = group.variables["criterion_json"]
            stored_text.set_auto_chartostring(False)
            changed = stored_text[:].tobytes().replace(b"1.9", b"0.1")
            stored_text[:] = np.frombuffer(changed, "S1").reshape(stored_text.shape)
    with pytest.raises(ResultsError, match="is damaged"):
        gate(path, Baseline(tmp_path / "none"))


def without_a_variable(tree):
    tree["scripted-good"].dataset = tree["scripted-good"].to_dataset(inherit=False).drop_vars("outcome")


def with_values(name, values):
    def damage(tree):
        dataset = tree["scripted-good"].to_dataset(inherit=False)
        tree["scripted-good"].dataset = dataset.assign(
            {name: (dataset[name].dims, np.broadcast_to(values, dataset[name].shape))}
        )

    return damage


def without_its_criteria(tree):
    tree["scripted-good"].dataset = tree["scripted-good"].to_dataset(inherit=False).drop_vars("criterion_json")


def with_criterion(change):
    def damage(tree):
        dataset = tree["scripted-good"].to_dataset(inherit=False)
        stored = change(json.loads(dataset["criterion_json"].values[0]))
        dataset["criterion_json"][0] = stored if isinstance(stored, str) else json.dumps(stored)
        tree["scripted-good"].dataset = dataset

    return damage


@pytest.mark.parametrize(
    "damage",
    [
        without_a_variable,
        with_values("h", "wide"),
        with_values("h", np.nan),
        with_values("courant", 0.0),
        with_values("dt", -1.0),
        with_values("ppc", "two"),
        with_values("error_absolute_u", "small"),
        with_values("metric", "none"),
        without_its_criteria,
        with_criterion(lambda stored: "{"),
        with_criterion(lambda stored: [1]),
        with_criterion(lambda stored: stored | {"colour": "red"}),
        with_criterion(lambda stored: {"type": stored["type"]}),
        with_criterion(lambda stored: {name: value for name, value in stored.items() if name != "type"}),
    ],
)
def test_a_study_that_cannot_be_parsed_is_named_by_gate_and_accept(tmp_path, damage):
    list(run([study()], plan(tmp_path)))
    path = tmp_path / "scripted.nc"
    tree = read_tree(path)
    damage(tree)
    write_tree(path, tree)
    for read in (lambda: gate(path, Baseline(path)), lambda: accept(Baseline(path), [path], "why not")):
        with pytest.raises(
            ResultsError, match=rf"^'{path}' is damaged: run `mpmverify run` again, which sets it aside and makes it anew$"
        ):
            read()


def test_an_error_in_a_criterion_is_not_reported_as_a_damaged_file(tmp_path, monkeypatch):
    def judge(self, evidence):
        raise IndexError("a bug")

    list(run([study()], plan(tmp_path)))
    monkeypatch.setattr(Order, "judge", judge)
    with pytest.raises(IndexError, match="a bug"):
        gate(tmp_path / "scripted.nc", Baseline(tmp_path / "none"))


def test_a_criterion_of_a_missing_series_raises_an_error(tmp_path):
    list(run([study()], plan(tmp_path)))
    path = tmp_path / "scripted.nc"
    tree = read_tree(path)
    absent = {SeriesId("hill", "scripted-good", "nu_C=9"): CRITERION_OF_EACH_KIND[:1]}
    without = tree["scripted-good"].to_dataset(inherit=False).drop_dims("criterion")
    tree["scripted-good"].dataset = with_criteria(without, "scripted-good", absent)
    write_tree(path, tree)
    with pytest.raises(ResultsError, match=r"is declared for scripted/hill/scripted-good \(nu_C=9\), which has no results"):
        gate(path, Baseline(tmp_path / "none"))


def test_a_study_without_solvers_raises_an_error(tmp_path):
    list(run([study()], plan(tmp_path)))
    path = tmp_path / "scripted.nc"
    write_tree(path, xr.DataTree(read_tree(path).to_dataset(inherit=False)))
    with pytest.raises(ResultsError, match="holds nothing to judge"):
        gate(path, Baseline(tmp_path / "none"))


def test_a_study_under_the_file_name_of_another_one_is_refused(tmp_path):
    list(run([study()], plan(tmp_path)))
    (tmp_path / "scripted.nc").rename(tmp_path / "elastic-bar.nc")
    with pytest.raises(ResultsError, match=r"contains the study 'scripted': rename it to 'scripted.nc', or move it away$"):
        read_study(tmp_path / "elastic-bar.nc")

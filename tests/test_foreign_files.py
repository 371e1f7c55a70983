"""Files that mpmverify did not write, or that are damaged, are named; what it did not write is left alone."""

import re

import netCDF4
import pytest
import xarray as xr
from faulty_solvers import study
from stored_results import run_of, solution

from mpmverify.dataset.files import check_ours
from mpmverify.dataset.runs import read_run, write_run
from mpmverify.dataset.study import read_study, write_study
from mpmverify.errors import DamagedError, ResultsError
from mpmverify.judgement.judging import judge

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


def with_numbers_as_schema(path):
    foreign(path)
    with netCDF4.Dataset(path, "a") as file:
        file.setncatts({"mpmverify_kind": path.stem, "mpmverify_schema": [6, 6], "id": [1, 2]})


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
    with_numbers_as_schema,
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

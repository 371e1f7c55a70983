"""The file of a run: it is read back bit for bit, also by other tools, and a change of it is found."""

import dataclasses
import re

import netCDF4
import numpy as np
import pytest
import xarray as xr
from faulty_solvers import transported
from stored_results import EXTREME, bits, run_of, solution

from mpmverify.dataset.runs import read_run, write_run
from mpmverify.errors import DamagedError
from mpmverify.exact.advection import Gaussian, advection
from mpmverify.problem import (
    Discretisation,
)
from mpmverify.solution import Outcome, Status, Work

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

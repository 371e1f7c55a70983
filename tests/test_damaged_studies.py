"""A study file that was changed is told from a sound one, and named."""

import json

import netCDF4
import numpy as np
import pytest
import xarray as xr
from faulty_solvers import plan, study
from stored_results import CRITERION_OF_EACH_KIND, MIXED

from mpmverify.criteria import (
    Order,
)
from mpmverify.criteria.evidence import SeriesId
from mpmverify.dataset.criteria import with_criteria
from mpmverify.dataset.study import read_study, read_tree
from mpmverify.dataset.tree import write_tree
from mpmverify.errors import ResultsError, UsageError
from mpmverify.execution.gate import accept, gate
from mpmverify.execution.runner import run
from mpmverify.judgement.baseline import Baseline


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    list(run([MIXED], plan(folder)))
    return folder


def test_a_study_file_that_was_changed_by_a_byte_is_refused_or_has_the_same_findings(tmp_path, stored):
    """Bytes that no value needs may change; any other change is told, in one sentence."""
    sound = (stored / "mixed.nc").read_bytes()
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
    path.write_bytes((stored / "mixed.nc").read_bytes())
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

"""A study file that was changed is told from a sound one, and named."""

import dataclasses
import json

import netCDF4
import numpy as np
import pytest
from faulty_solvers import plan, study
from stored_results import CRITERION_OF_EACH_KIND, MIXED

from mpmverify.criteria import (
    Order,
)
from mpmverify.criteria.evidence import SeriesId
from mpmverify.dataset.criteria import criterion_table
from mpmverify.dataset.study import read_study, read_study_groups
from mpmverify.dataset.tree import text, variable, write_groups
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


GOOD = "/scripted-good"
"""Group of the solver."""


def without(name):
    return lambda variables: {other: entry for other, entry in variables.items() if other != name}


def with_values(name, values):
    return lambda variables: (
        variables | {name: variable(variables[name].dimensions, np.broadcast_to(values, variables[name].values.shape))}
    )


def with_criterion(change):
    def damage(variables):
        first, *rest = variables["criterion_json"].values.tolist()
        stored = change(json.loads(first))
        changed = stored if isinstance(stored, str) else json.dumps(stored)
        return variables | {"criterion_json": variable("criterion", text([changed, *rest]))}

    return damage


def rewritten(path, change):
    """Write the file of a study again with other variables of the solver."""
    groups = read_study_groups(path)
    write_groups(path, groups | {GOOD: dataclasses.replace(groups[GOOD], variables=change(groups[GOOD].variables))})


@pytest.mark.parametrize(
    "damage",
    [
        without("outcome"),
        with_values("h", "wide"),
        with_values("h", np.nan),
        with_values("courant", 0.0),
        with_values("dt", -1.0),
        with_values("ppc", "two"),
        with_values("error_absolute_u", "small"),
        with_values("metric", "none"),
        without("criterion_json"),
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
    rewritten(path, damage)
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
    absent = {SeriesId("hill", "scripted-good", "nu_C=9"): CRITERION_OF_EACH_KIND[:1]}
    rewritten(path, lambda variables: variables | criterion_table("scripted-good", absent).variables)
    with pytest.raises(ResultsError, match=r"is declared for scripted/hill/scripted-good \(nu_C=9\), which has no results"):
        gate(path, Baseline(tmp_path / "none"))


def test_a_study_without_solvers_raises_an_error(tmp_path):
    list(run([study()], plan(tmp_path)))
    path = tmp_path / "scripted.nc"
    write_groups(path, {"/": read_study_groups(path)["/"]})
    with pytest.raises(ResultsError, match="holds nothing to judge"):
        gate(path, Baseline(tmp_path / "none"))


def test_a_study_under_the_file_name_of_another_one_is_refused(tmp_path):
    list(run([study()], plan(tmp_path)))
    (tmp_path / "scripted.nc").rename(tmp_path / "elastic-bar.nc")
    with pytest.raises(ResultsError, match=r"contains the study 'scripted': rename it to 'scripted.nc', or move it away$"):
        read_study(tmp_path / "elastic-bar.nc")

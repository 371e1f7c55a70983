"""A solver that fails is told which planted faults leave errors like its own; one that is right is told nothing."""

import ast
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from mpmverify import solvers, studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria.evidence import Level
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import ResultsError
from mpmverify.execution import diagnosis as execution
from mpmverify.execution.diagnosis import diagnose, problem_digest
from mpmverify.execution.verify import verify
from mpmverify.judgement import diagnosis
from mpmverify.judgement.diagnosis import TABLE, Likeness, Signatures, measured, read_signatures, signature, similarity
from mpmverify.selftest import signatures
from mpmverify.selftest.faults import Fault
from mpmverify.selftest.planting import copied, planted
from mpmverify.selftest.signatures import BENCHES, VARIANTS, make_signatures
from mpmverify.selftest.textbook_faults import CAUSES, returning_gradient
from mpmverify.solvers.textbook import Textbook
from mpmverify.study import Case

SOURCES = Path(solvers.__file__).parent
SPIN = "a strain increment without its spin part"
SPLINES = Textbook("USL", "FLIP", "quadratic")


def case(study: str, name: str) -> Case:
    return next(case for case in studies.get(study).cases if case.name == name)


LAYER = dataclasses.replace(studies.get("loads-and-supports"), cases=(case("loads-and-supports", "layer, splines"),))


# The measure of likeness.


def test_similarity_is_one_for_the_same_change_and_none_for_another_place_or_direction():
    change = np.array([1.0, 0.0, -0.5, 2.0])
    assert similarity(change, change) == 1
    assert similarity(change, np.array([0.0, 3.0, 0.0, 0.0])) == 0
    assert similarity(change, -change) == 0
    assert similarity(change, 0 * change) == similarity(0 * change, 0 * change) == 0


def test_similarity_sees_amplitudes_and_no_small_changes():
    change = np.array([1.1, 0.0, -0.6])
    assert similarity(change, np.array([0.35, 0.0, -0.35])) == pytest.approx(0.5)
    assert similarity(change, change + np.array([0.0, 0.09, 0.0])) == 1


def test_similarity_is_over_the_entries_that_both_have():
    assert similarity(np.array([1.0, np.nan, 2.0]), np.array([1.0, 2.0, np.nan])) == 1


def test_a_signature_has_the_decades_of_errors_and_defects_within_bounds():
    error, size = np.array([1.0, 2.0, 200.0, 2e-9]), np.full(len(NORMS), 2.0)
    level = Level(
        "a", "s", "", 0.25, 0.5, 2, "", errors={"stress": (error, size)}, metrics={"mass_defect": 1e-16, "onset_stress": 0.1}
    )
    at = "study | a | h=0.25 nu_C=0.5 ppc=2"
    assert signature("study", [measured(level)]) == {
        f"{at} | completed": 0,
        f"{at} | stress L2": 0,
        f"{at} | stress Linf": 1,
        f"{at} | stress L2-max": -5,
        f"{at} | mass_defect": -4,
    }
    failed = dataclasses.replace(level, outcome="unstable; at step 3", errors={}, metrics={})
    assert signature("study", [measured(failed)]) == {f"{at} | completed": 2}


# The table.


@pytest.mark.parametrize("cause", CAUSES)
def test_every_fault_fits_the_source_of_the_textbook(cause):
    for fault in CAUSES[cause]:
        plain, text = (
            one.planted(SOURCES)["textbook.py"]
            for one in (returning_gradient(Fault("", "", "", ())), returning_gradient(fault))
        )
        assert ast.dump(ast.parse(text)) != ast.dump(ast.parse(plain))


def test_the_table_is_of_the_problems_and_faults_that_there_are():
    table = read_signatures()
    assert table.problems == {f"{b.study} | {b.case}": problem_digest(case(b.study, b.case).problem) for b in BENCHES}
    assert {cause for changes in table.changes.values() for cause in changes} == set(CAUSES)
    assert list(table.sound) == [Textbook(*choices).name for choices in VARIANTS]
    assert TABLE.stat().st_size < 300_000


def test_problems_are_the_same_up_to_their_last_digits():
    problem = case(BENCHES[0].study, BENCHES[0].case).problem

    def stretched(factor):
        material = dataclasses.replace(problem.problem.material, density=problem.problem.material.density * factor)
        return problem_digest(dataclasses.replace(problem, problem=dataclasses.replace(problem.problem, material=material)))

    assert stretched(1 + 4e-16) == problem_digest(problem) != stretched(1 + 1e-6)


def test_the_table_holds_what_the_code_gives_today(monkeypatch):
    """Of one case, one variant and one fault, made anew."""
    monkeypatch.setattr(signatures, "BENCHES", [bench for bench in BENCHES if bench.case == LAYER.cases[0].name])
    monkeypatch.setattr(signatures, "CAUSES", {SPIN: CAUSES[SPIN]})
    monkeypatch.setattr(signatures, "VARIANTS", VARIANTS[:1])
    made, table = make_signatures(studies.get, SOURCES, Textbook, 1), read_signatures()
    rows = [table.entries.index(entry) for entry in made.entries]
    assert len(rows) == 2 * 15
    np.testing.assert_allclose(made.sound[SPLINES.name], table.sound[SPLINES.name][rows], atol=0.01)
    (change,), (known,) = (one.changes[SPLINES.name][SPIN] for one in (made, table))
    np.testing.assert_allclose(change, known[rows], atol=0.01)


def test_a_table_is_read_as_it_was_written(tmp_path):
    rows = np.array([0.0, -1.23, np.nan]), np.array([2.0, np.nan, 0.01])
    table = Signatures({"a | b": "1f"}, ("x", "y", "z"), {"v": rows[0]}, {"v": {"one": (rows[1], rows[0]), "two": (rows[1],)}})
    table.write(tmp_path / "table.json")
    read = read_signatures(tmp_path / "table.json")
    assert (read.problems, read.entries) == (table.problems, table.entries)
    np.testing.assert_array_equal(read.sound["v"], rows[0])
    assert read.changes["v"].keys() == {"one", "two"}
    np.testing.assert_array_equal(read.changes["v"]["one"], rows[::-1])


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"problems": {}, "entries": ["a"], "sound": {"v": "no"}, "changes": {}}'])
def test_a_file_that_is_no_table_is_refused_in_one_sentence(tmp_path, text):
    (tmp_path / "table.json").write_text(text, encoding="utf-8")
    with pytest.raises(ResultsError, match=r"is no table of signatures: make it with `mpmverify selftest --signatures FILE`"):
        read_signatures(tmp_path / "table.json")


def test_a_variant_that_is_left_out_is_diagnosed_by_the_others():
    """The cause is among the first three in most cases, of those that can be planted in another variant, too."""
    table = read_signatures()
    hits = []
    for variant, changes in table.changes.items():
        others = table.without(variant)
        known = {cause for of in others.changes.values() for cause in of}
        for cause in known & changes.keys():
            for change in changes[cause]:
                row = table.sound[variant] + change
                found = {place: value for place, value in zip(table.entries, row, strict=True) if np.isfinite(value)}
                hits.append(cause in [one.cause for one in others.likenesses(found)[:3]])
    assert len(hits) > 100
    assert np.mean(hits) >= 0.6, f"{sum(hits)} of {len(hits)}"


# What is said.


@pytest.fixture
def faulty(tmp_path):
    fault = CAUSES[SPIN][0]
    with planted(fault, SOURCES, tmp_path) as package:
        yield copied(package, SPLINES)


def test_a_failed_order_says_the_size_and_the_onset_of_the_error(faulty):
    failed = [finding for finding in verify(faulty, LAYER) if finding.verdict is Verdict.FAIL]
    assert len(failed) > 1
    assert "at h=0.03125 the error is 0." in failed[0].reason
    assert "of the field, and shows from t = " in failed[0].reason


def test_errors_of_few_cases_or_of_a_sound_variant_have_no_cause():
    table = read_signatures()
    (variant, changes), *_ = table.changes.items()
    places = dict(zip(table.entries, table.sound[variant] + changes[SPIN][0], strict=True))
    wrong = {place: value for place, value in places.items() if np.isfinite(value)}
    cases = list(dict.fromkeys(tuple(place.split(" | ")[:2]) for place in wrong))

    def said(number, found):
        return diagnosis.diagnosis({p: v for p, v in found.items() if tuple(p.split(" | ")[:2]) in cases[:number]})

    assert SPIN in said(len(cases), wrong)
    assert said(diagnosis.LEAST_CASES - 1, wrong) == ""
    for sound in table.sound.values():
        right = {place: value for place, value in zip(table.entries, sound, strict=True) if np.isfinite(value)}
        assert diagnosis.diagnosis(right) == ""


def test_no_cause_is_named_that_is_not_similar_enough(monkeypatch):
    alike = [Likeness("one", 0.97), Likeness("two", diagnosis.THRESHOLD), Likeness("three", diagnosis.THRESHOLD - 0.01)]
    monkeypatch.setattr(Signatures, "likenesses", lambda *_: tuple(alike))
    monkeypatch.setattr(diagnosis, "LEAST_CASES", 0)
    assert diagnosis.diagnosis({}).startswith(f"errors like these come from one (0.97) or two ({diagnosis.THRESHOLD:.2f}): ")
    alike[:] = alike[2:]
    assert diagnosis.diagnosis({}) == ""


def test_an_own_solver_whose_errors_are_on_no_case_of_the_table_has_no_cause():
    assert diagnosis.diagnosis({"another study | a | h=1 | stress L2": 0.0}) == ""


def test_a_table_of_another_problem_is_refused_in_one_sentence(monkeypatch, faulty):
    stale = dataclasses.replace(read_signatures(), problems={"loads-and-supports | layer, splines": "another"})
    monkeypatch.setattr(execution, "read_signatures", lambda: stale)
    said = diagnose([LAYER], {LAYER.name: []}, faulty.name)
    assert said == (
        "no cause is known: the table of signatures is of another problem than loads-and-supports, layer, splines: "
        "make it with `mpmverify selftest --signatures FILE`"
    )


def run_layer(folder, monkeypatch, faulty, change=""):
    """Output of a run of a faulty code on a case of the table, which a line of Python may change, and its pages by name."""
    from click.testing import CliRunner

    from mpmverify.cli import cli

    monkeypatch.chdir(folder)
    monkeypatch.setattr(diagnosis, "LEAST_CASES", 1)
    home, tag = type(faulty).__module__, "other" if change else "same"  # modules of one name are loaded once a process
    (folder / f"{tag}_code.py").write_text(
        f"from {home} import Textbook\nOWN = Textbook('USL', 'FLIP', 'quadratic')\n", encoding="utf-8"
    )
    (folder / f"{tag}_layer.py").write_text(
        "from dataclasses import replace\nfrom mpmverify import studies\nSTUDY = studies.get('loads-and-supports')\n"
        f"[case] = [case for case in STUDY.cases if case.name == 'layer, splines']\n{change}\n"
        "STUDY = replace(STUDY, cases=(case,))\n",
        encoding="utf-8",
    )
    shown = CliRunner().invoke(cli, ["run", f"{tag}_layer.py", "--with", f"{tag}_code.py:OWN", "--out", "out", "--jobs", "1"])
    assert shown.exit_code == 1, shown.output
    pages = {page.name: page.read_text(encoding="utf-8") for page in (folder / "out" / "report").glob("*.html")}
    return " ".join(shown.output.split()), pages


def test_a_run_with_an_own_solver_says_the_causes_once_and_on_its_page(tmp_path, monkeypatch, faulty):
    said, pages = run_layer(tmp_path, monkeypatch, faulty)
    sentence = f"rrors like these come from {SPIN} ("
    assert said.count(f"{faulty.name}: e{sentence}") == said.count("like these") == 1
    assert [name for name, text in pages.items() if sentence in text] == [f"solver-{faulty.name}.html"]


def test_another_problem_of_the_same_name_has_no_causes_on_its_page_either(tmp_path, monkeypatch, faulty):
    change = "case = replace(case, problem=replace(case.problem, problem=replace(case.problem.problem, name='another')))"
    said, pages = run_layer(tmp_path, monkeypatch, faulty, change)
    assert "of another problem than loads-and-supports, layer, splines" in said
    assert f"solver-{faulty.name}.html" in pages
    assert not [name for name, text in pages.items() if "rrors like these come from" in text]


def test_the_command_writes_a_table(tmp_path, monkeypatch):
    from click.testing import CliRunner

    from mpmverify.cli import cli

    made = Signatures({"a | b": "1f"}, ("x",), {"v": np.array([1.0])}, {"v": {}})
    monkeypatch.setattr(signatures, "make_signatures", lambda *_: made)
    shown = CliRunner().invoke(cli, ["selftest", "--signatures", str(tmp_path / "table.json"), "--out", str(tmp_path / "out")])
    assert shown.exit_code == 0, shown.output
    assert json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["sound"] == {"v": [100]}
    assert not (tmp_path / "out").exists()

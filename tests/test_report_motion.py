"""The exact solution in motion: its frames are the stored times, and it stops where the reader wants no motion."""

import dataclasses
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import test_report_fields
from browser import BROWSER, acted
from hypothesis import given
from hypothesis import strategies as st
from sample_study import HOSTILE, store, study

from mpmverify.dataset.files import Results
from mpmverify.reports import render
from mpmverify.reports.motion import LONGEST, MARGIN, POINTS, WIDTH, motion
from mpmverify.reports.reader import read
from mpmverify.reports.record import Case, Profile, Record, Series

CASE = Case("case", "", "", (), (("domain", "[0, 1] m"),), "u")


def record(*profiles: Profile | None) -> Record:
    series = tuple(
        Series("case", f"solver {k}", "Scheme", "ladder", "h", {}, (), {}, {}, (), profile=profile)
        for k, profile in enumerate(profiles)
    )
    return Record("sample", {}, (CASE,), {}, series)


def profile(exact: np.ndarray, h: float = 0.1, name: str = "u") -> Profile:
    times, points = exact.shape
    return Profile(h, np.linspace(0, 1, times), np.linspace(0, 2, points), {name: exact}, {name: exact}, {name: "m"})


def wave(times: int = 17, points: int = 128) -> np.ndarray:
    return np.sin(2 * np.pi * (np.linspace(0, 1, points) - np.linspace(0, 1, times)[:, None]))


@given(st.integers(2, 60), st.integers(2, 300))
def test_the_frames_are_stored_times_side_by_side(times: int, points: int) -> None:
    made = motion(record(profile(wave(times, points) + 0.1 * np.arange(times)[:, None])), CASE)
    assert made is not None
    ElementTree.fromstring(made.svg)
    frames = re.findall(r'<g transform="translate\((\d+) 0\)">', made.svg)
    count = min(times, LONGEST)
    assert [int(x) for x in frames] == [k * WIDTH for k in range(count)]
    assert f"--end:-{count * WIDTH}px" in made.svg
    assert f"steps({count})" in made.svg
    (telling,) = re.findall(r"--at:-(\d+)px", made.svg)
    assert int(telling) % WIDTH == 0
    assert int(telling) < count * WIDTH
    paths = re.findall(r'class="exact" d="([^"]*)"', made.svg)
    assert len(paths) == count
    for path in paths:
        places = [tuple(map(float, pair.split())) for pair in re.split("[ML]", path)[1:]]
        assert 2 <= len(places) <= POINTS
        assert all(MARGIN <= x <= WIDTH - MARGIN and 0 <= y <= 96 for x, y in places)
    assert made.caption == "Exact u, 0 to 1 s"


def test_a_field_that_does_not_move_has_no_film() -> None:
    assert motion(record(), CASE) is None
    assert motion(record(None), CASE) is None
    assert motion(record(profile(np.ones((17, 9)))), CASE) is None
    assert motion(record(profile(np.zeros((17, 9)))), CASE) is None
    assert motion(record(profile(wave(1, 9))), CASE) is None
    assert motion(record(profile(np.full((17, 9), math.nan))), CASE) is None


def test_the_quantity_of_the_case_is_shown_where_it_was_kept_else_another_that_moves() -> None:
    other = profile(wave(), h=0.01, name="stress")
    made = motion(record(other, profile(wave(), h=0.1)), CASE)
    assert made is not None
    assert made.caption.startswith("Exact u,")
    made = motion(record(other, profile(np.ones((17, 9)))), CASE)
    assert made is not None
    assert made.caption.startswith("Exact stress,")


def test_a_path_is_broken_where_the_exact_field_is_not_finite() -> None:
    exact = wave()
    exact[:, 60:70] = math.nan
    made = motion(record(profile(exact)), CASE)
    assert made is not None
    assert "nan" not in made.svg
    assert all(path.count("M") == 2 for path in re.findall(r'class="exact" d="([^"]*)"', made.svg))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_body_in_several_dimensions_moves_with_its_exact_positions(tmp_path: Path, dimension: int) -> None:
    results = Results(tmp_path)
    test_report_fields.store(results, dimension)
    known = read(results.study("sample"))
    (case,) = known.cases
    made = motion(known, case)
    assert made is not None
    ElementTree.fromstring(made.svg)
    assert made.svg.count("<text") == 5
    assert "<script>" not in made.svg
    render(results)
    text = (results.report / "problems.html").read_text(encoding="utf-8")
    assert text.count('<svg class="motion field"') == 1
    assert "Hold all moving pictures" in text
    spatial = known.series[0].spatial
    assert spatial is not None
    still = dataclasses.replace(spatial, exact={})
    held = dataclasses.replace(known, series=(dataclasses.replace(known.series[0], spatial=still),))
    assert motion(held, case) is None


def test_names_never_become_markup() -> None:
    case = dataclasses.replace(CASE, name=HOSTILE)
    held = record(profile(wave(), name=HOSTILE))
    series = tuple(dataclasses.replace(one, case=HOSTILE) for one in held.series)
    made = motion(dataclasses.replace(held, series=series), case)
    assert made is not None
    ElementTree.fromstring(made.svg)
    assert "<script" not in made.svg


LOOK = """
  const films = () => document.getAnimations().filter((one) => one.animationName === "film").map((one) => one.playState);
  for (const folded of document.querySelectorAll("details")) folded.open = true;
  await pause();
  const outcome = { moving: films(), seen: document.querySelectorAll("svg.motion").length };
  const [one] = document.querySelectorAll(".moving input");
  one.click();
  await pause();
  outcome.one = films();
  one.click();
  document.querySelector("#stop").click();
  await pause();
  outcome.all = films();
  outcome.offered = getComputedStyle(document.querySelector(".stop")).display;
  return outcome;
"""


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
def test_a_reader_can_hold_one_picture_or_all_and_none_moves_where_motion_is_reduced(tmp_path: Path) -> None:
    results = Results(tmp_path / "results")
    store(results, study(solvers=("good",)))
    store(results, study("second", ("good",)))
    render(results)
    page = results.report / "problems.html"
    found = acted(page, results.report, LOOK, tmp_path / "profile")
    assert found["faults"] == []
    assert (found["seen"], found["moving"]) == (2, ["running", "running"])
    assert sorted(found["one"]) == ["paused", "running"]
    assert found["all"] == ["paused", "paused"]
    still = acted(page, results.report, LOOK, tmp_path / "still", "--force-prefers-reduced-motion")
    assert (still["seen"], still["moving"], still["offered"]) == (2, [], "none")

"""Fields in two and three dimensions in the report: their data, their pictures, and the panel in a browser."""

import base64
import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from browser import BROWSER, acted
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.criteria import Balance
from mpmverify.criteria.evidence import Level, SeriesId, evidence_by_series
from mpmverify.dataset.files import Results
from mpmverify.dataset.snapshots import Snapshots
from mpmverify.dataset.study import write_study
from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.steffen import steffen
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.judging import judge
from mpmverify.problem import Discretisation
from mpmverify.reports import field_points, fields, render
from mpmverify.reports.colours import PALETTES
from mpmverify.reports.field_panel import field_panels
from mpmverify.reports.field_still import field_still, main_quantity
from mpmverify.reports.fields import Scale
from mpmverify.reports.reader import read
from mpmverify.reports.record import Field, Record
from mpmverify.reports.thumbnails import field_thumbnail
from mpmverify.study import Case, Refinement, Series, Study

HOSTILE = "<script>alert('x')</script> & \"quoted\""
ROOM = 10_000_000
LOST = 7
"""Index of the point whose stress is not finite."""


@dataclasses.dataclass(frozen=True)
class Scheme:
    """Stand-in for a solver."""

    name: str

    @property
    def orders(self) -> dict[str, float]:
        return {}


def shot(case: str, label: str, dimension: int, points: int = 12, outputs: int = 5) -> Snapshots:
    """Return a body that is stretched and carried along, with a small smooth error and a point without a finite stress."""
    axes = np.meshgrid(*[(np.arange(points) + 0.5) / points] * dimension, indexing="ij")
    reference = np.stack([axis.ravel() for axis in axes], axis=1)
    time = np.linspace(0, 0.5, outputs)
    exact: dict[str, np.ndarray] = {
        "displacement": time[:, None, None] * (0.3 + 0.2 * reference),
        "velocity": np.broadcast_to(0.3 + 0.2 * reference, (outputs, *reference.shape)).copy(),
    }
    wave = np.sin(np.pi * reference[:, :1] + time[:, None, None])
    exact["stress"] = 1e5 * wave * np.arange(1, (3 if dimension == 2 else 6) + 1)
    numerical = {name: values * (1 + 1e-3 * np.cos(reference[:, 1])[:, None]) for name, values in exact.items()}
    numerical["stress"][-1, LOST] = np.nan
    histories = {"time": time, "mass": np.ones(outputs)}
    return Snapshots(case, label, 1 / points, time, reference, numerical, exact, histories)


def store(results: Results, dimension: int, solvers: tuple[str, ...] = ("one", "two & more"), **choices: int) -> None:
    """Write a study of one case."""
    name, label = f"body {HOSTILE}", f"nu_C=0.5 {HOSTILE}"
    problem = axis_aligned(dimension) if dimension > 1 else steffen()
    ladder = Refinement(label, (Discretisation(1 / 4, 0.5),), quick=1)
    series = tuple(Series(Scheme(solver), ladder, (Balance("mass", "inflow", "made so"),)) for solver in solvers)
    declared = Study("sample", "Sample", "A summary.", (Case(name, problem, series, "displacement"),))
    levels = [
        Level(name, solver, label, 1 / 4, 0.5, 1, f"{k}", metrics={"mass_defect": 0.0}) for k, solver in enumerate(solvers)
    ]
    one = {"displacement": np.zeros((3, 4, 1)), "u": np.zeros((3, 4, 1))}
    line = Snapshots(name, label, 1 / 4, np.arange(3.0), np.arange(4.0)[:, None], one, one, {"time": np.arange(3.0)})
    shots = {SeriesId(name, s, label): shot(name, label, dimension, **choices) if dimension > 1 else line for s in solvers}
    judged = judge("sample", declared.criteria(), evidence_by_series(levels), Baseline(Path("none")), "")
    results.create()
    write_study(results.study("sample"), declared, levels, shots, judged, tier="quick", inputs="inputs", run="")


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Results]:
    table = {dimension: Results(tmp_path_factory.mktemp(f"results-{dimension}")) for dimension in (1, 2, 3)}
    for dimension, results in table.items():
        store(results, dimension)
        render(results)
    return table


def record(results: Results) -> Record:
    return read(results.study("sample"))


def first_field(results: Results) -> Field:
    field = record(results).series[0].spatial
    assert field is not None
    return field


def page(results: Results) -> str:
    return (results.report / "sample.html").read_text(encoding="utf-8")


def panel_data(results: Results) -> dict:
    (text,) = re.findall(r'<script type="application/json" class="points">(.*?)</script>', page(results), re.DOTALL)
    return json.loads(text)


def unpacked(column: dict, rows: int, points: int) -> np.ndarray:
    """Decode a column as the page does."""
    if not column["data"]:
        return np.full((rows, points), column["low"])
    steps = np.frombuffer(base64.b64decode(column["data"]), dtype="<i2").astype(float)
    return np.where(steps == -32768, np.nan, column["low"] + (steps + 32767) * column["scale"]).reshape(rows, points)


# Data.


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_field_is_read_back_from_a_study_file(stored: dict[int, Results], dimension: int) -> None:
    field, made = first_field(stored[dimension]), shot("", "", dimension)
    assert field.dimension == dimension
    np.testing.assert_allclose(field.time, made.time)
    np.testing.assert_allclose(field.reference, made.reference, rtol=1e-6)
    for quantity, suffix, place in (("displacement", "y", 1), ("stress", "xy", 2 if dimension == 2 else 3)):
        name = f"{quantity}_{suffix}"
        np.testing.assert_allclose(field.numerical[name], made.fields[quantity][..., place], rtol=1e-6)
        np.testing.assert_allclose(field.exact[name], made.exact[quantity][..., place], rtol=1e-6)
        np.testing.assert_allclose(field.error[name], (made.fields[quantity] - made.exact[quantity])[..., place], rtol=1e-4)
    assert field.units["stress_xx"] == "Pa"


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_values_of_a_page_are_those_of_the_file_to_a_step_of_their_encoding(
    stored: dict[int, Results], dimension: int
) -> None:
    field, data = first_field(stored[dimension]), panel_data(stored[dimension])
    body = data["series"][0]
    rows, points = len(body["t"]), body["shown"]
    assert points == len(field.reference)
    for quantity in fields.quantities(field):
        columns = body["fields"][quantity.key]
        for part, expected in (("exact", quantity.exact), ("error", quantity.error)):
            column = data["columns"][columns[part]]
            assert expected is not None
            np.testing.assert_allclose(unpacked(column, rows, points), expected, rtol=1e-7, atol=0.51 * column["scale"])
    for axis, number in enumerate(body["reference"]):
        column = data["columns"][number]
        np.testing.assert_allclose(unpacked(column, 1, points)[0], field.reference[:, axis], atol=0.51 * column["scale"])


def test_equal_columns_of_several_series_are_stored_once(stored: dict[int, Results]) -> None:
    first, second = panel_data(stored[2])["series"]
    assert first["fields"] == second["fields"]
    assert first["reference"] == second["reference"]


def test_points_are_at_their_reference_position_plus_the_displacement(stored: dict[int, Results]) -> None:
    made = shot("", "", 2)
    field = first_field(stored[2])
    np.testing.assert_allclose(field_points.positions(field), made.reference + made.fields["displacement"], atol=1e-6)
    np.testing.assert_allclose(
        field_points.positions(field, exact=True), made.reference + made.exact["displacement"], atol=1e-6
    )
    lost = dict(field.numerical) | {"displacement_x": np.full_like(field.numerical["displacement_x"], np.nan)}
    places = field_points.positions(dataclasses.replace(field, numerical=lost))
    np.testing.assert_allclose(places[..., 0], field_points.positions(field, exact=True)[..., 0])
    still = dataclasses.replace(field, numerical={"stress_xx": field.numerical["stress_xx"]}, exact={}, error={})
    np.testing.assert_array_equal(field_points.positions(still)[0], field.reference)


def field_of(numerical: dict[str, float], error: dict[str, float] | None = None) -> Field:
    """Return a field of one point with the given components and errors."""
    known = {name: np.array([[value]]) for name, value in numerical.items()}
    off = {name: np.array([[(error or {}).get(name, 0.0)]]) for name in numerical}
    dimension = 3 if any("z" in name for name in numerical) else 2
    sums = {name: known[name] + off[name] for name in known}
    return Field(1.0, np.zeros(1), np.zeros((1, dimension)), sums, known, off, dict.fromkeys(known, "Pa"))


def made_quantity(field: Field, key: str) -> fields.Quantity:
    return next(entry for entry in fields.quantities(field) if entry.key == key)


@pytest.mark.parametrize(
    ("stress", "expected"),
    [
        ({"xx": 3.0}, 3.0),
        ({"xx": 2.0, "yy": 2.0}, 2.0),
        ({"xy": 2.0}, 2 * np.sqrt(3)),
        ({"xx": 5.0, "yy": 5.0, "zz": 5.0}, 0.0),
        ({"yz": 1.0, "zx": 1.0, "zz": 0.0}, np.sqrt(6)),
        ({"xx": 1.0, "yy": -1.0, "zz": 0.0}, np.sqrt(3)),
    ],
    ids=["uniaxial", "equal and biaxial", "shear", "hydrostatic", "shear out of plane", "pure shear by normal stresses"],
)
def test_the_von_mises_stress_of_simple_states(stress: dict[str, float], expected: float) -> None:
    names = ("xx", "yy", "zz", "xy", "yz", "zx") if {"zz", "yz", "zx"} & stress.keys() else ("xx", "yy", "xy")
    field = field_of({f"stress_{name}": stress.get(name, 0.0) for name in names})
    quantity = made_quantity(field, "stress_mises")
    assert quantity.numerical.item() == pytest.approx(expected, abs=1e-12)
    assert ("σzz taken as 0" in quantity.name) == ("zz" not in names), (
        "the assumption is said where the component is not stored"
    )


@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=6), st.floats(-10, 10))
def test_the_von_mises_stress_does_not_see_a_pressure(components: list[float], pressure: float) -> None:
    stress = {f"stress_{name}": value for name, value in zip(("xx", "yy", "zz", "xy", "yz", "zx"), components, strict=True)}
    pressed = {name: value - pressure * (name[-1] == name[-2]) for name, value in stress.items()}
    free, under = (made_quantity(field_of(state), "stress_mises").numerical.item() for state in (stress, pressed))
    assert under == pytest.approx(free, abs=1e-4)


def test_the_error_of_a_magnitude_keeps_the_digits_of_a_small_error() -> None:
    field = field_of({"velocity_x": 3.0, "velocity_y": 4.0}, {"velocity_x": 3e-20, "velocity_y": 4e-20})
    magnitude = made_quantity(field, "velocity_magnitude")
    assert magnitude.error is not None
    assert magnitude.error.item() == pytest.approx(5e-20)
    assert magnitude.exact is not None
    assert magnitude.exact.item() == 5


# Which points and scales.


@given(st.integers(1, 400), st.sampled_from([2, 3]), st.integers(0, 9))
def test_a_subsample_is_within_its_size_without_repetition_and_the_same_each_time(most: int, dimension: int, seed: int) -> None:
    reference = np.random.default_rng(seed).random((500, dimension)) * [1.0, 5.0, 0.1][:dimension]
    chosen = field_points.subsample(reference, most)
    assert 0 < len(chosen) <= most
    assert len(set(chosen.tolist())) == len(chosen)
    np.testing.assert_array_equal(chosen, field_points.subsample(reference.copy(), most))


def test_a_subsample_of_separate_bodies_has_points_of_each() -> None:
    body = np.stack(np.meshgrid(*[np.linspace(0, 0.1, 20)] * 2), axis=-1).reshape(-1, 2)
    reference = np.concatenate([body, body + np.array([5.0, 0.0])])
    chosen = field_points.subsample(reference, 200)
    assert 100 < len(chosen) <= 200
    assert 40 < np.sum(chosen < len(body)) < len(chosen) - 40
    assert len(field_points.subsample(np.zeros((9, 2)), 3)) == 1
    assert len(field_points.subsample(body, 400)) == 400


def test_a_subsample_of_a_lattice_is_a_coarser_lattice() -> None:
    reference = np.stack(np.meshgrid(*[np.arange(24) / 24] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    chosen = reference[field_points.subsample(reference, 150)]
    assert len(chosen) == 144
    assert np.unique(np.diff(np.unique(chosen[:, 0])).round(9)).tolist() == [round(2 / 24, 9)]


def test_a_page_says_how_many_points_it_shows_and_keeps_to_its_room(stored: dict[int, Results]) -> None:
    found = record(stored[2])
    (whole,) = field_panels(found, {found.cases[0].name: [0]}, ROOM).values()
    (part,) = field_panels(found, {found.cases[0].name: [0]}, len(whole.still) + len(whole.data) // 2).values()
    assert json.loads(whole.data)["series"][0]["count"] == "144 of 144 points shown"
    larger = dataclasses.replace(found, series=tuple(dataclasses.replace(s, spatial=_larger()) for s in found.series))
    (less,) = field_panels(larger, {found.cases[0].name: [0]}, 200_000).values()
    assert json.loads(part.data)["series"][0]["shown"] == 144, "few points are never left out"
    body = json.loads(less.data)["series"][0]
    assert (len(body["t"]), body["t"][-1]) == (9, 0.5), "output times are given up first, the last one never"
    assert body["count"] == "1\u2009225 of 4\u2009900 points shown"
    assert len(less.data) + len(less.still) <= 200_000


def _larger() -> Field:
    made = shot("", "", 2, points=70, outputs=40)
    numerical = {f"displacement_{axis}": made.fields["displacement"][..., k] for k, axis in enumerate("xy")}
    return Field(made.h, made.time, made.reference, numerical, {}, {}, dict.fromkeys(numerical, "m"))


def test_at_most_sixteen_output_times_are_shown_with_the_first_and_the_last() -> None:
    rows = field_points.outputs(_larger())
    assert len(rows) == 16
    assert (rows[0], rows[-1]) == (0, 39)


def quantity_of(exact: np.ndarray, error: np.ndarray, key: str = "stress_xx") -> fields.Quantity:
    return fields.Quantity(key, key, "stress", "Pa", exact + error, exact, error)


def test_scales_of_colours() -> None:
    ramp, none = np.linspace(0, 1, 11)[None], np.zeros((1, 11))
    assert fields.scale(quantity_of(ramp, none), 1.0) == Scale(0.0, 1.0, False)
    assert fields.scale(quantity_of(2 * ramp - 1, none), 1.0) == Scale(-1.0, 1.0, True)
    assert fields.scale(quantity_of(ramp, none + 1e9), 1.0) == Scale(0.0, 1.5, False), (
        "an unstable field does not hide the exact one"
    )
    assert fields.scale(quantity_of(none + 3, none), 3.0) == Scale(0.0, 3.0, False), "uniform"
    assert fields.scale(quantity_of(none, none + 1e-12), 1.0) == Scale(-1.0, 1.0, True), "round-off beside another component"
    assert fields.scale(quantity_of(none, none), 0.0) == Scale(0.0, 0.0, True)
    assert fields.scale(quantity_of(none, 1e-3 * ramp), 1e-3).high == pytest.approx(1e-3), "the exact field vanishes"


def test_one_point_that_has_left_the_body_does_not_coarsen_the_others(stored: dict[int, Results]) -> None:
    field = first_field(stored[2])
    error = {name: values.copy() for name, values in field.error.items()}
    error["displacement_x"][-1, 0] = 1e12
    flown = dataclasses.replace(field, error=error, numerical={name: field.exact[name] + error[name] for name in error})
    every = fields.quantities(flown)
    quantity = made_quantity(flown, "displacement_x")
    held = fields.held_error(quantity, fields.size_of_group(quantity.group, every))
    assert held.max() < 10
    np.testing.assert_array_equal(held[:, 1:], field.error["displacement_x"][:, 1:])
    low, high = field_points.view(flown, 0.1)
    assert (high - low).max() < 3


def test_a_field_that_has_vanished_is_drawn_where_it_was_largest_or_in_another_quantity(stored: dict[int, Results]) -> None:
    gone = np.array([[0.0], [2.0], [1e-17]])
    assert fields.telling(quantity_of(gone, 0 * gone), np.arange(3)) == 1
    assert fields.telling(quantity_of(gone, 0 * gone), np.array([0, 1])) == 1
    field = field_of(
        {"displacement_x": 1e-17, "displacement_y": 0.0, "velocity_x": 1.0, "velocity_y": 0.0}, {"displacement_x": 1e-3}
    )
    assert main_quantity(field, "displacement") == "velocity_magnitude"
    assert main_quantity(first_field(stored[2]), "displacement") == "displacement_magnitude"
    assert main_quantity(first_field(stored[2]), "stress") == "stress_mises"


# Pages and pictures.


def test_only_a_case_in_two_or_three_dimensions_has_a_panel(stored: dict[int, Results]) -> None:
    assert [page(stored[dimension]).count('<div class="panel field"') for dimension in (1, 2, 3)] == [0, 1, 1]
    assert ["assets/fields.js" in page(stored[dimension]) for dimension in (1, 2, 3)] == [False, True, True]
    assert ["<h3>Histories</h3>" in page(stored[dimension]) for dimension in (1, 2, 3)] == [False, True, True]
    assert [bool(field_thumbnail(record(stored[dimension]))) for dimension in (1, 2, 3)] == [False, True, True]
    assert ['data-role="field-view"' in page(stored[dimension]) for dimension in (2, 3)] == [False, True]


def test_a_value_that_is_not_finite_is_marked_in_the_picture_and_in_its_caption(stored: dict[int, Results]) -> None:
    field = first_field(stored[2])
    picture, caption = field_still(field, "stress_xx")
    missing = PALETTES["light"].missing
    assert picture.count(missing) == 2, "in the numerical field and in the difference"
    assert "crosses: 1 point whose value is not finite" in caption
    picture, caption = field_still(field, "displacement_x")
    assert missing not in picture
    assert "finite" not in caption


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_static_picture_has_a_point_for_each_value_and_no_number_that_is_not_one(
    stored: dict[int, Results], dimension: int
) -> None:
    picture, caption = field_still(first_field(stored[dimension]), "velocity_magnitude")
    assert picture.count("h0") == 3 * 144, "in three dimensions one layer of twelve"
    assert "nan" not in picture
    assert ("slice across z" in caption) == (dimension == 3)


def test_names_are_escaped(stored: dict[int, Results]) -> None:
    for dimension in (2, 3):
        assert "<script>alert" not in page(stored[dimension])
        assert "<script>alert" not in field_thumbnail(record(stored[dimension]))


# In a browser.


GRAPHICS = {
    "webgl": ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
    "without webgl": ["--disable-gpu", "--disable-3d-apis"],
}
ACT = """
  const panel = document.querySelector("[data-points]");
  panel.scrollIntoView({ behavior: "instant" });
  const role = (name) => panel.querySelector(`[data-role="field-${name}"]`);
  while (!role("note").textContent) await frame();
  const canvas = panel.querySelector("canvas");
  const set = async (name, value) => {
    role(name).value = value;
    role(name).dispatchEvent(new Event(role(name).matches("input") ? "input" : "change"));
    await pause();
  };
  const picture = () => {
    const { data } = canvas.getContext("2d").getImageData(60, 20, canvas.width - 80, canvas.height - 70);
    let sum = 0, inked = 0;
    for (let k = 0; k < data.length; k += 4) {
      if (data[k + 3]) inked += 1;
      sum = (sum * 31 + data[k] + 7 * data[k + 1] + 13 * data[k + 2]) % 1000000007;
    }
    return { sum, share: inked / (data.length / 4) };
  };
  const outcome = {};
  outcome.last = picture();
  await set("time", "0");
  outcome.first = picture();
  await set("time", "4");
  await set("quantity", "stress_xx");
  outcome.stress = picture();
  outcome.note = role("note").textContent;
  canvas.focus();
  for (const key of ["Home", "ArrowRight", "ArrowUp"]) canvas.dispatchEvent(new KeyboardEvent("keydown", { key }));
  await pause();
  outcome.words = role("words").textContent;
  outcome.rows = role("values").children.length;
  outcome.history = panel.querySelectorAll(".field-history path.numerical").length;
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape" }));
  await pause();
  outcome.cleared = role("pick").hidden;
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new PointerEvent("pointerdown", { clientX: box.x + box.width / 2, clientY: box.y + box.height / 2 }));
  await pause();
  outcome.clicked = role("words").textContent;
  if (role("view")) {
    await set("view", "all");
    outcome.all = picture();
    await set("turn", "60");
    outcome.turned = picture();
  }
  role("time").value = role("time").max;
  role("play").click();
  outcome.playing = [role("play").getAttribute("aria-pressed"), role("time").value];
  while (role("time").value !== role("time").max) await frame();
  await pause();
  outcome.played = role("play").getAttribute("aria-pressed");
  outcome.still = getComputedStyle(panel.querySelector(".field-still")).display;
  const series = document.querySelector('[data-role="series"]');
  series.value = "1";
  series.dispatchEvent(new Event("change"));
  const histories = document.querySelector('[data-role="histories"]');
  histories.scrollIntoView({ behavior: "instant" });
  while (!histories.querySelector(".main-svg")) await frame();
  outcome.histories = [...histories.querySelectorAll("figcaption")].map((caption) => caption.textContent);
  return outcome;
"""


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
@pytest.mark.parametrize("graphics", GRAPHICS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_panel_works_in_a_browser(stored: dict[int, Results], tmp_path: Path, dimension: int, graphics: str) -> None:
    report = stored[dimension].report
    outcome = acted(report / "sample.html", report, ACT, tmp_path, *GRAPHICS[graphics])
    assert outcome["graphics"] == (graphics == "webgl")
    assert outcome["faults"] == []
    assert outcome["last"]["share"] > 0.2, "the canvas is not blank"
    assert outcome["last"]["sum"] != outcome["first"]["sum"], "the slider changes the picture"
    assert outcome["stress"]["sum"] != outcome["last"]["sum"], "the quantity changes the picture"
    assert ("Crosses: 1 point whose" in outcome["note"]) == (dimension == 2), (
        "in three dimensions the point is in another layer"
    )
    assert outcome["words"].startswith("Point "), "the keyboard marks a point"
    assert outcome["rows"] == (10 if dimension == 2 else 15)
    assert outcome["history"] == 1
    assert outcome["cleared"]
    assert outcome["clicked"].startswith("Point ")
    assert "exact" in outcome["clicked"]
    assert outcome["still"] == "none"
    assert outcome["histories"] == ["Change of mass"]
    assert (outcome["playing"], outcome["played"]) == (["true", "0"], "false"), "it plays from the start and stops at the end"
    if dimension == 3:
        assert outcome["all"]["share"] > 0.1
        assert outcome["all"]["sum"] != outcome["turned"]["sum"]

"""Which pages are rendered again, and what happens to foreign and damaged files."""

import json
import re
import subprocess
import sys
from pathlib import Path

import netCDF4
import pytest
from report_pages import stamps
from sample_study import one_solver, store, study

from mpmverify.dataset.files import Results
from mpmverify.dataset.tables import read_tables
from mpmverify.errors import DamagedError, ResultsError
from mpmverify.reports import render


@pytest.fixture
def fresh(tmp_path: Path) -> Results:
    return one_solver(tmp_path)


def test_an_unchanged_report_is_not_rewritten_and_a_missing_page_is_rendered_again(fresh: Results) -> None:
    index = render(fresh)
    assert index == fresh.report / "index.html"
    before = stamps(fresh)
    render(fresh)
    assert stamps(fresh) == before
    (fresh.report / "sample.html").unlink()
    render(fresh)
    assert (fresh.report / "sample.html").exists()
    render(fresh, fresh=True)
    after = stamps(fresh)
    for name in ("index.html", "sample.html"):
        assert after[str(fresh.report / name)] > before[str(fresh.report / name)]
    assert after[str(fresh.report / "assets" / "plotly.min.js")] == before[str(fresh.report / "assets" / "plotly.min.js")]


def test_only_a_changed_study_is_rendered_and_the_page_of_a_removed_study_is_deleted(fresh: Results) -> None:
    store(fresh, study("second", ("good",)))
    render(fresh)
    before = stamps(fresh)
    store(fresh, study("second", ("good", "bad")))
    render(fresh)
    after = stamps(fresh)
    changed = {Path(name).name for name in after if after[name] != before.get(name)}
    solvers = {"problems.html", "solvers.html", "compare.html", "solver-good.html", "solver-bad.html"}
    assert changed == {"second.html", "index.html", "manifest.json"} | solvers, "a page of a solver is made of all studies"
    fresh.study("second").unlink()
    render(fresh)
    assert not (fresh.report / "second.html").exists()
    assert not (fresh.report / "solver-bad.html").exists(), "no study that is left has this solver"
    assert (fresh.report / "solver-good.html").exists()
    assert "second.html" not in (fresh.report / "index.html").read_text(encoding="utf-8")


def test_rendering_is_reproducible_byte_for_byte(fresh: Results) -> None:
    def contents() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in fresh.report.rglob("*") if path.is_file()}

    render(fresh, fresh=True)
    first = contents()
    render(fresh, fresh=True)
    assert contents() == first


def test_an_unchanged_report_imports_no_heavy_libraries(fresh: Results) -> None:
    render(fresh)
    program = (
        "import sys; from pathlib import Path; from mpmverify.dataset.files import Results; from mpmverify.reports import render; "
        "render(Results(Path(sys.argv[1]))); "
        "assert not {'xarray', 'jinja2', 'scipy', 'plotly', 'latex2mathml', 'markdown_it', 'pygments'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program, fresh.path], check=True)


@pytest.mark.parametrize("kind", ["text", "netcdf"])
def test_a_foreign_file_is_named_in_the_error_and_nothing_is_written(fresh: Results, kind: str) -> None:
    path = fresh.study("alien")
    if kind == "text":
        path.write_text("not netCDF")
    else:
        netCDF4.Dataset(path, "w").close()
    with pytest.raises(ResultsError, match="alien"):
        render(fresh)
    assert not fresh.report.exists()


@pytest.mark.parametrize(
    "text", ["{", "[]", "3", '{"verdict": "PASS"}', '{"verdict": "MAYBE"}', '{"verdict": "PASS", "who": "me"}']
)
def test_a_damaged_finding_on_missing_series_is_named_in_the_error(fresh: Results, text: str) -> None:
    with netCDF4.Dataset(fresh.study("sample"), "a") as file:
        file.setncattr("lacking", text)
    with pytest.raises(ResultsError, match=r"sample\.nc' is damaged"):
        render(fresh)
    with pytest.raises(ResultsError, match=r"sample\.nc' is damaged"):
        read_tables([fresh.study("sample")])


def test_a_foreign_page_is_not_overwritten(fresh: Results) -> None:
    page = fresh.report / "sample.html"
    page.parent.mkdir()
    page.write_text("my notes")
    with pytest.raises(ResultsError, match=r"sample\.html"):
        render(fresh)
    assert page.read_text() == "my notes"


def test_a_damaged_manifest_is_replaced(fresh: Results) -> None:
    render(fresh)
    manifest = fresh.report / "manifest.json"
    manifest.write_text('{"code": []')
    render(fresh)
    assert json.loads(manifest.read_text())["studies"].keys() == {"sample"}


CUTS = {"cut off": -100, "cut off early": 40, "empty": 0}


@pytest.mark.parametrize("name", ["sample.html", "index.html"])
@pytest.mark.parametrize("cut", CUTS.values(), ids=CUTS)
@pytest.mark.parametrize("manifest", [True, False], ids=["known", "forgotten"])
def test_a_damaged_page_is_set_aside_named_and_rendered_again(
    fresh: Results, caplog: pytest.LogCaptureFixture, name: str, cut: int, manifest: bool
) -> None:
    page = render(fresh).with_name(name)
    sound = page.read_bytes()
    page.write_bytes(sound[:cut])
    if not manifest:
        (fresh.report / "manifest.json").unlink()
    render(fresh)
    assert page.read_bytes() == sound
    assert page.with_name(f"{name}.damaged").read_bytes() == sound[:cut]
    assert caplog.messages == [f"'{page}' is damaged: it is set aside as '{name}.damaged'."]


def test_a_damaged_asset_is_written_again(fresh: Results) -> None:
    asset = render(fresh).parent / "assets" / "plotly.min.js"
    sound = asset.read_bytes()
    asset.write_bytes(sound[:1000])
    render(fresh)
    assert asset.read_bytes() == sound


def test_a_damaged_study_is_named_and_not_changed(fresh: Results) -> None:
    path = fresh.study("sample")
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(DamagedError, match=re.escape(f"'{path}' is damaged: run `mpmverify run` again")):
        render(fresh)
    assert path.stat().st_size == 5000

"""A report with failures of every kind and hostile names: no link of it is broken, and axe-core finds nothing serious in light or dark."""

import pytest
from browser import AXE, BROWSER, broken_links, examined
from sample_study import rendered


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A report with failures of every kind, a self-test, and two studies."""
    return rendered(tmp_path_factory.mktemp("failures"))[0].report


def test_every_link_leads_somewhere(report):
    pages = sorted(report.rglob("*.html"))
    assert len(pages) > 20
    assert {page.name: broken_links(page, report) for page in pages} == {page.name: [] for page in pages}


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
@pytest.mark.skipif(AXE is None, reason="needs axe-core: pip install --no-deps axe-playwright-python")
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(
    "name", ["index", "sample", "solvers", "solver-crashed", "solver-good", "compare", "problems", "trust"]
)
def test_examined_nothing_serious(report, tmp_path, name, scheme):
    found = examined(report / f"{name}.html", report, scheme, tmp_path)
    assert (found["faults"], found["serious"]) == ([], [])


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
@pytest.mark.skipif(AXE is None, reason="needs axe-core: pip install --no-deps axe-playwright-python")
@pytest.mark.parametrize("looks", ['style="color: #ddd"', ""])
def test_one_among_many_that_looks_different_is_found(report, tmp_path, looks):
    rows = ["<tr><td>as all</td></tr>"] * 40
    table = "".join([*rows, f"<tr><td><span {looks}>unlike all</span></td></tr>", *rows])
    page = report / "many.html"
    text = (report / "index.html").read_text(encoding="utf-8")
    page.write_text(text.replace("</main>", f"<table>{table}</table></main>"), encoding="utf-8")
    try:
        found = examined(page, report, "light", tmp_path, "return { rows: document.querySelectorAll('main tr').length };")
    finally:
        page.unlink()
    assert [line.partition(":")[0] for line in found["serious"]] == (["color-contrast"] if looks else [])
    assert found["rows"] > 80, "all rows are there again"

"""The report of all studies in a browser: no page fails, no link is broken, and axe-core finds nothing serious in light or dark.

It needs the results of `mpmverify run` in the folder `results` of the checkout, or the folder of a report in `MPMVERIFY_REPORT`.
"""

import os
from pathlib import Path

import pytest
from browser import AXE, BROWSER, broken_links, examined

TESTS = Path(__file__).parent.parent
REPORT = Path(os.environ.get("MPMVERIFY_REPORT", TESTS.parent / "results" / "report"))
PAGES = sorted(path.relative_to(REPORT).as_posix() for path in REPORT.rglob("*.html"))
SOLVERS = [page for page in PAGES if page.startswith("solver-")]
SEEN = [page for page in PAGES if page not in SOLVERS] + SOLVERS[::16]
"""Pages that a browser opens: those of solvers are alike."""
KINDS = (
    "index",
    "solvers",
    "compare",
    "problems",
    "trust",
    "moving-bodies",
    "dispersion",
    "error-sources",
    "handbook/verdicts",
)
SAMPLE = [page for page in SEEN if page.removesuffix(".html") in KINDS or page == SOLVERS[0]]
"""Pages that are opened in a narrow window, too, and on a dark ground."""
MOST_CHARTS = 24
"""Number of charts of a page that are drawn."""
OPEN = f"""
  for (const folded of [...document.querySelectorAll("details")].slice(0, 40)) folded.open = true;
  document.querySelector(".chart")?.scrollIntoView({{ behavior: "instant" }});  // the first one in sight loads plotly
  for (const chart of [...document.querySelectorAll(".chart")].filter((one) => one.checkVisibility()).slice(0, {MOST_CHARTS})) {{
    while (!window.Plotly) await frame();
    for (let k = 0; k < 300 && chart.isConnected && !chart.querySelector(".main-svg"); k += 1) {{
      chart.scrollIntoView({{ behavior: "instant" }});  // again: charts above it that are drawn meanwhile move it
      await frame();
    }}
    if (chart.isConnected && !chart.querySelector(".main-svg")) faults.push(`blank: ${{chart.dataset.chart}}`);
  }}
  const wide = document.documentElement.scrollWidth - innerWidth;
  return {{ wide, width: innerWidth }};
"""

pytestmark = pytest.mark.skipif(not PAGES, reason="needs the report of `mpmverify run`")


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
@pytest.mark.parametrize(
    ("page", "scheme", "window"),
    [*((page, "light", "1280,900") for page in SEEN), *((page, "dark", "500,900") for page in SAMPLE)],
)
def test_a_page_opens_without_errors_and_axe_finds_nothing_serious(page, scheme, window, tmp_path):
    found = examined(REPORT / page, REPORT, scheme, tmp_path, OPEN, window)
    assert (found["faults"], found["missing"], found["serious"]) == ([], [], [])
    assert found["wide"] <= 0, "the page can be scrolled sideways"
    if AXE is None:
        pytest.skip("opened, and not looked at by axe-core: pip install --no-deps axe-playwright-python")


@pytest.mark.parametrize("page", PAGES)
def test_every_link_leads_somewhere(page):
    assert broken_links(REPORT / page, REPORT) == []

"""Draw the pictures of the report in the README from results at hand, in Chromium: `python tests/report_pictures.py results`."""

import subprocess
import sys
import tempfile
from pathlib import Path

from browser import BROWSER

FOLDER = Path(__file__).parent / "pictures"
FIELD = """<style>
header, footer, nav, main > *:not(#case-1-rad), #case-1-rad details > *:not(.field) { display: none !important; }
main, .case, .case > details { padding: 0 !important; border: 0 !important; margin: 0 !important; }
.field { margin: 1rem auto !important; width: 1180px; }
</style>"""
PICTURES = {"overview.png": ("index.html", "1280,1010", ""), "field.png": ("generalised-vortex.html", "1240,560", FIELD)}
"""Page and window of each picture, and a style that shows a part of the page alone."""
DRAWING = 15_000
"""Time that a page has to draw itself [ms of its own clock]."""


def draw(report: Path) -> None:
    """Draw the pictures of a report with all studies."""
    if BROWSER is None:
        sys.exit("no Chromium is installed: install it, or leave the pictures as they are")
    FOLDER.mkdir(exist_ok=True)
    for name, (page, window, style) in PICTURES.items():
        part = report / f"picture-{page}"
        text = (report / page).read_text(encoding="utf-8")
        part.write_text(text.replace("</head>", f"{style}</head>"), encoding="utf-8")
        with tempfile.TemporaryDirectory() as profile:
            command = [BROWSER, "--headless=new", "--no-sandbox", "--hide-scrollbars", f"--user-data-dir={profile}"]
            command += [f"--window-size={window}", f"--virtual-time-budget={DRAWING}", f"--screenshot={FOLDER / name}"]
            subprocess.run([*command, part.resolve().as_uri()], check=True, capture_output=True)
        part.unlink()


if __name__ == "__main__":
    draw(Path(sys.argv[1]) / "report")

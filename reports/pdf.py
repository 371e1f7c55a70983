"""The pages of the report as PDF, printed by a Chromium that is installed."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError, UsageError

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
"""Names of the program that prints, in the order in which they are tried."""
DRAWING = 10_000
"""Time that a page has to draw its charts before it is printed [ms of its own clock]."""
PATIENCE = 120.0
"""Limit for one page [s]."""


def write(results: Results) -> Path:
    """Print the index page and the page of every study beside their HTML, and return the path of the first.

    Raises
    ------
    UsageError
        If no Chromium is found.
    ResultsError
        If a page cannot be printed.
    """
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise UsageError("a report in PDF needs Chromium or Chrome, and none is installed: print the HTML from another browser")
    pages = [results.report / "index.html", *(results.report / f"{path.stem}.html" for path in sorted(results.studies()))]
    for page in pages:
        _print(browser, page, page.with_suffix(".pdf"))
    return pages[0].with_suffix(".pdf")


def _print(browser: str, page: Path, target: Path) -> None:
    root = hasattr(os, "geteuid") and os.geteuid() == 0  # Chromium refuses its sandbox to this user
    with tempfile.TemporaryDirectory(prefix="mpmverify-") as folder:
        printed = Path(folder) / "page.pdf"
        command = [
            browser,
            "--headless=new",
            "--disable-gpu",
            "--no-pdf-header-footer",
            f"--user-data-dir={folder}/profile",
            f"--virtual-time-budget={DRAWING}",
            f"--print-to-pdf={printed}",
            *(["--no-sandbox"] if root else []),
            page.resolve().as_uri(),
        ]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ResultsError(f"'{page}' cannot be printed ({type(error).__name__}): print it from a browser") from error
        if not printed.exists() or not printed.read_bytes().startswith(b"%PDF"):
            said = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
            raise ResultsError(f"'{page}' cannot be printed ({said}): print it from a browser")
        shutil.move(printed, target)

"""The report: pages made from stored results alone, opened by double-click, without a network.

Notes
-----
A page is rendered when its study, the sources of the report or the page itself changed. Finding that nothing changed
reads no dataset: it costs one look at each file's size and time.
"""

from pathlib import Path

from mpmverify.dataset.files import Results

from .manifest import Manifest

__all__ = ["render"]


def render(results: Results, *, fresh: bool = False) -> Path:
    """Write the report of a results folder, what has changed alone.

    Parameters
    ----------
    results : Results
    fresh : bool
        Render every page, whether it changed or not.

    Returns
    -------
    Path
        The index page.

    Raises
    ------
    ResultsError
        If a file among the results is not ours, or a page cannot be written.
    """
    manifest = Manifest.of(results)
    known = Manifest() if fresh else Manifest.read(results)
    if fresh or not manifest.describes(known, results):
        from .site import write

        write(results, manifest, manifest.stale(known, results))
        manifest.write(results, known)
    return results.report / "index.html"

"""What a study's file holds, beyond what a judge reads of it."""

import xarray as xr

from mpmverify.dataset.findings import read_findings, read_lacking
from mpmverify.dataset.study import solvers
from mpmverify.judgement.findings import Finding


def findings(tree: xr.DataTree) -> tuple[Finding, ...]:
    """Findings that are stored in a study's tree, the one on what is lacking last."""
    listed = [finding for solver, dataset in solvers(tree) for finding in read_findings(tree.attrs["id"], solver, dataset)]
    lacking = read_lacking(tree.attrs)
    return (*listed, *([lacking] if lacking else []))

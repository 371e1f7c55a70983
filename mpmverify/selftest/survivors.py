"""Survivors that are understood: why no trial kills them, and what would."""

from collections.abc import Mapping

EXPLAINED: Mapping[str, str] = {
    "mpm/index/c0965669": "The strain energy of the small-strain law takes the volume of the neighbouring particle. At the strains of "
    "1e-6 at which that law has closed forms the volumes differ by less than the drift of any feasible step; at finite strain an "
    "updated Lagrangian code of that law has no stored energy that a criterion could hold it to.",
}
"""Explanation by the identity of the fault."""

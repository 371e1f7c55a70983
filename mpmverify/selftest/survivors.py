"""Survivors that are understood: why no trial kills them, and what would."""

from collections.abc import Mapping

EXPLAINED: Mapping[str, str] = {
    "mpm/operator/3e8eb2d9": "its histories lack the last step but one, and every entry that they have is right: which steps a solver "
    "records is its own choice",
}
"""Explanation by the identity of the fault."""

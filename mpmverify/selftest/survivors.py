"""Explanations of known survivors: why no trial detects the fault, and what would."""

from collections.abc import Mapping

EXPLAINED: Mapping[str, str] = {
    "mpm/operator/3e8eb2d9": "its histories omit the second-to-last step, and every recorded entry is right: a solver may choose which "
    "steps it records",
}
"""Explanation by fault id."""

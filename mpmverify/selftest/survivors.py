"""Survivors that are understood: why no trial kills them, and what would."""

from collections.abc import Mapping

EXPLAINED: Mapping[str, str] = {}
"""Explanation by the identity of the fault."""

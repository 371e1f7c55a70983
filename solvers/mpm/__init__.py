"""Explicit material point method."""

from .solver import MaterialPoint

__all__ = ["MaterialPoint"]

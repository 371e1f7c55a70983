"""Explicit material point method."""

from .solver import MaterialPoint
from .transfers import APIC, FLIP, PIC, TPIC, Transfer, blend, fmpm, xpic

__all__ = ["APIC", "FLIP", "PIC", "TPIC", "MaterialPoint", "Transfer", "blend", "fmpm", "xpic"]

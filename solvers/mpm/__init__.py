"""Explicit material point method."""

from .layout import GAUSS, REGULAR, Layout, offset
from .solver import MaterialPoint
from .transfers import APIC, FLIP, PIC, TPIC, Transfer, blend, fmpm, xpic

__all__ = [
    "APIC",
    "FLIP",
    "GAUSS",
    "PIC",
    "REGULAR",
    "TPIC",
    "Layout",
    "MaterialPoint",
    "Transfer",
    "blend",
    "fmpm",
    "offset",
    "xpic",
]

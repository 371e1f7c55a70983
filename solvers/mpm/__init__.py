"""Explicit material point method."""

from mpmverify.problem import GAUSS, REGULAR, Layout, offset

from .solver import MaterialPoint
from .transfers import AFLIP, APIC, FLIP, PIC, TPIC, Transfer, blend, fmpm, xpic

__all__ = [
    "AFLIP",
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

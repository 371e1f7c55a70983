"""Format numbers, units and names for display, in Unicode without markup."""

import math
import re

DASH = "–"
MINUS = "−"
SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
NORM_NAMES = {"L1": "L₁", "L2": "L₂", "Linf": "L∞", "L2-max": "L₂, largest over time"}


def number(value: float, digits: int = 3) -> str:
    """Format a number to `digits` significant digits: 0.0123, 1.23×10⁻⁵, −4; an en dash stands for a non-finite number."""
    if not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    power = int(exponent)
    if -3 <= power < max(digits, 4):
        return f"{float(f'{value:.{digits - 1}e}'):.{max(digits - 1 - power, 0)}f}".replace("-", MINUS)
    return f"{mantissa.replace('-', MINUS)}×10{str(power).translate(SUPERSCRIPT)}"


def size(value: float) -> str:
    """Format a time step or Courant number to four digits without trailing zeros."""
    if not math.isfinite(value):
        return DASH
    text = f"{value:.4g}"
    return number(value, 4) if "e" in text else text.replace("-", MINUS)


def typeset_numbers(text: str) -> str:
    """Replace the notation of the numbers in a text: "1e-06" becomes "1×10⁻⁶"."""
    powers = re.sub(r"(?<=\d)e([+-]\d+)\b", lambda found: f"×10{str(int(found[1])).translate(SUPERSCRIPT)}", text)
    return re.sub(r"(?<![\w.])-(?=\d)", MINUS, powers)


def cell_size(value: float) -> str:
    """Format a cell size as "1/64" if it is the inverse of an integer, else to four digits."""
    parts = 1 / value
    return f"1/{round(parts)}" if parts > 1.5 and abs(parts - round(parts)) < 1e-9 * parts else size(value)


def order(value: float) -> str:
    """Format an order of convergence to two decimals."""
    return f"{round(value, 2) + 0.0:.2f}".replace("-", MINUS) if math.isfinite(value) else DASH


def interval(low: float, high: float) -> str:
    """Format an interval as "[1.98, 2.01]"; an en dash stands for one that is not finite."""
    return f"[{order(low)}, {order(high)}]" if math.isfinite(low) and math.isfinite(high) else DASH


def count(value: int) -> str:
    """Format an integer with thin spaces as thousands separators."""
    return f"{value:,}".replace(",", "\u2009").replace("-", MINUS)


def unit(text: str) -> str:
    """Format a unit in UDUNITS notation: "m s-1" becomes "m s⁻¹", and "1" becomes ""."""
    return "" if text == "1" else re.sub(r"-?\d+", lambda found: found[0].translate(SUPERSCRIPT), text)


def in_unit(name: str, units: str) -> str:
    """Format a name with its unit: "velocity [m s⁻¹]"."""
    return f"{name} [{unit(units)}]" if unit(units) else name


def ladder(label: str) -> str:
    """Format the label of a ladder: "nu_C=0.5, 2 ppc" becomes "Courant 0.5, 2 ppc"."""
    return label.replace(", nu_C ~ ", " ∝ ").replace("nu_C=", "Courant ").replace("h/h0", "h/h₀")


def slug(name: str) -> str:
    """Convert a name to an HTML anchor."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "x"


def slugs(names: list[str]) -> dict[str, str]:
    """Return a unique HTML anchor for each name."""
    table: dict[str, str] = {}
    for name in names:
        anchor, k = slug(name), 2
        while anchor in table.values():
            anchor, k = f"{slug(name)}-{k}", k + 1
        table[name] = anchor
    return table

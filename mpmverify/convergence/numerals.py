"""Numbers as people write them: Fortran and LaTeX exponents, powers, fractions, roots, decimal commas, grids such as 16 x 16."""

import math
import re
from collections.abc import Iterable
from enum import Enum

from mpmverify.errors import UsageError

MISSING = frozenset({"", "-", "--", "---", "*", "/", ".", "..", "...", "n/a", "na", "n.a.", "none", "null", "<na>", "\\"})
"""Cells without a value, in lower case. "nan" is not one of them: a solver may have returned it."""
SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
SAME = str.maketrans({"−": "-", "–": "-", "—": "-", "×": "*", "·": "*", "⋅": "*", "∙": "*", "…": "...", "∞": "inf"})
"""Typographic signs and what they mean."""
_WRAPPED = re.compile(
    r"\\(?:num|text\w*|math\w+|emph|ensuremath|mbox|bm|boldsymbol|underline|cellcolor\{[^{}]*\}|SI|qty|unit)\s*"
    r"(?:\[[^\]]*\])?\{([^{}]*)\}(?:\{[^{}]*\})?"
)
_FRACTION = re.compile(r"\\(?:[dt]?frac|nicefrac|sfrac)\s*(?:\{([^{}]*)\}\s*\{([^{}]*)\}|(\d)\s*(\d))")
_SPACE = re.compile(r"\\[,;:! ]|~|\\q?quad(?![a-z])|\\(?:hphantom|phantom|hspace\*?|vspace\*?)\{[^{}]*\}|[\s\u200b\ufeff]+")
_DECIMAL = r"(?:\d+\.?\d*|\.\d+)"
_TERM = rf"(?:(?:√|sqrt)\(?{_DECIMAL}\)?|{_DECIMAL}(?:[eE][+-]?\d+)?(?:\^[+-]?\d+)?)"
_EXPRESSION = re.compile(rf"([+-]?)({_TERM}(?:[*/]{_TERM})*)(%?)")
_FORTRAN = re.compile(rf"([+-]?{_DECIMAL})(?:[dDqQ]([+-]?\d+)|(?<=[\d.])([+-]\d{{3}})|\(([+-]\d+)\))")
_FIGURES = re.compile(r"[-+*/^%√x\d.,eEdDqQ() ]+")
_THOUSANDS = {sign: re.compile(rf"(?<![\d.,])[1-9]\d{{0,2}}(?:\{sign}\d{{3}})+(?!\{sign}?\d)") for sign in ",."}


class Decimal(Enum):
    """What commas and points between digits mean in a table."""

    POINT = "point"
    COMMA = "comma"


def plain(cell: str) -> str:
    """Return a cell without the markup of LaTeX, Markdown and HTML, and with ASCII signs."""
    text = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+", lambda found: "^" + found[0].translate(SUPERSCRIPT), cell).translate(SAME)
    text = re.sub(r"<sup>(.*?)</sup>", r"^\1", re.sub(r"(?<=\w )\\(?= \w)", "/", text))
    text = re.sub(r"</?\w+[^<>]*>|(?<![\w)])\*\*|\*\*(?![\d(+-])|`|\\[()]|(?<!\\)\$", "", text)
    text = (
        text.replace(r"\|", "||").replace("{,}", ",").replace(r"\cdot", "*").replace(r"\times", "*").replace(r"\infty", "inf")
    )
    before = None
    while before != text:
        before, text = text, _FRACTION.sub(lambda found: f"{found[1] or found[3]}/{found[2] or found[4]}", text)
        text = re.sub(r"\\sqrt\s*\{?([\d.]+)\}?", r"√\1", _WRAPPED.sub(r"\1", text))
    text = _SPACE.sub(" ", text)
    return re.sub(r"(?<!\w)\\(?=\w)|\\(?=[%#_&|])|[{}]", "", text.replace("\\backslash", "/")).strip()


def is_missing(cell: str) -> bool:
    """Whether a plain cell holds no value."""
    return cell.lower() in MISSING


def grid(cell: str) -> tuple[int, ...]:
    """Cells in each direction of a grid such as "16 x 16"; () where a plain cell is no grid."""
    found = re.fullmatch(r"[1-9]\d*(?:\s*[x*]\s*[1-9]\d*)+", cell)
    return tuple(int(count) for count in re.findall(r"\d+", cell)) if found else ()


def number(cell: str, decimal: Decimal = Decimal.POINT) -> float | None:
    """Value of a plain cell; None if it is no number.

    Parameters
    ----------
    cell : str
        As `plain` returns it: "1.2e-3", "1.2D-03", "1.2-103", "1.2*10^-3", "1/16", "2^-4", "√2/8", "1.5 %", "16 x 16", "nan" or "inf".
        A grid is the number of its cells.
    decimal : Decimal
        The decimal sign; the other one may separate thousands.
    """
    if cells := grid(cell):
        return float(math.prod(cells))
    text = re.sub(r"\s*(\*\*|[*/^x])\s*", r"\1", cell).replace("**", "^").replace(" %", "%")
    if re.fullmatch(r"[+-]?(nan|inf|infinity)", text, re.IGNORECASE):
        return float(text)
    text = re.sub(r"\^\(([+-]?\d+)\)", r"^\1", re.sub(r"(?<=[\d.])x(?=10\^)", "*", text))
    other = "." if decimal is Decimal.COMMA else ","
    text = _THOUSANDS[other].sub(lambda found: found[0].replace(other, ""), text)
    if decimal is Decimal.COMMA and "." not in text:
        text = text.replace(",", ".")
    if found := _FORTRAN.fullmatch(text):
        mantissa, *exponents = found.groups()
        if found[3] is None or "." in mantissa:
            return float(f"{mantissa}e{next(filter(None, exponents))}")
    text = re.sub(rf"(?:(?<![\d.^])({_DECIMAL})\*)?(?<![\d.^])10\^([+-]?\d+)", lambda m: f"{m[1] or 1}e{m[2]}", text)
    if not (found := _EXPRESSION.fullmatch(text)):
        return None
    try:
        value = _value(found[2]) / (100 if found[3] else 1)
    except (ZeroDivisionError, OverflowError):
        return None
    return -value if found[1] == "-" else value


def _value(expression: str) -> float:
    """Product and quotient of terms, from left to right."""
    first, *rest = re.split(r"([*/])", expression)
    value = _term(first)
    for operator, term in zip(rest[::2], rest[1::2], strict=True):
        value = value * _term(term) if operator == "*" else value / _term(term)
    return value


def _term(text: str) -> float:
    if text[0] in "√s":
        return math.sqrt(float(text.removeprefix("sqrt").strip("√()")))
    base, _, exponent = text.partition("^")
    return float(base) ** int(exponent) if exponent else float(base)


def decimal_sign(cells: Iterable[str], place: str) -> Decimal:
    """Decimal sign of a table, from all of its plain cells.

    Parameters
    ----------
    cells : iterable of str
    place : str
        Name of the file in the error message.

    Raises
    ------
    UsageError
        If some cells need a decimal comma and others a decimal point, or a comma may mean either decimals or thousands.

    Notes
    -----
    A comma or point between digits is a decimal sign unless it may separate thousands: "0,125" and "1,5e-3" have decimal commas, "1,024" may
    be 1024.
    """
    signs: dict[str, str] = {}
    doubtful = ""
    for cell in filter(_FIGURES.fullmatch, cells):
        for found in re.findall(r"\d[\d.,]*\d|\d[.,]|[.,]\d+", cell):
            marks = {sign for sign in ",." if sign in found}
            if len(marks) == 2:
                signs.setdefault(max(marks, key=found.rfind), cell)
            elif marks == {","} and _THOUSANDS[","].fullmatch(found):
                doubtful = doubtful or cell
            elif marks:
                signs.setdefault(marks.pop(), cell)
    if len(signs) == 2:
        raise UsageError(
            f"{place} mixes decimal commas ({signs[',']!r}) and points ({signs['.']!r}): write all numbers with points"
        )
    if doubtful and not signs:
        whole = doubtful.replace(",", "")
        raise UsageError(f"{place}: {doubtful!r} may be {doubtful.replace(',', '.')} or {whole}: write it as one of these")
    return Decimal.COMMA if "," in signs else Decimal.POINT

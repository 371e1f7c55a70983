"""Equations as MathML."""

import re
from functools import cache
from html import escape
from xml.etree import ElementTree

from latex2mathml.converter import convert

ELEMENTS = re.compile(
    r"m(ath|row|i|n|o|text|s|space|frac|sqrt|root|style|padded|phantom|fenced|enclose|sub|sup|subsup|under|over|underover"
    r"|multiscripts|prescripts|table|tr|td)|none"
)


@cache
def mathml(latex: str) -> str:
    """Convert LaTeX to MathML; return it as code if it cannot be converted or the result holds anything but formulas.

    Notes
    -----
    The converter copies the content of a text command unchanged, including any markup in it.
    """
    try:
        text = convert(latex, display="block")
        elements = ElementTree.fromstring(text).iter()
    except Exception:  # the converter may raise any exception on invalid input
        return f"<code>{escape(latex)}</code>"
    for element in elements:
        known = ELEMENTS.fullmatch(element.tag.rpartition("}")[2])
        if not known or any(name.startswith("on") or "href" in name for name in element.attrib):
            return f"<code>{escape(latex)}</code>"
    return text

"""Source code as HTML with its comments, strings, numbers and keywords marked."""

from html import escape
from itertools import groupby
from typing import Any

from pygments.lexers import get_lexer_by_name
from pygments.token import Comment, Keyword, Literal, Name, Operator, String

LEXERS = {"sh": "bash", "python": "python", "yaml": "yaml"}
KINDS = {
    Comment: "comment",
    String: "string",
    Literal.Number: "number",
    Keyword: "keyword",
    Operator.Word: "keyword",
    Name.Decorator: "keyword",
    Name.Tag: "keyword",
}
"""Classes of the style sheet by the token types that have one."""


def highlighted(code: str, language: str) -> str:
    """Return source code as HTML, escaped; a language without a lexer is left unmarked.

    Parameters
    ----------
    code : str
    language : str
        As a Markdown fence names it.
    """
    if language not in LEXERS:
        return escape(code)
    lexer = get_lexer_by_name(LEXERS[language], stripnl=False, ensurenl=False)
    parts = ((_kind(token), text) for token, text in lexer.get_tokens(code))
    html = []
    for kind, members in groupby(parts, key=lambda part: part[0]):
        text = escape("".join(text for _, text in members))
        html.append(f'<span class="{kind}">{text}</span>' if kind else text)
    return "".join(html)


def _kind(token: Any) -> str:
    return next((name for parent, name in KINDS.items() if token in parent), "")

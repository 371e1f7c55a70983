"""The mark of traced functions."""

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


def traced(function: F) -> F:
    """Mark a function that emits code when it is called with `Value`s, see `compilation`; it is returned as it is.

    What depends only on lengths of tuples and on numbers of Python is settled when it is called and emits no code; a loop over a
    tuple is unrolled. It must not branch on a value.
    """
    return function

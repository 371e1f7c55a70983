"""What processes of their own do and what is said of those that fail: in a module that they import in no time."""

import os
import time


def double(number: int) -> int:
    """Twice a number; 3 ends the process, 4 keeps it busy, 5 lets it sleep."""
    if number == 3:
        os._exit(7)
    while number == 4:
        pass
    if number == 5:
        time.sleep(600)
    return 2 * number


def why(reason: str, *, undecided: bool) -> tuple[str, bool]:
    return reason, undecided

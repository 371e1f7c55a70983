"""Errors that a user can correct; each message is one sentence that names the object and the remedy."""


class MpmverifyError(Exception):
    """Base class of the errors that the command line shows as one sentence, without a traceback."""


class UsageError(MpmverifyError, ValueError):
    """An invalid name, option or declaration: an unknown study, a Courant number of zero."""


class ResultsError(MpmverifyError, OSError):
    """A results folder or file that cannot be read or written, or that mpmverify did not write."""


class DamagedError(ResultsError):
    """A file that mpmverify wrote and that cannot be read any more: it is set aside when it is made anew."""

"""Errors that a user can mend: one sentence each, naming the thing and the remedy."""


class MpmverifyError(Exception):
    """Base of every error that the command line shows as one sentence."""


class UsageError(MpmverifyError, ValueError):
    """A name, an option or a declaration that cannot mean anything: an unknown study, a Courant number of zero."""


class ResultsError(MpmverifyError, OSError):
    """A results folder or file that cannot be read, is not ours, or cannot be written."""

"""What can go wrong."""


class Error(Exception):
    """What klieg could not do, and why."""


class InputError(Error, ValueError):
    """What the caller gave is at fault: a file, which the text names, or a value out of its range."""

"""The one kind of error that a user sees."""


class TautError(Exception):
    """What is wrong, in one line that says what to do."""

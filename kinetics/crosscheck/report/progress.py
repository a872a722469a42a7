"""How long work says what it is at."""

from collections.abc import Callable

#: Called with the name of each stage as it begins.
Progress = Callable[[str], None]


def say_nothing(stage: str) -> None:
    """Take the name of a stage, and do nothing."""

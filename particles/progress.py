"""A bar that shows how far a run is, in a terminal or a notebook.

It is one line of text on standard error, which returns to its beginning: both show that. Where
standard error is a file there is no bar.
"""

import sys
import time
from collections.abc import Callable

#: Called with how many configurations are done, and how many there are.
Progress = Callable[[int, int], None]

#: Characters of a full bar. Chosen: with the words behind it, it fits in half of a terminal.
WIDTH = 30
#: Least time between two drawings in s. Chosen: the eye sees no more, and a short run has no cost.
LEAST_INTERVAL = 0.1
#: Seconds from which on the remaining time is in minutes.
LONG = 120.0
#: Name of the interactive shell of a notebook, as IPython calls its class.
SHELL_OF_NOTEBOOKS = "ZMQInteractiveShell"


def show_progress() -> Progress:
    """Return a function that draws a bar, or that does nothing where nobody would see it."""
    if sys.stderr is not None and (sys.stderr.isatty() or is_notebook()):
        return Bar()
    return _show_nothing


def is_notebook() -> bool:
    """Tell whether this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    if ipython is None:
        return False
    return type(ipython.get_ipython()).__name__ == SHELL_OF_NOTEBOOKS


def _show_nothing(done: int, total: int) -> None:
    """Take how far a run is, and show nothing."""


class Bar:
    """Draws a bar on standard error, with the time that remains if all goes on as fast."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._done_before: int | None = None
        self._drawn = -LEAST_INTERVAL
        self._length = 0

    def __call__(self, done: int, total: int) -> None:
        """Draw how many configurations are done; at the end, end the line."""
        now = time.monotonic() - self._began
        if self._done_before is None:
            self._done_before = done
        has_ended = done >= total
        if now - self._drawn < LEAST_INTERVAL and not has_ended:
            return
        self._drawn = now
        line = self._line(done, total, now)
        padding = " " * max(0, self._length - len(line))
        self._length = len(line)
        sys.stderr.write(f"\r{line}{padding}" + ("\n" if has_ended else ""))
        sys.stderr.flush()

    def _line(self, done: int, total: int, elapsed: float) -> str:
        """Return the bar as text."""
        full = WIDTH * done // max(total, 1)
        bar = "#" * full + "-" * (WIDTH - full)
        line = f"[{bar}] {done}/{total} configurations"
        own = done - (self._done_before or 0)
        if done >= total:
            return f"{line}, {_duration(elapsed)}"
        if own > 0:
            return f"{line}, {_duration(elapsed / own * (total - done))} left"
        return line


def _duration(seconds: float) -> str:
    """Return a duration as text."""
    return f"{seconds:.1f} s" if seconds < LONG else f"{seconds / 60.0:.0f} min"

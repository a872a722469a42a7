"""Ctrl-C and SIGTERM: the first signal raises an exception, and ends the process in time.

An exception that a signal handler raises is lost where Python cannot propagate it (in a finaliser,
or in the callback of a weak reference), and may leave a module half imported. So it is not raised
while a module is being imported, and raised again where it was lost. Whatever happens to it, the
process ends after `GRACE_PERIOD`.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from threading import Timer
from types import FrameType
from typing import Any

#: Signals that end a command, and its exit status: 128 and the number of the signal.
EXIT_STATUS = {int(signal.SIGINT): 130, int(signal.SIGTERM): 143}
#: Seconds that a command has to remove what is half written and say what is saved. Chosen: users
#: expect an end within two seconds.
GRACE_PERIOD = 1.0
#: Seconds after which it is looked whether an import is over, or whether the exception was lost.
#: Chosen: short beside the grace period.
CHECK_INTERVAL = 0.02


class _Interruption:
    """What happens after the first signal.

    Attributes
    ----------
    number : the signal; None before
    is_pending : whether its exception has to be raised, because it was not yet, or was lost
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self.is_pending = False
        self._timer: Timer | None = None

    def begin(self, number: int, frame: FrameType | None) -> None:
        """Handle the first signal; later ones must not interrupt what it has begun to clean up."""
        self.number = number
        self.is_pending = True
        for each in EXIT_STATUS:
            signal.signal(each, signal.SIG_IGN)
        sys.unraisablehook = self._notice_lost
        self._timer = Timer(GRACE_PERIOD, os._exit, [EXIT_STATUS[number]])
        self._timer.daemon = True
        self._timer.start()
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, self._raise_if_pending)
            signal.setitimer(signal.ITIMER_REAL, CHECK_INTERVAL, CHECK_INTERVAL)
        self._raise_if_pending(number, frame)

    def _raise_if_pending(self, number: int, frame: FrameType | None) -> None:
        """Raise the exception, unless a module is being imported."""
        if self.number is None or not self.is_pending or _is_importing():
            return
        self.is_pending = False
        if self.number == signal.SIGINT:
            raise KeyboardInterrupt
        raise SystemExit(EXIT_STATUS[self.number])

    def _notice_lost(self, unraisable: Any) -> None:
        """Note that Python could not propagate the exception; print any other that it could not."""
        if isinstance(unraisable.exc_value, KeyboardInterrupt | SystemExit):
            self.is_pending = True
        else:
            sys.__unraisablehook__(unraisable)

    def end(self) -> None:
        """Stop all clocks."""
        self.is_pending = False
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        if self._timer is not None:
            self._timer.cancel()
            sys.unraisablehook = sys.__unraisablehook__


def _is_importing() -> bool:
    """Return whether a module is being imported: its spec says so."""
    specs = [getattr(module, "__spec__", None) for module in list(sys.modules.values())]
    return any(getattr(spec, "_initializing", False) for spec in specs)


@contextlib.contextmanager
def ends_at_a_signal() -> Iterator[None]:
    """Let the first signal end what is done meanwhile; handlers are restored afterwards."""
    interruption = _Interruption()
    handlers: dict[int, Any] = {number: signal.getsignal(number) for number in EXIT_STATUS}
    for number, handler in handlers.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, interruption.begin)
    try:
        yield
    finally:
        interruption.end()
        for number, handler in handlers.items():
            signal.signal(number, handler)

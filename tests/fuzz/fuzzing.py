"""How the fuzz tests run, what they count as a clean refusal, and the values that they try.

Every test asks for a result with an honest status, or one line that says what was wrong.
"""

import contextlib
import re
import signal
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from kinetics import InputError, ToleranceWarning

LONGEST = 400  # characters of a refusal that lists the names that are known; else 200 or so
ODDS = 19  # against a broken value
LONGEST_RUN = 120  # seconds of processor time of one example, before it counts as endless
NAMED = re.compile(
    r"^[\w./\[\]-]+( and --[\w-]+)?(:| = | of | holds )|^.+: (must be a file|no such file)"
)
"""A refusal begins with the name of an argument, or of a file."""


def examples(few: int) -> Any:
    """So many examples by default, and forty times as many with `-m slow`."""
    return pytest.mark.parametrize("tries", [few, pytest.param(40 * few, marks=pytest.mark.slow)])


def fuzz(check: Callable[[Any], None], arguments: st.SearchStrategy[Any], tries: int) -> None:
    """Call the check with so many examples, the same ones each time."""
    tried = given(arguments)(check)
    settings(
        max_examples=tries,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],  # shrinking a slow example takes minutes
        suppress_health_check=list(HealthCheck),
    )(tried)()


def check_line(text: str) -> None:
    """One line, not too long."""
    assert "\n" not in text.rstrip("\n"), text
    assert 0 < len(text) <= LONGEST, text


def result_or_refusal(call: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
    """What the call gives; None where it refused an argument in one line that names it.

    Every other exception goes on, as do warnings, but for the one that is the honest status of
    a figure without one of its own.
    """
    with time_limit(), warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ToleranceWarning)
        try:
            return call(*arguments, **keywords)
        except ValueError as error:
            if type(error) not in (InputError, ValueError):
                raise
            refusal = str(error)
    check_line(refusal)
    assert NAMED.match(refusal), refusal
    return None


@contextlib.contextmanager
def time_limit() -> Iterator[None]:
    """TimeoutError where the block takes longer than any example should."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def stop(*_: Any) -> None:
        raise TimeoutError(f"an example did not end within {LONGEST_RUN} s of processor time")

    # on a busy machine it may take several times as long; what waits takes no processor time
    timers = {
        signal.SIGPROF: (signal.ITIMER_PROF, LONGEST_RUN),
        signal.SIGALRM: (signal.ITIMER_REAL, 10 * LONGEST_RUN),
    }
    before = {which: signal.signal(which, stop) for which in timers}
    for timer, seconds in timers.values():
        signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        for timer, _ in timers.values():
            signal.setitimer(timer, 0.0)
        for which, handler in before.items():
            signal.signal(which, handler)


BROKEN: list[Any] = [
    None,
    True,
    -1,
    -1.5,
    float("nan"),
    float("inf"),
    -float("inf"),
    10**400,
    -(10**400),
    10**5000,
    "",
    "x" * 500,
    "two\nlines",
    "\0",
    b"bytes",
    1j,
    object(),
    [],
    {},
    (1.0,),
    [[1.0, 2.0], [3.0]],
    [10**400],
    [10**5000],
    ["x"],
    [None],
    [1j],
    [float("nan")],
    range(3),
    np.float32(0.5),
    np.int64(3),
    np.array(0.5),
    np.array([]),
    np.array([1.0, 2.0], dtype=object),
    np.array([1.0 + 0.0j]),
    np.array(["a"]),
    np.array([True]),
    np.datetime64("2020-01-01"),
    np.ma.masked_array([1.0, 2.0], mask=[False, True]),
    np.ma.masked,
    np.longdouble("1e4000"),
    np.full((3, 1), 1e308),
    lambda v, *rest: v,
]
"""Values of any kind, most of which no argument allows."""

EXTREMES = [0.0, -0.0, 5e-324, 1e-308, 1e-250, 1e-150, 1e-16, 1e-3, 1.0, 3.0, 1e12, 1e150, 1e308]


def broken() -> st.SearchStrategy[Any]:
    """Values of any kind."""
    return st.sampled_from(BROKEN)


def mostly(usual: st.SearchStrategy[Any], rare: st.SearchStrategy[Any] | None = None) -> Any:
    """The usual values, and once in twenty times a broken one."""
    other = broken() if rare is None else rare
    return st.integers(0, ODDS).flatmap(lambda k: other if k == 7 else usual)


def geometric(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers from low to high, as many in each decade."""
    return st.floats(np.log10(low), np.log10(high)).map(lambda x: float(10.0**x))


def extremes() -> st.SearchStrategy[float]:
    """Numbers at the ends of double precision."""
    return st.sampled_from(EXTREMES) | st.floats()


def restitutions() -> st.SearchStrategy[float]:
    """From 0 to 1, the ends and their neighbours among them."""
    near = [0.0, 1.0, 5e-324, 1e-250, 1e-20, 1e-8, 1 - 2.0**-53, 1 - 1e-10, 0.999, 0.7]
    return st.floats(0.0, 1.0) | st.sampled_from(near)

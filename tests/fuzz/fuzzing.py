"""How the fuzz tests run, what they count as a clean refusal, and the values that they try.

Every test asks for a result with an honest status, which keeps the invariants of the stability
sweep, or one line that says what was wrong.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from kinetics import ModelWarning, ToleranceWarning
from kinetics.crosscheck.stress_invariants import Violations

LONGEST = 400  # characters of a refusal that lists the names that are known; else 200 or so


def fuzz(few: int, **arguments: st.SearchStrategy[Any]) -> Any:
    """A test with so many examples, the same each time; eighty times as many with `-m slow`."""

    def decorate(check: Callable[..., None]) -> Callable[..., None]:
        def run(tries: int) -> None:
            settings(
                max_examples=tries, derandomize=True, deadline=None, database=None,
                phases=[Phase.generate],  # shrinking a slow example takes minutes
                suppress_health_check=list(HealthCheck),
            )(given(**arguments)(check))()  # fmt: skip

        slow = pytest.param(80 * few, marks=pytest.mark.slow)
        return pytest.mark.parametrize("tries", [few, slow])(run)

    return decorate


def check_line(text: str) -> None:
    """One line, not too long."""
    assert "\n" not in text.rstrip("\n"), text
    assert 0 < len(text) <= LONGEST, text


def tried(call: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
    """What the call gives; None where it refused an argument in one line that names it.

    Every other exception goes on, as do warnings, but for the one that is the honest status of
    a figure without one of its own.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ToleranceWarning)
        warnings.simplefilter("ignore", ModelWarning)
        try:
            return call(*arguments, **keywords)
        except ValueError as error:
            check_line(str(error))
    return None


def keeps(violations: Violations) -> None:
    """No invariant of the stability sweep is violated."""
    broken = {name: x for name, x in violations.items() if not x.is_allowed}
    assert not broken


BROKEN: list[Any] = [
    None, True, -1, -1.5, float("nan"), float("inf"), -float("inf"), 10**400, "", "x" * 500,
    "two\nlines", "\0", b"bytes", 1j, object(), [], {}, (1.0,), [[1.0, 2.0], [3.0]], [10**400],
    ["x"], [None], [1j], [float("nan")], range(3), np.float32(0.5), np.int64(3), np.array(0.5),
    np.array([]), np.array([1.0, 2.0], dtype=object), np.array([1.0 + 0.0j]), np.array(["a"]),
    np.array([True]), np.datetime64("2020-01-01"), np.ma.masked, np.longdouble("1e4000"),
    np.ma.masked_array([1.0, 2.0], mask=[False, True]), np.full((3, 1), 1e308), lambda v, *rest: v,
]  # fmt: skip
"""Values of any kind, most of which no argument allows."""
_EXTREMES = [0.0, -0.0, 5e-324, 1e-308, 1e-250, 1e-150, 1e-16, 1e-3, 1.0, 3.0, 1e12, 1e150, 1e308]
broken = st.sampled_from(BROKEN)
extremes = st.sampled_from(_EXTREMES) | st.floats() | broken
_ENDS = [0.0, 1.0, 5e-324, 1e-250, 1e-20, 1e-8, 1 - 2.0**-53, 1 - 1e-10, 0.999, 0.7]


def mostly(usual: Any, rare: st.SearchStrategy[Any] = broken) -> st.SearchStrategy[Any]:
    """The usual values (a strategy, or some to choose from), and once in forty times a rare one."""
    chosen = usual if isinstance(usual, st.SearchStrategy) else st.sampled_from(usual)
    return st.integers(0, 39).flatmap(lambda k: rare if k == 17 else chosen)


def geometric(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers from low to high, as many in each decade."""
    return st.floats(np.log10(low), np.log10(high)).map(lambda x: float(10.0**x))


restitutions = mostly(st.floats(0.0, 1.0) | st.sampled_from(_ENDS))
laws = {
    "restitution": restitutions,
    "dimension": mostly([2, 2, 3]),
    "tangential_restitution": mostly(st.just(1.0) | restitutions),
    "mass_ratio": mostly(st.just(np.inf) | geometric(1e-3, 1e3), extremes),
}
points = mostly(st.lists(geometric(1e-3, 1e2), min_size=1, max_size=3).map(sorted), extremes)

"""Checks of arguments: what they let through, and the one line that they refuse the rest with."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from kinetics import InputError
from kinetics import validation as check

Check = Callable[[Any], Any]

GOOD: list[tuple[Check, Any, Any]] = [
    (check.check_restitution, 1, 1.0),
    (check.check_restitution, np.float64(0.0), 0.0),
    (check.check_rtol, 1e-14, 1e-14),
    (lambda x: check.check_positive("l", x), 5e-324, 5e-324),
    (lambda x: check.real_number("t", x), -1e308, -1e308),
    (lambda x: check.exponent("p", x, 40.0), -40, -40.0),
    (lambda x: check.whole_number("n", x, 8, 9), np.int64(8), 8),
    (lambda x: check.one_of("method", x, ("a", "b")), "b", "b"),
    (check.restitutions, [0, 1], [0.0, 1.0]),
    (lambda x: check.not_negative("t", x), 0, 0.0),
    (lambda x: check.finite_line("v", x), 3, [3.0]),
    (lambda x: check.not_negative_line("r", x), (0, 1), [0.0, 1.0]),
    (check.speeds, [0.0, 2.0], [0.0, 2.0]),
]


@pytest.mark.parametrize(("checked", "given", "expected"), GOOD)
def test_let_through(checked: Check, given: Any, expected: Any) -> None:
    found = checked(given)
    assert np.array_equal(found, expected)
    assert type(found) in (float, int, str, np.ndarray)
    if isinstance(found, np.ndarray):
        assert found.dtype == float
        assert found is not given


BAD: list[tuple[Check, list[Any], str]] = [
    (check.check_restitution, [-0.1, 1.1, math.nan, "e", None, 1j], "restitution: .*0 .* to 1"),
    (check.check_rtol, [0.0, 0.2, math.nan, "x"], r"rtol: .*from 1e-14 to 0\.1"),
    (lambda x: check.check_positive("l", x), [0.0, -1, math.inf, None], "l: .*above 0"),
    (lambda x: check.real_number("t", x, 0.0, 2.0), [-1, 3, math.inf], "t: .*from 0 to 2"),
    (lambda x: check.exponent("p", x, 40.0), [41, -41, math.nan], "p: .*size up to 40"),
    (lambda x: check.whole_number("n", x, 8, 9), [7, 10, 8.0, True, "8"], "n: .*from 8 to 9"),
    (lambda x: check.whole_number("m", x, 0, 2), [True, 1.0, None, 3], "m: .*from 0 to 2"),
    (lambda x: check.one_of("m", x, ("a", "b")), ["c", 1, None, ["a"]], "m: .*one of a, b"),
    (check.restitutions, [[0, 1.1], math.nan, "x", True], "restitution: .*from 0 to 1"),
    (lambda x: check.not_negative("t", x), [-1, math.inf, [math.nan]], "t: .*not negative"),
    (lambda x: check.finite_line("v", x), [[[1.0]], [math.nan], "x", 1j], "v: .*1-dimensional"),
    (lambda x: check.not_negative_line("r", x), [[], [-1.0]], "r: .*at least one"),
    (check.speeds, [[-1.0]], "v: .*must not be negative"),
    (lambda x: check.speeds(x, zero_allowed=False), [[0.0]], "v: .*above 0 here"),
]


@pytest.mark.parametrize(("checked", "values", "say"), BAD)
def test_refused(checked: Check, values: list[Any], say: str) -> None:
    for value in values:
        with pytest.raises(InputError, match=f"^{say}") as caught:
            checked(value)
        assert "; " in str(caught.value)
        assert "\n" not in str(caught.value)


def test_long_values_are_cut() -> None:
    with pytest.raises(InputError) as caught:
        check.not_negative("x", -np.ones((100, 100)))
    assert len(str(caught.value)) < 150


@pytest.mark.parametrize(
    "value",
    [10**400, 10**5000, [10**5000], np.ma.masked, np.array([0.5]), np.complex128(1), [1, [2, 3]]],
    ids=lambda value: type(value).__name__,
)
def test_values_that_numpy_or_python_would_complain_of(value: Any) -> None:
    """Each once ended in a raw message, or lost a part of the value with a warning of NumPy."""
    with pytest.raises(InputError, match=r"^x: got .*; it must be") as caught:
        check.real_number("x", value)
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize(
    "value", [[10**400], np.ma.masked_array([1.0, 2.0], [0, 1]), [1.0, np.ma.masked], [1j]]
)
def test_arrays_of_which_numpy_would_lose_a_part(value: Any) -> None:
    for refused in (check.finite_array, check.not_negative):
        with pytest.raises(InputError, match=r"^x: got .*; it must be"):
            refused("x", value)

"""Arguments that NumPy or Python would complain of end in one line of ours."""

from typing import Any

import numpy as np
import pytest

from kinetics import InputError
from kinetics import validation as check


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

"""The printed predictions: the printed text itself in mpmath, their limits, extremes, bad input."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from kinetics import sonine

# -- G(R) -----------------------------------------------------------------------------------------


def test_far_out_the_forms_meet_as_corrected_and_are_half_as_printed() -> None:
    for eta in (0.25, 0.5):
        exact = sonine.position_integral(60.0, eta)
        assert sonine.position_tail(60.0, eta, 2.0) / exact == pytest.approx(1, abs=0.01)
        assert sonine.position_tail(60.0, eta, 1.0) / exact == pytest.approx(0.5, abs=0.005)
        assert sonine.position_far_tail(60.0, eta) / exact == pytest.approx(0.5, abs=0.005)


def test_the_fitted_constants_of_the_paper_are_the_defaults() -> None:
    r = np.array([0.5, 2.0, 5.0])
    np.testing.assert_array_equal(sonine.position_tail(r), sonine.position_tail(r, 0.25, 7.39))
    np.testing.assert_allclose(
        sonine.position_peak(r), sonine.position_given_speed(r, 0.75, math.sqrt(0.5)), rtol=1e-13
    )
    # meant for the tail alone: it integrates to 3.3
    total = quad(lambda x: float(sonine.position_tail(x)), 0, 30)[0]
    assert total == pytest.approx(3.3, abs=0.05)


@pytest.mark.parametrize(
    "form",
    [
        sonine.position_integral, sonine.position_tail, sonine.position_far_tail,
        sonine.position_peak,
    ],
)  # fmt: skip
def test_curves_at_the_extremes_of_the_radius(form: Any) -> None:
    extremes = np.array([0.0, 5e-324, 1e-200, 1e3, 1e10, 1e200, 1.7e308])
    with np.errstate(all="raise", under="ignore"):
        for eta in (1e-3, 0.5, 1e3):
            values = form(extremes, eta)
            assert np.all(np.isfinite(values))
            assert np.all(values >= 0)
            assert values[0] == 0
            assert np.all(values[4:] == 0)
    assert form(np.ones((2, 1)), np.array([0.3, 0.5, 0.7])).shape == (2, 3)
    assert np.shape(form(1.0, 0.5)) == ()

"""The printed formulas: their identities and limits.

Their other transcription, in sympy, is held against them in tests/derivations/test_derived.py.
"""

from typing import Any

import numpy as np
import pytest

from kinetics import sonine

ABOVE_THRESHOLD = np.array([0.59, 0.6, 0.7, 0.8, 0.9, 0.99])


def test_the_unstable_root_solves_the_equation_for_a2_too() -> None:
    # eq. sonine7 with eqs. sonine9 and sonine10
    e, a2 = ABOVE_THRESHOLD, sonine.a2(ABOVE_THRESHOLD, "unstable")
    left, right = 4 * sonine.m2(e, a2) * (a2 + 1), sonine.m4(e, a2)
    np.testing.assert_allclose(left, right, rtol=1e-13)


def test_the_stable_root_is_the_stable_one() -> None:
    assert np.all(sonine.stability(ABOVE_THRESHOLD) < 0)
    assert np.all(sonine.stability(ABOVE_THRESHOLD, "unstable") > 0)


def test_below_the_threshold_there_is_no_value() -> None:
    edge = sonine.THRESHOLD_RESTITUTION
    assert edge == pytest.approx(0.5815670576)
    assert np.isfinite(sonine.a2(edge + 1e-9))
    with pytest.warns(UserWarning, match="no real root"):
        assert np.isnan(sonine.a2(edge - 1e-9))
    with pytest.warns(UserWarning, match="no real root"):
        assert np.isnan(sonine.cooling_rate(0.4))
    with pytest.warns(UserWarning, match="no real root"):
        assert np.isnan(sonine.msd_sonine(100.0, 0.4))


def test_a_curve_that_begins_at_the_threshold_has_no_warning() -> None:
    rates = sonine.cooling_rate([0.4, 0.7])
    assert np.isnan(rates).tolist() == [True, False]


def test_far_out_the_forms_meet_as_corrected_and_are_half_as_printed() -> None:
    for eta in (0.25, 0.5):
        exact = sonine.position_integral(60.0, eta)
        assert sonine.position_tail(60.0, eta, 2.0) / exact == pytest.approx(1, abs=0.01)
        assert sonine.position_tail(60.0, eta, 1.0) / exact == pytest.approx(0.5, abs=0.005)
        assert sonine.position_far_tail(60.0, eta) / exact == pytest.approx(0.5, abs=0.005)


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

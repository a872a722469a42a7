"""Scans over density and restitution, and the exponent of the tail, on cases that are known."""

import numpy as np
import pytest

from kinetics.crosscheck.report.case import Measured
from kinetics.crosscheck.report.observables import (
    BANDS,
    band_exponent,
    band_middles,
    measured_exponent,
)
from kinetics.crosscheck.report.scans import _share, extrapolate


def test_a_polynomial_is_extrapolated_exactly() -> None:
    x = np.array([0.01, 0.02, 0.04, 0.08])
    fit, limit = extrapolate(x, Measured(1 - 3 * x + 20 * x**2, np.full(4, 0.1)), 2)
    np.testing.assert_allclose(fit, [1, -3, 20], rtol=1e-9)
    assert float(limit.value) == pytest.approx(1)


def test_the_error_of_the_limit_is_the_spread_that_the_points_give() -> None:
    x, error = np.array([0.01, 0.02, 0.04, 0.08]), np.array([0.01, 0.02, 0.01, 0.03])
    noise = np.random.default_rng(5).normal(size=(4000, 4)) * error
    limits = [float(extrapolate(x, Measured(1 - x + n, error), 1)[1].value) for n in noise]
    claimed = float(extrapolate(x, Measured(1 - x, error), 1)[1].error)
    # 4000 samples give a standard deviation to 1.1 %: 5 of its sigmas
    assert np.std(limits) == pytest.approx(claimed, rel=0.056)


def test_too_few_points_have_no_limit() -> None:
    x = np.array([0.01, 0.02])
    _, limit = extrapolate(x, Measured(np.ones(2), np.array([0.1, 0.0])), 1)
    assert np.isnan(limit.value)


def test_the_share_caught_and_its_error() -> None:
    caught = np.array([[0, 1], [0, 2], [3, 1]])
    value, error = _share(caught, media=4, tracers=10)
    assert value == pytest.approx(0.075)
    shares = np.array([0.2, 0.0, 0.0, 0.1])
    assert error == pytest.approx(np.std(shares, ddof=1) / 2)
    assert _share(np.empty((0, 2)), 4, 10) == (0.0, 0.0)


@pytest.mark.parametrize("n", [1.0, 2.0])
def test_the_exponent_of_a_known_tail(n: float) -> None:
    # shares of p ~ exp(-R^n) in thin bands would give n; these bands smear it
    r = np.linspace(0, 4, 400_001)
    p = np.exp(-(r**n)) * r
    cumulated = np.concatenate([[0], np.cumsum((p[1:] + p[:-1]) / 2)])
    shares = np.diff(np.interp(BANDS, r, cumulated))
    # The first band's mean stands for p(0): n comes out too large, the less so the further out.
    excess = band_exponent(shares) - n
    assert np.all(np.diff(excess) < 0)
    assert 0 < excess[-1] < 0.1
    assert band_exponent(shares).shape == band_middles().shape


def test_an_empty_band_has_no_exponent() -> None:
    shares = np.array([0.2, 0.4, 0.2, 0.1, 0.06, 0.03, 0.01, 0.0])
    assert np.isnan(band_exponent(shares)[-1])
    assert np.all(np.isfinite(band_exponent(shares)[:-1]))


def test_a_gaussian_sample_has_exponent_two() -> None:
    x = np.random.default_rng(7).normal(size=(50, 4000, 2))
    found = measured_exponent(np.hypot(x[..., 0], x[..., 1]))
    r = np.linspace(0, 4, 400_001)
    p = 2 * r * np.exp(-(r**2))
    cumulated = np.concatenate([[0], np.cumsum((p[1:] + p[:-1]) / 2)]) * r[1]
    theory = band_exponent(np.diff(np.interp(BANDS, r, cumulated)))
    # 4 sigma in each of 4 bands; further out only a handful of 200 000 samples
    np.testing.assert_array_less(np.abs(found.value - theory)[:4], 4 * found.error[:4])
    assert np.all(found.error[:4] < 0.1)

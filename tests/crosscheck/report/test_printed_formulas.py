"""The printed formulas: their identities, their other transcription in sympy, and their limits.

A slip in one of the two transcriptions breaks an identity or differs from the other.
"""

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from derivations import symbols as sy
from derivations.printed import ROWS
from kinetics import sonine

ABOVE_THRESHOLD = np.array([0.59, 0.6, 0.7, 0.8, 0.9, 0.99])


@pytest.mark.parametrize("root", ["stable", "unstable"])
def test_both_roots_solve_the_equation_for_a2(root: str) -> None:
    # eq. sonine7 with eqs. sonine9 and sonine10
    e = ABOVE_THRESHOLD
    a2 = sonine.a2(e, root)
    left, right = 4 * sonine.m2(e, a2) * (a2 + 1), sonine.m4(e, a2)
    np.testing.assert_allclose(left, right, rtol=1e-13)


def test_the_closed_cooling_rate_is_half_of_m2_at_the_stable_root() -> None:
    e = ABOVE_THRESHOLD
    np.testing.assert_allclose(sonine.cooling_rate(e), sonine.m2(e, sonine.a2(e)) / 2, rtol=1e-14)


def test_the_stable_root_is_the_stable_one() -> None:
    assert np.all(sonine.stability(ABOVE_THRESHOLD) < 0)
    assert np.all(sonine.stability(ABOVE_THRESHOLD, "unstable") > 0)


def test_below_the_threshold_there_is_no_value() -> None:
    edge = sonine.THRESHOLD_RESTITUTION
    assert edge == pytest.approx(0.5815670576)
    assert np.isnan(sonine.a2(edge - 1e-9))
    assert np.isfinite(sonine.a2(edge + 1e-9))
    assert np.isnan(sonine.cooling_rate(0.4))
    assert np.isnan(sonine.msd_sonine(100.0, 0.4))


BETA, L, TIME = sp.Rational(1, 20), sp.Rational(27, 2), sp.Integer(400)
WALK = {sy.alpha: sp.Rational(5, 7), sy.beta: BETA, sy.l: L}
START = 7 / 5  # 1/alpha


def test_the_random_walk_is_the_printed_one() -> None:
    first, second = ROWS["ab"].formula.args
    known = {sy.v0(0): sp.Rational(7, 5), sy.d: 1, sy.rho0: BETA, sy.h: sp.Rational(1, 3)}
    assert float(sonine.alpha(START)) == pytest.approx(float(first.rhs.subs(known)))
    found = sonine.beta(0.5, float(BETA), cooling_rate=1 / 3)
    assert float(found) == pytest.approx(float(second.rhs.subs(known)))
    count = float(ROWS["N"].formula.rhs.subs(sy.tc(sy.N), TIME).subs(WALK))
    walk = sonine.msd_random_walk(float(TIME), 0.5, float(BETA), 1.0, float(L), START, 1.0)
    assert float(walk) == pytest.approx(float(L) ** 2 * count)


def test_the_pieces_of_the_position_distribution_are_the_printed_ones() -> None:
    (first,) = ROWS["gdefi"].formula.args[:1]
    integral = sp.Integral(first.rhs.args[0].subs({sy.R: 1.8, sy.eta: 1 / 3}), *first.rhs.args[1:])
    assert float(sonine.position_integral(1.8, 1 / 3)) == pytest.approx(float(integral.evalf()))


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

"""Shifts on equal panels: exact for polynomials, and no digits are lost where shifts are small."""

from types import ModuleType

import mpmath as mp
import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.numerics.chebyshev import Chebyshev, PanelShifts


def test_small_shifts_keep_their_digits() -> None:
    """f(x) - f(x - shift) relative to itself, where it is 1e-9 of f. (A difference of rounded
    points would leave 1e-7.)
    """
    rule, shift = Chebyshev(8), np.array([3.7e-9])
    loss, gain = PanelShifts(rule, shift).kernel(np.ones(1), np.ones((1, 1)), np.zeros((1, 1)))
    with mp.workdps(40):
        exact = [
            float(mp.exp(x) - mp.exp(mp.mpf(x) - mp.mpf(shift[0]))) for x in map(float, rule.local)
        ]
    # the panel below is reached from the first node only
    below = gain[0, 1:] @ np.exp(rule.local - 1.0)
    assert np.abs(below).max() == 0.0
    found = (loss[0] @ np.exp(rule.local))[1:]
    np.testing.assert_allclose(found, exact[1:], rtol=1e-7)  # of a polynomial of degree 7
    squares = (loss[0] @ rule.local**2)[1:]
    x, s = rule.local[1:], shift[0]
    np.testing.assert_allclose(squares, s * (2.0 * x - s), rtol=1e-12)


@pytest.mark.parametrize("gap", [1e-6, 1e-8])
def test_the_cooling_rate_of_nearly_elastic_tracers(gap: float, formulas: ModuleType) -> None:
    """v0 t -> 2 l/h: the small losses at each bounce decide it, and must not be rounded."""
    e, t = 1.0 - gap, 1e30
    found = solve(Scene(e, times=[t], outputs=("thermal_speed",)), rtol=1e-12)
    with mp.workdps(50):
        h = float(2 / mp.sqrt(formulas.integer_moment(e, 2)))
    assert 2.0 * 12.5 / (found.thermal_speed[0] * t) == pytest.approx(h, rel=2e-12, abs=0.0)

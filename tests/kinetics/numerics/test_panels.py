"""Shifts on equal panels: exact for polynomials, and no digits are lost where shifts are small."""

import math
from types import ModuleType

import mpmath as mp
import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.numerics.panels import PanelRule, PanelShifts, with_returns


@pytest.mark.parametrize("width", [1.0, 0.4])
def test_the_kernel_shifts_polynomials(width: float) -> None:
    """f(x) - sum of weight factor f(x - shift), from the panel of x and those below it."""
    rule, nodes = PanelRule(6, width), 6
    shift = width * np.array([0.0, 0.07, 0.31, 0.5, 1.0, 1.7, 2.9])
    weight = np.arange(1.0, 8.0) / 28.0
    factor = np.stack([np.ones(7), np.cos(np.arange(7.0))])
    loss, gain = PanelShifts(rule, shift).kernel(weight, factor, 1.0 - factor)
    assert loss.shape == (2, nodes, nodes)
    assert gain.shape == (2, nodes, 3 * nodes)
    x = width * (np.arange(-3, 1)[:, None] + rule.local)

    def f(at: np.ndarray) -> np.ndarray:
        return np.asarray(1.0 - 2.0 * at + at**5)

    for m in range(2):
        found = loss[m] @ f(x[-1]) - gain[m] @ f(x[:-1]).ravel()
        exact = f(x[-1]) - f(x[-1][:, None] - shift) @ (weight * factor[m])
        np.testing.assert_allclose(found, exact, atol=1e-12 * np.abs(exact).max())


def test_small_shifts_keep_their_digits() -> None:
    """f(x) - f(x - shift) relative to itself, where it is 1e-9 of f. (A difference of rounded
    points would leave 1e-7.)
    """
    rule, shift = PanelRule(8), np.array([3.7e-9])
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


def test_returns_act_on_exponentials_as_their_symbol() -> None:
    """On e^(p x) all three are numbers: K - 1 = -a, S = e^(-p shift), and -a/(1 + factor a S)."""
    rule, p, shift, factor = PanelRule(14, 0.8), 0.6, 1.3, 0.2
    weight, losses = np.array([0.3, 0.7]), np.array([0.4, 1.7])
    kept = np.array([[1.0, 1.0], [0.9, -0.5]])
    loss, gain = PanelShifts(rule, losses).kernel(weight, kept, 1.0 - kept)
    loss, gain = with_returns(rule, loss, gain, np.array([-0.1, factor]), shift)
    loss, gain = loss[1], gain[1]
    rate = 1.0 - float(kept[1] @ (weight * np.exp(-p * losses)))
    panels = gain.shape[1] // rule.nodes
    below = np.exp(p * rule.width * (np.arange(-panels, 0)[:, None] + rule.local)).ravel()
    here = np.exp(p * rule.width * rule.local)
    found = gain @ below - loss @ here
    expected = -rate / (1.0 + factor * rate * math.exp(-p * shift)) * here
    assert found == pytest.approx(expected, rel=1e-12)

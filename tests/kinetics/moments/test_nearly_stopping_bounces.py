"""Moments in time where every bounce leaves the same small share s of the speed (e = et = s)."""

import math
from functools import cache

import mpmath as mp
import numpy as np
import pytest

from kinetics import CollisionLaw, Scene, SolverStatus, solve
from kinetics.moments.backward import fall_of, panel_width

FREE_PATH = 12.5
SHARES = (1e-7, 1e-4, 0.01)


@cache
def one_speed(p: int, share: float, reduced: float) -> float:
    """<(v/v(0))^p> at T = v(0) t/l: the sum over N of s^(p N) P_N, P_N = chance of N bounces.

    The N-th free flight ends at the rate s^N per T, so that P_N is the product of s^k, k < N,
    times the sum over k <= N of exp(-s^k T)/prod(s^j - s^k), j <= N, j not k.
    """
    with mp.workdps(60):
        s, t = mp.mpf(share), mp.mpf(reduced)
        most = int(mp.ceil((mp.log(max(t, 1)) + 60) / -mp.log(s))) + 2
        rates = [s**k for k in range(most + 1)]
        total = mp.mpf(0)
        for n in range(most + 1):
            terms = (
                mp.exp(-rates[k] * t)
                / mp.fprod(rates[j] - rates[k] for j in range(n + 1) if j != k)
                for k in range(n + 1)
            )
            total += s ** (p * n) * mp.fprod(rates[:n]) * mp.fsum(terms)
        return float(total)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("rtol", [1e-6, 1e-12])
def test_between_one_bounce_and_the_next(share: float, rtol: float) -> None:
    """<v^4> falls as exp(-T) by ten orders and more, and then stands still until T = 1/s."""
    reduced = np.array([1.0, 10.0, 30.0, 60.0, 1e3, 1e5, 3e7, 1e12])
    scene = Scene(
        CollisionLaw(share, share),
        times=FREE_PATH * reduced,
        initial="monoenergetic",
        outputs=("thermal_speed", "a2"),
    )
    found = solve(scene, rtol)
    second, fourth = (np.array([one_speed(p, share, t) for t in reduced]) for p in (2, 4))
    assert found.status is SolverStatus.CONVERGED
    assert np.max(np.abs(found.thermal_speed**2 / second - 1.0)) <= rtol
    assert np.max(np.abs((1.0 + found.a2) / (0.5 * fourth / second**2) - 1.0)) <= rtol
    assert float(found.a2.min()) >= -0.5


@pytest.mark.parametrize("rtol", [1e-6, 1e-12])
def test_slow_tracers_of_the_start_are_what_is_left(rtol: float) -> None:
    """Of a Gaussian start: before the others have met 1/s scatterers, <v^2> is that of few."""
    share, times = 1e-7, np.array([1e3, 1e5])
    scene = Scene(CollisionLaw(share, share), times=times, outputs=("thermal_speed", "a2"))
    found = solve(scene, rtol)
    # the trapezoid rule in ln v; below e^-16 and above e^2.5 nothing is left
    spacing = 0.125
    v = np.exp(np.arange(-16.0, 2.5, spacing))
    weight = spacing * v**2 * np.exp(-0.5 * v * v)
    for i, t in enumerate(times):
        second, fourth = (
            math.fsum(w * u**p * one_speed(p, share, u * t / FREE_PATH)
                      for u, w in zip(v.tolist(), weight, strict=True))
            for p in (2, 4)
        )  # fmt: skip
        assert abs(found.thermal_speed[i] / math.sqrt(second) - 1.0) <= rtol
        assert abs((1.0 + found.a2[i]) / (0.5 * fourth / second**2) - 1.0) <= rtol


def test_panels_are_narrow_where_averages_fall() -> None:
    law = CollisionLaw(1e-4, 1e-4)
    assert fall_of(law, 2.0) == pytest.approx(-2.0 * math.log(1e-4))
    assert panel_width(2.0, fall_of(law, 2.0)) == pytest.approx(4.0 / fall_of(law, 2.0))
    assert panel_width(4.0, fall_of(CollisionLaw(0.0), 4.0)) == 1.0
    assert fall_of(law, -2.0) == 0.0
    assert panel_width(40.0, 1e4) == 1.0 / 32.0

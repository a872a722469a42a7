"""Moments in time where a bounce stops the tracer, or nearly.

At restitution 0 a head-on bounce stops it, and every p above -1 exists; at e = et = s every bounce
leaves the same small share s of the speed.
"""

from functools import cache

import mpmath as mp
import numpy as np
import pytest
from moment_hierarchy import chance_of_bounces

from kinetics import CollisionLaw, Scene, SolverStatus, solve

FREE_PATH = 12.5
REDUCED = (1e-6, 0.01, 0.5, 1.0, 3.0, 12.0, 40.0, 1e3, 1e9)  # T = v t/l
POWERS = (-0.1, -0.3, -0.5, -0.9, -0.999, -1.0 + 1e-10)


def one_speed(p: float, reduced: float) -> float:
    """<(v/v(0))^p> = T^-p gamma(p + 1, T) + e^-T, gamma the lower incomplete gamma function.

    At e = 0, s is uniform on [0, 1]: u(T) = <(v/v(0))^p> obeys u' + u = T^-(p+1) I, where I is the
    integral of x^p u(x) from 0 to T; its power series is sum_k (-T)^k/k! p/(p+k).
    """
    with mp.workdps(40):
        p_, t = mp.mpf(p), mp.mpf(reduced)
        return float(t**-p_ * mp.gammainc(p_ + 1, 0, t) + mp.exp(-t))


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-12])
@pytest.mark.parametrize("p", POWERS)
def test_every_power_above_minus_one(p: float, rtol: float) -> None:
    times = FREE_PATH * np.array(REDUCED)
    found = solve(Scene(0.0, times=times, initial="monoenergetic"), rtol).moment(p)
    exact = np.array([one_speed(p, t) for t in REDUCED])
    assert np.max(np.abs(found / exact - 1.0)) <= rtol


@cache
def equal_bounces(p: int, share: float, reduced: float) -> float:
    """<(v/v(0))^p> at T = v(0) t/l: the sum over N of s^(p N) P_N, P_N = chance of N bounces.

    The N-th free flight ends at the rate s^N per T.
    """
    with mp.workdps(60):
        s, t = mp.mpf(share), mp.mpf(reduced)
        most = int(mp.ceil((mp.log(max(t, 1)) + 60) / -mp.log(s))) + 2
        rates = [s**k for k in range(most + 1)]
        chances = (chance_of_bounces(rates[: n + 1], t) for n in range(most + 1))
        return float(mp.fsum(s ** (p * n) * chance for n, chance in enumerate(chances)))


@pytest.mark.parametrize("share", [1e-7, 1e-4, 0.01])
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
    second, fourth = (np.array([equal_bounces(p, share, t) for t in reduced]) for p in (2, 4))
    assert found.status is SolverStatus.CONVERGED
    assert np.max(np.abs(found.thermal_speed**2 / second - 1.0)) <= rtol
    assert np.max(np.abs((1.0 + found.a2) / (0.5 * fourth / second**2) - 1.0)) <= rtol
    assert float(found.a2.min()) >= -0.5

"""F(k, t) of a tracer of unit speed and rate that every collision turns at random, in space.

The exact solution of the one-speed transport equation, in mpmath; nothing here is shared with the
solver. The Laplace transform of F in time is A/(1 - A), A = arctan(k/(s + 1))/k: the sum over any
number of flights, each of which has the transform A. Run as a script it prints the table ONE_SPEED
of ``tests/kinetics/position/test_any_law.py``.
"""

from __future__ import annotations

from typing import Any

import mpmath as mp

WAVE_NUMBERS, TIMES = (0.3, 1.0, 2.5, 8.0), (0.5, 2.0, 4.0, 10.0)


def by_contour(k: float, t: float) -> Any:
    """The residue at the pole, where k < pi/2, and the integral along the cut s = -1 + i k x."""
    k_, t_ = mp.mpf(k), mp.mpf(t)

    def along_cut(x: Any) -> Any:
        log = mp.log((1 + x) / (1 - x))
        right, left = ((log + sign * 1j * mp.pi) / (2j * k_) for sign in (1, -1))
        return mp.exp(1j * k_ * x * t_) * (right / (1 - right) - left / (1 - left))

    panels = 2 * int(k * t / 3) + 9
    cut = mp.quad(along_cut, mp.linspace(-1, 1, panels)) * mp.exp(-t_) * k_ / (2 * mp.pi)
    pole = 0
    if k_ < mp.pi / 2:
        pole = mp.exp((k_ / mp.tan(k_) - 1) * t_) * (k_ / mp.sin(k_)) ** 2
    return mp.re(pole + cut)


if __name__ == "__main__":
    with mp.workdps(30):
        for t in TIMES:
            print(f"    ({', '.join(mp.nstr(by_contour(k, t), 17) for k in WAVE_NUMBERS)}),")

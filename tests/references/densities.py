"""Speed densities in 25 digits, by two Mellin-Barnes integrals, in mpmath.

With l = 1 and Q = Q_0 of `collision`,

    <v^p>(t) = Q(p)/(2 pi i) int Gamma(p - w)/Q(w) <v^w>(0) t^(w-p) dw,   0 < Re w < Re p,

for complex p, and v f(v, t) is the integral of <v^p>(t) v^-p dp/(2 pi i). Both integrals are by the
trapezoid rule.
"""

from __future__ import annotations

from typing import Any

import mpmath as mp
from collision import Product
from cooling import gaussian_moment

# and how far the lines go: the ring of nearly elastic tracers is narrow
RESTITUTIONS = {0.2: 50.0, 0.5: 50.0, 0.7: 50.0, 0.9: 50.0, 0.95: 90.0}
TIMES = (0.1, 3.0, 50.0, 2000.0)
STARTS = ("gaussian", "gamma")
SPEEDS = (0.01, 0.05, 0.2, 0.5, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0)  # in units of the scale below
_STEP = 1.0 / 14.0


def initial_moment(start: str, z: Any) -> Any:
    """<v^z> of v exp(-v^2/2), or of v^2 exp(-v)/2."""
    return gaussian_moment(z) if start == "gaussian" else mp.gamma(3 + z) / 2


def scale(t: float) -> float:
    """A speed of the order of the thermal one."""
    return 1.5 / (1.0 + 0.3 * t)


def densities(e: float) -> dict[str, dict[str, list[list[float]]]]:
    """start -> time -> [v, f(v, t)] pairs."""
    half = RESTITUTIONS[e]
    step, count = mp.mpf(_STEP), int(half / _STEP)
    product = Product(e, 0, half)
    left, right = mp.mpf("0.5"), mp.mpf(1)
    left_inverse = [1 / product(mp.mpc(left, n * step)) for n in range(count)]
    right_product = [product(mp.mpc(right, n * step)) for n in range(count)]
    # Gamma(p - w) depends on the difference of the indices alone
    between = [mp.gamma(mp.mpc(right - left, n * step)) for n in range(2 * count)]
    between = [z.conjugate() for z in between[:0:-1]] + between
    middle = 2 * count - 1
    out: dict[str, dict[str, list[list[float]]]] = {}
    for start in STARTS:
        one = [
            initial_moment(start, mp.mpc(left, n * step)) * q for n, q in enumerate(left_inverse)
        ]
        both = [z.conjugate() for z in one[:0:-1]] + one
        out[start] = {}
        for t in TIMES:
            turn = [b * mp.mpf(t) ** mp.mpc(0, (m - count + 1) * step) for m, b in enumerate(both)]
            power = []
            for n in range(count):
                row = between[middle + n - (count - 1) : middle + n + count]
                total = mp.fdot(zip(turn, reversed(row), strict=True)) * step / (2 * mp.pi)
                phase = mp.mpf(t) ** mp.mpc(left - right, -n * step)
                power.append(total * phase * right_product[n])
            pairs = []
            for c in SPEEDS:
                v = mp.mpf(c * scale(t))
                log_v = mp.log(v)
                terms = [
                    (p * mp.expj(-n * step * log_v)).real * (1 if n else mp.mpf(1) / 2)
                    for n, p in enumerate(power)
                ]
                # v f = v^-1 (1/pi) int, and f is that over v
                pairs.append([float(v), float(mp.fsum(terms) * step / mp.pi / v**2)])
            out[start][repr(t)] = pairs
    return out

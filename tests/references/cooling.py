"""Averages of the velocity at all times, in mpmath; nothing here is shared with the solver.

Unit of length: the mean free path. The moments obey d<v^p>/dt = -lambda(p) <v^(p+1)>, and those of
the displacement d<v^p v.r>/dt = <v^(p+2)> - nu_1(p+1) <v^(p+1) v.r>, d<r^2>/dt = 2 <v.r>.

Early times are power series in T = v_i t/l, which converge for every T. Late times come from
Mellin-Barnes integrals with the products Q_m of `collision`:

    <v^p cos(m phi)>/v_i^p T^p = Q_m(p)/(2 pi i) integral of Gamma(w+p)/Q_m(-w) T^-w dw

for a start at one speed and direction, on a line just right of Re w = -p. The poles on the right of
it, the zeros of nu_m among them, give the expansion at late times: not only powers 1/T.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
from collision import Product, speed_ratio_powers

from kinetics.crosscheck.references import HORIZONS, MEAN_FREE_PATH, times

DIGITS = 50  # of what is not said to need more
STEP = mp.mpf(1) / 32  # of Im w: images of ln T 201 apart
HALF_LENGTH = 48  # |integrand| falls as exp(-pi |Im w|/2)

# -- power series in T, for every T ----------------------------------------------------------------


def early_power(
    e: Any, p: Any, reduced_time: Any, start: Any = None, *, integrated: bool = False
) -> Any:
    """T^p m_p(T): sum of (-T)^k/k! lambda(p) ... lambda(p+k-1), times <v^(p+k)>(0) = start(p+k).

    integrated: its integral over T in place of it, over T^p; of p = 1 the number of collisions.
    """
    t = float(reduced_time)
    # terms grow as T^k/k! before they cancel: T/ln(10) digits
    digits = DIGITS + int(0.5 * (t if start is None else t * t)) + 10
    with mp.workdps(digits):
        t, p = mp.mpf(reduced_time), mp.mpmathify(p)
        weigh = start or (lambda q: mp.mpf(1))
        count = 60 + int(4 * float(t) + (0 if start is None else 4 * float(t) ** 2))
        phi = speed_ratio_powers(e, p, count)
        term = t**p
        total = term * weigh(p)
        for k in range(count):
            term *= -t * (1 - phi[k]) / (k + 1 + integrated)
            total += term * weigh(p + k + 1)
        return total


# -- Mellin-Barnes integrals -----------------------------------------------------------------------


def along_line(values: list[Any], step: Any, log_t: Any) -> Any:
    """1/pi Re of the integral of values exp(-i y ln T) over y > 0, by the trapezoid rule."""
    turn, total, phase = mp.expj(-step * log_t), -values[0].real / 2, mp.mpc(1)
    for value in values:
        total += (value * phase).real
        phase *= turn
    return total * step / mp.pi


class Line:
    """1/Q_m(-w) at w = centre + i n STEP, and Mellin-Barnes integrals over that line."""

    def __init__(self, e: Any, m: int, centre: str) -> None:
        count = int(HALF_LENGTH / STEP)
        self.product = Product(e, m, HALF_LENGTH + 2)
        self.w = [mp.mpc(mp.mpf(centre), n * STEP) for n in range(count + 1)]
        self.inverse = [1 / self.product(-w) for w in self.w]

    def integrate(self, weight: list[Any], reduced_time: Any) -> Any:
        """1/(2 pi i) integral of weight(w) T^-w/Q(-w), weight at the points of the line."""
        log_t = mp.log(mp.mpf(reduced_time))
        values = [a * b for a, b in zip(weight, self.inverse, strict=True)]
        return along_line(values, STEP, log_t) * mp.exp(-self.w[0].real * log_t)

    def power(self, p: Any, start: Any) -> list[Any]:
        """Weight of (t/l)^p <v^p cos(m phi)>; the line must lie between -p and the poles."""
        first = self.product(p)
        return [first * mp.gamma(w + p) * start(w) for w in self.w]

    def collisions(self, start: Any) -> list[Any]:
        """Weight of N, the integral of <v>/l; -1 < Re w < 0."""
        return [mp.gamma(w + 1) / -w * start(w) for w in self.w]


def square_weight(outer: Line, inner: Line, start: Any) -> list[Any]:
    """Weight of <r^2>/l^2 on the outer line (m = 0), by a sum over the inner one (m = 1).

    <r^2> = 2 integral over t2 of <v(t2) l chi1(v(t2) (t-t2)/l)>, with chi1 and <v^(1-w)> by their
    own integrals, and a beta function from t2. -1 < Re w' < Re w < 0, w the inner one.
    """
    count = len(outer.w) - 1
    q0 = [outer.product(1 - w) for w in inner.w]
    q0 = [mp.conj(q) for q in q0[:0:-1]] + q0
    w_inner = [mp.conj(w) for w in inner.w[:0:-1]] + inner.w
    inverse = [mp.conj(q) for q in inner.inverse[:0:-1]] + inner.inverse
    one_turn = -inner.product(1)
    # chi1's weight times E[v^(1-w)]'s factor times Gamma(1-w) of the beta function
    known = [
        one_turn * mp.gamma(w) * i * q * mp.gamma(1 - w)
        for w, i, q in zip(w_inner, inverse, q0, strict=True)
    ]
    gap = outer.w[0].real - inner.w[0].real  # w' - w = gap + i (difference) STEP
    spread = range(-2 * count, 2 * count + 1)
    far = [mp.gamma(mp.mpc(gap + 1, j * STEP)) * mp.gamma(mp.mpc(-gap, -j * STEP)) for j in spread]
    weight = []
    for n, w in enumerate(outer.w):
        total = mp.fdot((known[i], far[n - (i - count) + 2 * count]) for i in range(2 * count + 1))
        weight.append(2 * total * STEP / (2 * mp.pi) / mp.gamma(1 - w) * start(w))
    return weight


# -- starts: <v^-w>, the average over the initial speeds -------------------------------------------

TABLE = ([0.5, 1.0, 2.0], [0.0, 4.0 / 3.0, 0.0])
"""Speeds and densities of a triangle."""
SAMPLES = [0.3, 1.0, 1.7, 2.5]


def one_speed(w: Any) -> Any:
    """A monoenergetic start."""
    return mp.mpf(1)


def gaussian_speeds(w: Any) -> Any:
    """The Gaussian start, density v exp(-v^2/2)."""
    return gaussian_moment(-w)


def gaussian_moment(q: Any) -> Any:
    """<v^q>(0) of the Gaussian start."""
    return 2 ** (q / 2) * mp.gamma(1 + q / 2)


def table_speeds(w: Any) -> Any:
    """The triangle TABLE."""
    (a, b, c), height = map(mp.mpf, TABLE[0]), mp.mpf(4) / 3

    def ramp(zero: Any, low: Any, high: Any) -> Any:
        """Integral of (v - zero) v^-w from low to high."""
        return sum(
            sign * (v ** (2 - w) / (2 - w) - zero * v ** (1 - w) / (1 - w))
            for sign, v in ((1, high), (-1, low))
        )

    return height * (ramp(a, a, b) / (b - a) - ramp(c, b, c) / (c - b))


def sample_speeds(w: Any) -> Any:
    """The speeds SAMPLES, all as likely."""
    return sum(mp.mpf(v) ** -w for v in SAMPLES) / len(SAMPLES)


def exponential_speeds(w: Any) -> Any:
    """The density v exp(-v)."""
    return mp.gamma(2 - w)


def power_law_speeds(w: Any) -> Any:
    """The density 5 v (1 + v^2)^(-7/2), which falls as v^-6."""
    return mp.mpf(5) / 2 * mp.beta(1 - w / 2, mp.mpf(5) / 2 + w / 2)


STARTS: dict[str, Callable[[Any], Any]] = {
    "monoenergetic": one_speed, "gaussian": gaussian_speeds, "table": table_speeds,
    "samples": sample_speeds, "exponential": exponential_speeds, "power_law": power_law_speeds,
}  # fmt: skip

# -- the tables ------------------------------------------------------------------------------------

FREE_PATH = mp.mpf(MEAN_FREE_PATH)
TIMES = [0.01, 0.3, 3.0, 12.5, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8]
"""In d/U."""


def evolution(
    e: float, names: list[str], powers: list[float], early: Callable[[Any], Any]
) -> dict[str, Any]:
    """Averages at TIMES, by the power series up to t/l = 2, by Mellin-Barnes integrals later.

    early : <r^2>/l^2 and <r^4>/l^4 of a monoenergetic start, by their series
    """
    line, turned = Line(e, 0, "-0.6"), Line(e, 1, "-0.3")
    square = square_weight(line, turned, one_speed)
    out: dict[str, Any] = {}
    for name in names:
        start = STARTS[name]
        weights = {f"v^{p:g}": line.power(mp.mpf(p), start) for p in powers}
        weights["collisions"] = line.collisions(start)
        weights["msd"] = [a * start(w) for a, w in zip(square, line.w, strict=True)]
        # closed forms of <v^q>(0), with which the power series can begin
        exact = {"monoenergetic": one_speed, "gaussian": gaussian_moment}.get(name)
        rows: dict[str, list[float]] = {key: [] for key in weights}
        for t in TIMES:
            reduced = mp.mpf(t) / FREE_PATH
            for key, weight in weights.items():
                power = mp.mpf(key[2:]) if key.startswith("v^") else mp.mpf(0)
                if reduced < 2 and power and exact is not None:
                    value = early_power(e, power, reduced, exact)
                elif reduced < 2 and key == "collisions" and name == "monoenergetic":
                    value = early_power(e, 1, reduced, integrated=True)
                elif reduced < 2 and key == "msd" and name == "monoenergetic":
                    value = early(reduced)[0]
                else:
                    value = line.integrate(weight, reduced)
                value *= FREE_PATH**2 if key == "msd" else reduced**-power
                rows[key].append(float(value))
        out[name] = rows
    return out


def beam(e: float) -> dict[str, list[float]]:
    """<v^2 cos(m phi)> of a beam of speed 1 along phi = 0 at TIMES, m = 1 ... 8."""
    out = {}
    for m in range(1, 9):
        line = Line(e, m, "-0.6")
        weight = line.power(mp.mpf(2), one_speed)
        reduced = [mp.mpf(t) / FREE_PATH for t in TIMES]
        out[str(m)] = [float(line.integrate(weight, t) / t**2) for t in reduced]
    return out


def thermal(e: float, start: str, line: Line) -> dict[str, dict[str, list[float]]]:
    """v0 and a2 of the table "benchmark": quantity -> horizon -> values; line of m = 0 at -0.6."""
    second, fourth = (line.power(mp.mpf(p), STARTS[start]) for p in (2, 4))
    out: dict[str, dict[str, list[float]]] = {"thermal_speed": {}, "a2": {}}
    for horizon in HORIZONS:
        reduced = [mp.mpf(float(t)) / FREE_PATH for t in times(horizon)]
        v2 = [line.integrate(second, t) / t**2 for t in reduced]
        v4 = [line.integrate(fourth, t) / t**4 for t in reduced]
        out["thermal_speed"][horizon] = [float(mp.sqrt(x)) for x in v2]
        out["a2"][horizon] = [float(b / (2 * a**2) - 1) for a, b in zip(v2, v4, strict=True)]
    return out

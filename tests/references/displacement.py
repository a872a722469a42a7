"""<r^2> and <r^4> of a tracer, in mpmath; nothing here is shared with the solver.

Unit of length: the mean free path. A tracer of initial speed u has <r^n> = function of T = u t/l.

With z = x + i y measured along the first velocity, M_ab = <z^a conj(z)^b> of a tracer of unit speed
obeys (a free flight, then a collision that turns it by chi and leaves it the speed s)

    M_ab'(T) = a M_(a-1)b + b M_a(b-1) + E[cos((a-b) chi) M_ab(s T)] - M_ab(T),

so that its power series in T, which converges everywhere, has the terms of a short recursion:
<r^2> = M_11 and <r^4> = M_22 need M_10, M_20 and M_21 beside them. `Early` sums it with as many
digits as cancel.

Late times, and starts with many speeds, come from Mellin-Barnes integrals. The Mellin transform of
M_ab, analytic for -(a+b) < Re w < 0, obeys

    nu_m(-w) M(w) = S(w) + (w-1) M(w-1),   m = a - b,  S that of a M_(a-1)b + b M_a(b-1),

and with M(w) = D(w)/(Gamma(1-w) Q_m(-w)), Q_m as in `collision`, D(w) + D(w-1) = R(w) =
S(w) Gamma(1-w) Q_m(1-w), whose solution is an integral along a line on the right of w, less than 1
away:

    D(w') = 1/(2 pi i) integral of R(w) pi/sin(pi (w - w')) dw.

`Lines` goes from M_10 to M_22 in three such steps.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import mpmath as mp
from collision import Product, decay_rates
from cooling import FREE_PATH, along_line, gaussian_moment, gaussian_speeds

from kinetics.crosscheck.references import times

DIGITS = 45


class Early:
    """<r^2>/l^2 and <r^4>/l^4 at one initial speed for 0 <= T <= longest, e from 0 to 1."""

    def __init__(self, e: Any, longest: float) -> None:
        self.longest = float(longest)
        # terms grow as T^k/k! before they cancel: T/ln(10) digits
        self.digits = DIGITS + int(0.45 * self.longest) + 15
        count = 60 + DIGITS + int(3.7 * self.longest)
        with mp.workdps(self.digits):
            none, once, twice = (decay_rates(e, m, 0, count) for m in (0, 1, 2))
            chi = sec = rho = tau = four = mp.mpf(0)  # M_10, M_20, M_11, M_21, M_22
            self.square_terms, self.fourth_terms = [rho], [four]
            for k in range(count):
                n0, n1, n2 = none[k], once[k], twice[k]
                chi, sec, rho, tau, four = (
                    ((1 if k == 0 else 0) - n1 * chi) / (k + 1),
                    (2 * chi - n2 * sec) / (k + 1),
                    (2 * chi - n0 * rho) / (k + 1),
                    (2 * rho + sec - n1 * tau) / (k + 1),
                    (4 * tau - n0 * four) / (k + 1),
                )
                self.square_terms.append(rho)
                self.fourth_terms.append(four)

    def __call__(self, reduced_time: Any) -> tuple[Any, Any]:
        """(<r^2>/l^2, <r^4>/l^4) at T; ValueError beyond the longest."""
        t = float(reduced_time)
        if t > self.longest:
            raise ValueError(f"T = {t}: at most {self.longest}")
        count = 60 + DIGITS + int(3.7 * t)
        with mp.workdps(min(self.digits, DIGITS + int(0.45 * t) + 15)):
            x = mp.mpf(reduced_time)
            out = []
            for terms in (self.square_terms, self.fourth_terms):
                total = mp.mpf(0)
                for term in reversed(terms[: count + 1]):
                    total = total * x + term
                out.append(total)
        return out[0], out[1]

    def gaussian(self, reduced_time: Any) -> tuple[Any, Any]:
        """The same for the Gaussian start: <u^k> = 2^(k/2) Gamma(1 + k/2) term by term.

        That series converges for every T, but its terms only fall beyond k = T^2, and cancel by
        exp(T^2/2): the longest T must be 22 times this one, or 3 T^2, whichever is more.
        """
        with mp.workdps(self.digits):
            x = mp.mpf(reduced_time)
            square, fourth = (
                mp.fsum(c * x**k * gaussian_moment(mp.mpf(k)) for k, c in enumerate(terms))
                for terms in (self.square_terms, self.fourth_terms)
            )
        return square, fourth


# At the ends the integrand is 1e-27 times a power of w and T^0.95: missing are 2e-17 (e = 0.4) to
# 5e-15 (e = 0.9) at T up to 100, 2e-14 at most at T = 1e8.
STEP = mp.mpf(1) / 48  # of Im w: exp(-2 pi 0.2/STEP) = 1e-26
HALF_LENGTH = 40  # of the lines: exp(-pi HALF_LENGTH/2) = 1e-27
WINDOW = 20  # of the convolutions: exp(-pi WINDOW) = 1e-27
CENTRES = [mp.mpf(c) / 20 for c in (-4, -9, -14, -19)]  # Re w of M_10; M_20, M_11; M_21; M_22


class Lines:
    """<r^2>/l^2 and <r^4>/l^4 at any T, best above 1, for a start at speed 1; 0 <= e < 1."""

    def __init__(self, e: Any) -> None:
        count = int(HALF_LENGTH / STEP)
        turns = [Product(e, m, HALF_LENGTH + 4) for m in (0, 1, 2)]
        self.w = [[mp.mpc(c, n * STEP) for n in range(count + 1)] for c in CENTRES]

        def step(source: list[Any], level: int, m: int) -> list[Any]:
            """The transform on line `level` from its source S on the line before."""
            right = [
                s * mp.gamma(1 - w) * turns[m](1 - w)
                for s, w in zip(source, self.w[level - 1], strict=True)
            ]
            right = [mp.conj(r) for r in right[:0:-1]] + right  # from -count to count
            reach = int(WINDOW / STEP)
            gap = CENTRES[level - 1] - CENTRES[level]
            kernel = [
                mp.pi / mp.sin(mp.pi * mp.mpc(gap, j * STEP)) for j in range(-reach, reach + 1)
            ]
            out = []
            for n, w in enumerate(self.w[level]):
                first, last = max(0, n + count - reach), min(2 * count, n + count + reach)
                at = first - n - count + reach
                total = mp.fdot(
                    zip(right[first : last + 1], kernel[at : at + last - first + 1], strict=True)
                )
                scale = mp.gamma(1 - w) * turns[m](-w)
                out.append(total * STEP / (2 * mp.pi) / scale)
            return out

        chi = [-mp.gamma(w) * turns[1](1) / turns[1](-w) for w in self.w[0]]
        twice = [2 * c for c in chi]
        self.square = step(twice, 1, 0)
        second = step(twice, 1, 2)
        third = step([2 * a + b for a, b in zip(self.square, second, strict=True)], 2, 1)
        self.fourth = step([4 * t for t in third], 3, 0)

    def weighted(self, start: Callable[[Any], Any]) -> Lines:
        """The same for a start with many speeds: `start` is w -> <v^-w>."""
        other = copy.copy(self)
        other.square = [v * start(w) for v, w in zip(self.square, self.w[1], strict=True)]
        other.fourth = [v * start(w) for v, w in zip(self.fourth, self.w[3], strict=True)]
        return other

    def __call__(self, reduced_time: Any) -> tuple[Any, Any]:
        """(<r^2>/l^2, <r^4>/l^4) at T = t/l."""
        log_t = mp.log(mp.mpf(reduced_time))
        square, fourth = (
            along_line(values, STEP, log_t) * mp.exp(-CENTRES[line] * log_t)
            for line, values in ((1, self.square), (3, self.fourth))
        )
        return square, fourth


# -- the tables ------------------------------------------------------------------------------------

RESTITUTIONS = [0.0, 0.05, 0.4, 0.7, 0.9, 0.99]
TIMES = [float(10.0 ** (j / 8)) for j in range(-48, 65)]  # T = t/l
SERIES_TO = 100.0


def displacement(e: float) -> dict[str, Any]:
    """<r^2>/l^2 and <r^4>/l^4 at TIMES, for speeds 1 (or Gaussian, in U)."""
    early, lines = Early(e, SERIES_TO), Lines(e)
    averaged = lines.weighted(gaussian_speeds)
    apart = max(
        abs(a / b - 1)
        for t in (1.0, 10.0, SERIES_TO)
        for a, b in zip(lines(t), early(t), strict=True)
    )
    one = [early(t) if t <= SERIES_TO else lines(t) for t in TIMES]
    # at the shortest times the integrals lose digits: the series in <v^p> does not
    many = [early.gaussian(t) if t < 0.03 else averaged(t) for t in TIMES]
    out: dict[str, Any] = {"series_and_integrals_apart": float(apart)}
    for name, pairs in (("monoenergetic", one), ("gaussian", many)):
        out[name] = {
            key: [float(pair[which]) for pair in pairs]
            for which, key in enumerate(("square", "fourth"))
        }
    return out


def short(e: float, start: str) -> dict[str, dict[str, list[float]]]:
    """<r^2> in d^2 and the kurtosis of the table "benchmark": quantity -> horizon -> values."""
    reduced = [mp.mpf(float(t)) / FREE_PATH for t in times("short")]
    early = Early(e, 24 * reduced[-1])
    pairs = [early.gaussian(t) if start == "gaussian" else early(t) for t in reduced]
    return {
        "msd": {"short": [float(square * FREE_PATH**2) for square, _ in pairs]},
        "kurtosis": {"short": [float(fourth / square**2) for square, fourth in pairs]},
    }

"""References for the position of the tracer, in mpmath; nothing here is shared with the solver.

Unit of length: the mean free path. A tracer of initial speed u has <r^n> = function of T = u t/l.

With z = x + i y measured along the first velocity, M_ab = <z^a conj(z)^b> of a tracer of unit speed
obeys (a free flight, then a collision that turns it by chi and leaves it the speed s)

    M_ab'(T) = a M_(a-1)b + b M_a(b-1) + E[cos((a-b) chi) M_ab(s T)] - M_ab(T),

so that its power series in T, which converges everywhere, has the terms of a short recursion:
<r^2> = M_11 and <r^4> = M_22 need M_10, M_20 and M_21 beside them. :class:`Early` sums it with as
many digits as cancel. The same moments forward in time, <v^p exp(i n theta) z^a conj(z)^b>, close
upwards in p: :func:`moments_forward`, slower, to check the first.

Late times, and starts with many speeds, come from Mellin-Barnes integrals. The Mellin transform of
M_ab, analytic for -(a+b) < Re w < 0, obeys

    nu_m(-w) M(w) = S(w) + (w-1) M(w-1),   m = a - b,  S that of a M_(a-1)b + b M_a(b-1),

and with M(w) = D(w)/(Gamma(1-w) Q_m(-w)), Q_m(z) = nu_m(z) Q_m(z+1) as in kinetic_references.py,
D(w) + D(w-1) = R(w) = S(w) Gamma(1-w) Q_m(1-w), whose solution is an integral along a line on the
right of w, less than 1 away:

    D(w') = 1/(2 pi i) integral of R(w) pi/sin(pi (w - w')) dw.

:class:`Lines` goes from M_10 to M_22 in three such steps.

Run this file to write ``position_references.json`` beside it (half an hour; gmpy2 helps).
"""

import copy
import importlib.util
import json
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath as mp

DIGITS = 45
TWIST1, TWIST2 = mp.mpf(4) / 3, mp.mpf(16) / 15  # nu_1, nu_2 at e = 1


def _formulas() -> ModuleType:
    """kinetic_references.py, the formulas of one collision."""
    name = "kinetic_references"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


def decay_rates(e: Any, count: int) -> tuple[list[Any], list[Any], list[Any]]:
    """nu_0(k), nu_1(k), nu_2(k) for k = 0 ... count - 1, from cos(chi) = (s^2 - e)/((1 - e) s)."""
    e = mp.mpf(e)
    if e == 1:
        return [mp.mpf(0)] * count, [TWIST1] * count, [TWIST2] * count
    base = _formulas()
    low = [mp.mpf(0) if e == 0 else base.speed_ratio_power(e, p) for p in (-2, -1)]
    phi = low + base.speed_ratio_powers(e, 0, count + 2)  # phi[k] = E[s^(k-2)]
    g = 1 / (1 - e)
    none = [1 - phi[k + 2] for k in range(count)]
    once = [1 - (phi[k + 3] - e * phi[k + 1]) * g for k in range(count)]
    twice = [
        1 - (2 * (phi[k + 4] - 2 * e * phi[k + 2] + e * e * phi[k]) * g * g - phi[k + 2])
        for k in range(count)
    ]
    return none, once, twice


class Early:
    """<r^2>/l^2 and <r^4>/l^4 at one initial speed for 0 <= T <= longest, e from 0 to 1."""

    def __init__(self, e: Any, longest: float, rates: Any = None, digits: int = DIGITS) -> None:
        """``rates`` may stand for :func:`decay_rates`: another law of collision."""
        self.longest, self.spare = float(longest), digits
        # terms grow as T^k/k! before they cancel: T/ln(10) digits
        self.digits = digits + int(0.45 * self.longest) + 15
        count = 60 + digits + int(3.7 * self.longest)
        with mp.workdps(self.digits):
            none, once, twice = (rates or decay_rates)(e, count)
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
        """(<r^2>/l^2, <r^4>/l^4) at T."""
        t = float(reduced_time)
        if t > self.longest:
            raise ValueError(f"T = {t}: at most {self.longest}")
        count = 60 + self.spare + int(3.7 * t)
        with mp.workdps(min(self.digits, self.spare + int(0.45 * t) + 15)):
            x = mp.mpf(reduced_time)
            out = []
            for terms in (self.square_terms, self.fourth_terms):
                total = mp.mpf(0)
                for term in reversed(terms[: count + 1]):
                    total = total * x + term
                out.append(total)
        return out[0], out[1]


def square(e: Any, reduced_time: Any) -> Any:
    """<r^2>/l^2 at T = u t/l for a monoenergetic start, by its power series (T up to hundreds)."""
    return Early(e, float(reduced_time))(reduced_time)[0]


def fourth(e: Any, reduced_time: Any) -> Any:
    """<r^4>/l^4 at T = u t/l for a monoenergetic start, by its power series (T up to hundreds)."""
    return Early(e, float(reduced_time))(reduced_time)[1]


def moments_forward(e: Any, reduced_time: Any, count: int) -> tuple[Any, Any]:
    """The same two by the hierarchy forward in time, in ``count`` powers of T.

    With w = v exp(i theta) and z = x + i y, mu(p, n, a, b) = <v^p exp(i n theta) z^a conj(z)^b>,
    n = b - a by isotropy, obeys

        mu' = a mu(p+1, n+1, a-1, b) + b mu(p+1, n-1, a, b-1) - nu_n(p) mu(p+1, n, a, b).
    """
    t = mp.mpf(reduced_time)
    rates = decay_rates(e, count + 6)
    keys = [(a, b) for a in range(3) for b in range(3)]
    # mu[a, b][p] is the coefficient of T^k
    mu = {key: [mp.mpf(1 if key == (0, 0) else 0)] * (count + 4) for key in keys}
    totals = [mp.mpf(0), mp.mpf(0)]
    for k in range(count):
        new = {}
        for a, b in keys:
            nu = rates[abs(a - b)]
            row = []
            for p in range(len(mu[a, b]) - 1):
                value = -nu[p] * mu[a, b][p + 1]
                if a:
                    value += a * mu[a - 1, b][p + 1]
                if b:
                    value += b * mu[a, b - 1][p + 1]
                row.append(value / (k + 1))
            new[a, b] = row
        mu = new
        power = t ** (k + 1)
        totals = [totals[0] + mu[1, 1][0] * power, totals[1] + mu[2, 2][0] * power]
    return totals[0], totals[1]


# -- Mellin-Barnes integrals ---------------------------------------------------------------------

# At the ends the integrand is 1e-27 times a power of w and T^0.95: missing are 2e-17 (e = 0.4) to
# 5e-15 (e = 0.9) at T up to 100, 2e-14 at most at T = 1e8.
STEP = mp.mpf(1) / 48  # of Im w: exp(-2 pi 0.2/STEP) = 1e-26
HALF_LENGTH = 40  # of the lines: exp(-pi HALF_LENGTH/2) = 1e-27
WINDOW = 20  # of the convolutions: exp(-pi WINDOW) = 1e-27
CENTRES = [mp.mpf(c) / 20 for c in (-4, -9, -14, -19)]  # Re w of M_10; M_20, M_11; M_21; M_22


def principal(e: Any, m: int) -> Callable[[Any], Any]:
    """Q_m(z); at e = 0, where s = cos(chi) = y, by gamma functions."""
    if e != 0:
        return _formulas().Product(e, m, HALF_LENGTH + 4)  # type: ignore[no-any-return]
    if m == 0:  # nu = z/(z+1)
        return lambda z: z
    if m == 1:  # nu = (z+1)/(z+2)
        return lambda z: (z + 1) / 2
    # nu = (z^2 + 3z + 4)/((z+1)(z+3))
    zero = mp.mpc(-3, mp.sqrt(7)) / 2

    def unscaled(z: Any) -> Any:
        gammas = [mp.loggamma(z + 1), mp.loggamma(z + 3)]
        return mp.exp(sum(gammas) - mp.loggamma(z - zero) - mp.loggamma(z - mp.conj(zero)))

    one = unscaled(mp.mpf(1))
    return lambda z: unscaled(z) / one


class Lines:
    """<r^2>/l^2 and <r^4>/l^4 at any T, best above 1, for a start at speed 1; 0 <= e < 1."""

    def __init__(self, e: Any) -> None:
        count = int(HALF_LENGTH / STEP)
        turns = [principal(e, m) for m in (0, 1, 2)]
        self.w = [[mp.mpc(c, n * STEP) for n in range(count + 1)] for c in CENTRES]

        def step(source: list[Any], level: int, m: int) -> list[Any]:
            """The transform on line ``level`` from its source S on the line before."""
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

    def weighted(self, start: Callable[[Any], Any]) -> "Lines":
        """The same for a start with many speeds: ``start`` is w -> <v^-w>."""
        other = copy.copy(self)
        other.square = [v * start(w) for v, w in zip(self.square, self.w[1], strict=True)]
        other.fourth = [v * start(w) for v, w in zip(self.fourth, self.w[3], strict=True)]
        return other

    def __call__(self, reduced_time: Any) -> tuple[Any, Any]:
        """(<r^2>/l^2, <r^4>/l^4) at T = t/l."""
        log_t = mp.log(mp.mpf(reduced_time))
        turn = mp.expj(-STEP * log_t)
        out = []
        for line, values in ((1, self.square), (3, self.fourth)):
            total, phase = mp.mpf(0), mp.mpc(1)
            for n, value in enumerate(values):
                total += (value * phase).real * (1 if n else mp.mpf(1) / 2)
                phase *= turn
            out.append(total * STEP / mp.pi * mp.exp(-CENTRES[line] * log_t))
        return out[0], out[1]


def elastic_inverse(reduced_time: Any, first: Any, second: Any) -> tuple[Any, Any]:
    """The same two at e = 1, at any T, for constant nu_1 and nu_2: by residues.

    The Laplace transforms are 2/(p^2 (p + nu_1)) and 16/(p^3 (p + nu_1)^2) +
    8/(p^2 (p + nu_1)^2 (p + nu_2)).
    """
    t, first, second = mp.mpf(reduced_time), mp.mpf(first), mp.mpf(second)

    def inverse(*poles: tuple[Any, int]) -> Any:
        total = mp.mpf(0)
        for place, order in poles:
            # Taylor coefficients of the other factors about this pole
            series = [mp.mpf(1)] + [mp.mpf(0)] * (order - 1)
            for other, power in poles:
                if other == place:
                    continue
                gap = place - other
                for _ in range(power):
                    for i in range(order):
                        series[i] = (series[i] - (series[i - 1] if i else 0)) / gap
            total += mp.exp(place * t) * sum(
                c * t ** (order - 1 - i) / mp.factorial(order - 1 - i) for i, c in enumerate(series)
            )
        return total

    rho = 2 * inverse((mp.mpf(0), 2), (-first, 1))
    tail = [(-first, 3)] if first == second else [(-first, 2), (-second, 1)]
    fourth_ = 16 * inverse((mp.mpf(0), 3), (-first, 2)) + 8 * inverse((mp.mpf(0), 2), *tail)
    return rho, fourth_


# -- the elastic walk with isotropic scattering --------------------------------------------------


def isotropic_ring(t: Any) -> Any:
    """Share of tracers not yet scattered at t (in mean free times): they are at r = t."""
    return mp.exp(-mp.mpf(t))


def isotropic_density(r: Any, t: Any) -> Any:
    """Radial density of the others for 0 <= r < t, unit speed and free path, v = 1.

    r exp(-t + sqrt(t^2 - r^2))/sqrt(t^2 - r^2): Stadje, J. Stat. Phys. 46, 207 (1987); Masoliver,
    Porra and Weiss, Physica A 193, 469 (1993).
    """
    r, t = mp.mpf(r), mp.mpf(t)
    root = mp.sqrt((t - r) * (t + r))
    return r * mp.exp(root - t) / root


def isotropic_share(r: Any, t: Any) -> Any:
    """Share of all tracers that are within r < t: 1 - exp(-t + sqrt(t^2 - r^2)) of the others."""
    r, t = mp.mpf(r), mp.mpf(t)
    return -mp.expm1(mp.sqrt((t - r) * (t + r)) - t)


def isotropic_scattering(k: Any, t: Any) -> Any:
    """F(k, t) = <exp(i k.r)> of all tracers, ring included, by quadrature over sqrt(t^2 - r^2)."""
    k, t = mp.mpf(k), mp.mpf(t)
    pieces = max(2, int(k * t / 3) + int(t / 4) + 2)
    points = [t * mp.sin(mp.pi * i / (2 * pieces)) for i in range(pieces + 1)]
    body = mp.quad(lambda s: mp.exp(s - t) * mp.besselj(0, k * mp.sqrt((t - s) * (t + s))), points)
    return mp.exp(-t) * mp.besselj(0, k * t) + body


# -- the numbers of the tests --------------------------------------------------------------------

RESTITUTIONS = [0.0, 0.05, 0.4, 0.7, 0.9, 0.99]
TIMES = [float(10.0 ** (j / 8)) for j in range(-48, 65)]  # T = t/l
SERIES_TO = 100.0


def table(e: float) -> dict[str, Any]:
    """<r^2>/l^2 and <r^4>/l^4 at TIMES, for speeds 1 (or Gaussian, in U)."""
    early, lines = Early(e, SERIES_TO), Lines(e)
    averaged = lines.weighted(_formulas().gaussian_speeds)
    apart = max(
        abs(a / b - 1)
        for t in (1.0, 10.0, SERIES_TO)
        for a, b in zip(lines(t), early(t), strict=True)
    )
    one = [early(t) if t <= SERIES_TO else lines(t) for t in TIMES]
    out: dict[str, Any] = {
        "series_and_integrals_apart": float(apart),
        "monoenergetic": {"square": [], "fourth": []},
        "gaussian": {"square": [], "fourth": []},
    }
    # at the shortest times the integrals lose digits: the series in <v^p> does not
    many = [gaussian_series(early, t) if t < 0.03 else averaged(t) for t in TIMES]
    for name, pairs in (("monoenergetic", one), ("gaussian", many)):
        for which, key in enumerate(("square", "fourth")):
            out[name][key] = [float(pair[which]) for pair in pairs]
    return out


def gaussian_series(early: Early, t: float) -> tuple[Any, Any]:
    """The same for the Gaussian start at small t/l: <u^k> = 2^(k/2) Gamma(1 + k/2) term by term.

    That series converges for every t, but its terms only fall beyond k = t^2.
    """
    x = mp.mpf(t)
    out = []
    for terms in (early.square_terms, early.fourth_terms):
        moments = [2 ** (mp.mpf(k) / 2) * mp.gamma(1 + mp.mpf(k) / 2) for k in range(len(terms))]
        pairs = zip(terms, moments, strict=True)
        out.append(mp.fsum(c * x**k * m for k, (c, m) in enumerate(pairs)))
    return out[0], out[1]


def make() -> dict[str, Any]:
    """All of position_references.json."""
    out: dict[str, Any] = {"T": TIMES}
    for e in RESTITUTIONS:
        out[str(e)] = table(e)
        print(e, out[str(e)]["series_and_integrals_apart"], flush=True)
    return out


if __name__ == "__main__":
    mp.mp.dps = 40
    path = Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(make(), indent=1) + "\n", encoding="utf-8")

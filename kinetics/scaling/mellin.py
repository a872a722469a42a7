r"""Moments E[Y^z] of the scaling state for any z, its density, and how many collisions led there.

The logarithm of A(z) = kappa^z E[Y^z] obeys ln A(z+1) = ln A(z) + rho(z) with
rho(z) = ln(kappa z/lambda(z)), and is the principal solution of that recurrence
(:mod:`kinetics.numerics.recurrence`), A(0) = A(1) = 1. The density of x = ln(kappa Y) follows by
Mellin inversion along vertical lines through its saddle points, so that its error is relative to
itself in both tails.

How many collisions a cooling tracer has had, and how far it has flown: with phi(p) = E[s^p], from
v = 1 and l = 1, d/dt E[z^N v^p] = -(1 - z phi(p)) E[z^N v^(p+1)], and E[z^N(t)] = sum_k (-t)^k/k!
c(k), c the principal solution of c(p+1) = (1 - z phi(p)) c(p), c(0) = 1. This is the Mellin
transform Gamma(p) c(-p), whose first pole on the right is at -p = theta, phi(theta) = 1/z: hence
C t^theta, C = Gamma(-theta) c(1 + theta)/(-z phi'(theta)). E[exp(-q X)] of the path X is the same
with z = 1/(1 + q).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import (
    FOLDS,
    LARGEST_LOG,
    ROUNDING,
    ComplexArray,
    FloatArray,
    one_blas_thread,
)
from kinetics.numerics.gauss import gauss_legendre, panels_between
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

# The Euler-Maclaurin formula is used where Re z >= _START, or as far from the zeros of lambda: with
# 12 Taylor coefficients it leaves 2 * 12!/((2 pi)^14 16^13) = 1e-18.
_START = 16
# Of a line, in deviations: how far from its centre it serves, and half of the way to the next one;
# it loses e^(1.6^2/2) = 4 at most, between lines of different deviations.
_SERVES = 1.25
_SERVES_MORE = 2.4  # where a bounce costs less than a deviation: nearly Gaussian, loses 18
# Below e^-5 of the speed after a bounce, the tilted density changes between two such lines: closer.
_RARELY_LOST, _CLOSE = 5.0, 0.4
_LEAST = 0.02  # share of its terms that a sum must have: two digits are lost there
# Where g is a power of speed low down, lines closer to the lowest power would need ever more
# samples; the lowest line loses e^(0.25 |x|), 2e4 at v t = 1e-17 l.
_LOWEST_LINE = 0.25


def log_second_moment(law: CollisionLaw) -> float:
    """ln A(2) = ln(kappa/lambda(1)) < ln 2: nearly the variance of x where that is small."""
    if law.energy_loss < math.sqrt(ROUNDING):
        # kappa - lambda(1) = E[xi^2]/2 + what returns add, xi = -ln s: else only rounding is left
        q, kappa = law.quadrature, law.mean_log_loss
        return float(q.weight @ q.log_loss**2) / (2.0 * kappa) + law.returns(0)[0] * kappa
    return math.log(law.mean_log_loss / float(law.decay_rate(1.0)))


# -- the principal solution of ln A(z+1) - ln A(z) = rho(z) ----------------------------------------


def _rho(law: CollisionLaw, z: NDArray[Any]) -> NDArray[Any]:
    """ln(kappa z/lambda(z)); 0 at z = 0."""
    zero = np.abs(z) < 1e-290  # kappa z would underflow
    safe = np.where(zero, 1.0, z)
    ratio = law.mean_log_loss * safe / law.decay_rate(safe)
    return np.asarray(np.where(zero, 0.0, np.log(ratio)))


def _taylor_of_rho(
    law: CollisionLaw, z: NDArray[Any], rate: list[NDArray[Any]]
) -> list[NDArray[Any]]:
    """Taylor coefficients of rho at z (n,), up to order 11; rate: those of lambda."""
    p, orders = law.uniform_power, range(1, MOST_ORDERS)
    if p:
        return [np.log1p(z / p), *(-((-1.0 / (p + z)) ** n) / n for n in orders)]
    of_rate = taylor_of_log([c / rate[0] for c in rate])  # lambda < 0 for z < 0
    powers = np.cumprod(np.broadcast_to(-1.0 / z, (MOST_ORDERS - 1, z.size)), axis=0)
    rest = [-power / n - of_rate[n] for n, power in zip(orders, powers, strict=True)]
    return [np.log(law.mean_log_loss * z / rate[0]), *rest]


def log_moment(law: CollisionLaw, z: FloatArray) -> FloatArray:
    """ln A(z), z real, of shape (n,)."""
    low = z < -_START
    if np.any(low) and not np.all(low):
        out = np.empty(z.shape)
        out[low], out[~low] = log_moment(law, z[low]), log_moment(law, z[~low])
        return out
    n = _shift(law, float(z.min()))
    # the recurrence leads from 0 up to n, and down to z from z + n
    both = np.append(0.0, z)
    steps = _rho(law, both[:, None] + np.arange(n)).sum(axis=1)
    ends = _taylor_of_rho(law, both + n, law.decay_taylor(both + n, MOST_ORDERS))
    integral = _integrals(partial(_rho, law), law, float(n), z + n)
    grown = log_growth(integral, [c[:1] for c in ends], [c[1:] for c in ends])
    return np.asarray(steps[0] + grown - steps[1:])


def _shift(law: CollisionLaw, a: float, height: float = 0.0) -> int:
    """How many steps of the recurrence lead from Re z = a to where rho is smooth."""
    far = law.largest_loss < math.log(2.0) and a - law.lowest_power > 2.0 * _START
    if a < -_START and far and 2.0 * math.pi / law.largest_loss - height > _START + 1.0:
        return 1
    return max(_START, math.ceil(_START - a))


def _growth_on_line(law: CollisionLaw, begin: complex, step: float, count: int) -> ComplexArray:
    """ln of A(begin + i n step)/A(begin), n = 0 ... count - 1."""
    z = begin + 1j * step * np.arange(count)
    shift = _shift(law, begin.real, float(z[-1].imag))
    node, weight = gauss_legendre(10)
    offsets = np.concatenate([np.arange(shift), shift + 1j * step * node, [shift]])
    rates, taylor = law.decay_rates(z, offsets, MOST_ORDERS)
    rho = np.log(law.mean_log_loss * (z[1:, None] + offsets) / rates[1:])
    # at the beginning itself, sums of powers might lose their digits next to z = 0
    rho = np.concatenate([_rho(law, begin + offsets)[None], rho])
    path = np.append(0.0, 1j * step * np.cumsum(rho[:-1, shift:-1] @ weight))
    end = _taylor_of_rho(law, z + shift, taylor)
    below = rho[:, :shift].sum(axis=1)
    return np.asarray(log_growth(path, [c[0] for c in end], end) - below + below[0])


def _integrals(
    log_ratio: Callable[[FloatArray], FloatArray], law: CollisionLaw, low: float, high: FloatArray
) -> FloatArray:
    """Of ln r from low to each of high (n,) on the real axis, where it is smooth."""
    # ln r is analytic within about _START of the path, or 2 pi over the largest loss if that is
    # further and the lowest power as well: 12 Gauss points for half of it leave less than rounding
    first, last = min(low, float(high.min())), max(low, float(high.max()))
    edges = [first]
    while edges[-1] < last:
        unit = max(_START, min(2.0 / law.largest_loss, edges[-1] - law.lowest_power))
        edges.append(min(edges[-1] + 0.5 * unit, last))
    ends = np.unique(np.concatenate([edges, [low], high]))
    nodes, weights = panels_between(ends, 12)
    sums = np.cumsum(np.append(0.0, (weights * log_ratio(nodes)).reshape(-1, 12).sum(axis=1)))
    return np.asarray(sums[np.searchsorted(ends, high)] - sums[np.searchsorted(ends, low)])


# -- Mellin inversion through the saddle -----------------------------------------------------------


class Line(NamedTuple):
    """One Mellin line Re z = exponent: A(z)/A(exponent) at exponent + i n step.

    centre, deviation : mean and standard deviation of x under the density e^(exponent x) g(x)
    reach : how far from its centre it serves
    """

    exponent: float
    centre: float
    deviation: float
    reach: float
    step: float
    log_moment: float
    samples: ComplexArray


def log_density(law: CollisionLaw, x: FloatArray, lines: list[Line]) -> FloatArray:
    """ln of the density g of x = ln(kappa Y), shape (n,); -inf where F ~ g/c^d is 0.

    NaN where a medium makes g unknown: at speeds that only powers below the lowest one resolve.
    lines : those made for this law so far, by their exponents; new ones are added
    """
    if x.size == 0:
        return np.zeros(0)
    if not lines or not lines[0].centre < float(x.min()) <= float(x.max()) < lines[-1].centre:
        _extend(law, float(x.min()), float(x.max()), lines)
    centre, deviation = (np.array([line[n] for line in lines]) for n in (1, 2))
    # where two neighbours are as many deviations off
    between = centre[:-1] * deviation[1:] + centre[1:] * deviation[:-1]
    serving = np.searchsorted(between / (deviation[:-1] + deviation[1:]), x)
    out = np.full(x.shape, -math.inf)
    for i, line in enumerate(lines):
        n = line.step * np.arange(line.samples.size)
        turn = np.exp(-1j * np.outer(x[serving == i] - line.centre, n))
        # the phase of the centre is taken out of the samples: no large arguments. Without BLAS,
        # whose threads would wait for each other
        rotated = line.samples * np.exp(-1j * n * line.centre)
        total = 2.0 * np.einsum("ij,j", turn, rotated).real - 1.0
        if i + 1 < len(lines):
            # near e = 0 little may be left of the tilted density above its centre
            lost = total < _LEAST * (2.0 * np.abs(line.samples).sum() - 1.0)
            lost &= x[serving == i] > line.centre
            serving[np.nonzero(serving == i)[0][lost]] = i + 1
            total = total[~lost]
        mine, total = serving == i, total * line.step / (2.0 * math.pi)
        out[mine] = np.log(np.maximum(total, 1e-300)) + line.log_moment - line.exponent * x[mine]
    out[x > centre[-1] + lines[-1].reach] = -math.inf
    if not law.reaches_rest:
        unknown = math.isfinite(law.lowest_power)
        out[x < centre[0] - 2.0 * _SERVES * deviation[0]] = math.nan if unknown else -math.inf
    return out


@one_blas_thread
def _extend(law: CollisionLaw, lowest: float, highest: float, lines: list[Line]) -> None:
    """Make lines from the bulk (x near 0) outwards, until both x are served or F is 0 there."""
    if not lines:
        lines.append(_line(law, 0.0, math.sqrt(log_second_moment(law)), 32))

    def something(line: Line) -> bool:  # Chernoff: ln g(x) <= ln A(a) - a x
        log_f = line.log_moment - (line.exponent + law.dimension) * line.centre
        return log_f > -LARGEST_LOG - FOLDS

    def beside(end: Line, step: float) -> Line:
        return _line(law, end.exponent + step, end.deviation, end.samples.size)

    while (end := lines[-1]).centre + end.reach < highest and something(end):
        lines.append(beside(end, 2.0 * end.reach / end.deviation**2))
    while (end := lines[0]).centre - end.reach > lowest and something(end):
        step = 2.0 * end.reach / end.deviation**2
        if law.largest_loss > _RARELY_LOST:
            step = min(step, _CLOSE)
        step = min(step, end.exponent - law.lowest_power - _LOWEST_LINE)
        if step <= 0.0:
            break
        lines.insert(0, beside(end, -step))


def _line(law: CollisionLaw, a: float, scale: float, count: int) -> Line:
    """A on the line Re z = a, in steps that resolve the tilted density, until it is negligible.

    scale, count : about its deviation, and how many samples it takes
    """
    # E[s^p] overflows below p = -700/(-ln e): bounds from there are not needed
    deepest = min(600.0 / float(law.quadrature.log_loss.max()), -law.lowest_power)
    small = 0.2 * min(1.0 / scale, a - law.lowest_power)  # for differences
    steps = np.array([0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0]) / scale
    down = np.append(steps, 2.5 * small)
    down = down[down - a < deepest]
    found = log_moment(law, np.concatenate([[a, a + small, a - small], a + steps, a - down]))
    log_a, (more, less) = float(found[0]), found[1:3] - found[0]
    mean, deviation = float(more - less) / (2.0 * small), math.sqrt(more + less) / small
    # Chernoff: where the tilted density is negligible on either side
    above, below = np.split(found[3:] - log_a, [steps.size])
    right = float(np.min((above + FOLDS) / steps))
    left = float(np.max(-(below + FOLDS) / down))
    step, samples = 2.0 * math.pi / (right - left), np.ones(1, dtype=complex)
    while np.max(np.abs(samples[-4:])) >= math.exp(-FOLDS):
        begin = a + 1j * step * (samples.size - 1)
        more = np.exp(_growth_on_line(law, begin, step, count + 1)[1:])
        samples = np.append(samples, samples[-1] * more)
        count = max(32, samples.size // 2)
    needed = max(32, 5 + int(np.flatnonzero(np.abs(samples) >= math.exp(-FOLDS))[-1]))
    reach = deviation * (_SERVES_MORE if law.largest_loss < deviation else _SERVES)
    return Line(a, mean, deviation, reach, step, log_a, samples[:needed])


def small_deviation(law: CollisionLaw) -> float:
    """The root of E[xi^2]/(2 kappa): the deviation of x = ln(kappa v t/l) where that is small."""
    q = law.quadrature
    return math.sqrt(float(q.weight @ q.log_loss**2) / (2.0 * law.mean_log_loss))


@lru_cache(maxsize=4)  # all harmonics of a scene ask for the same
def extent_of(law: CollisionLaw, depth: float) -> tuple[float, float]:
    """ln(v t/l) above which the scaling state weighs e^-depth; the wave number at which the
    transform of its density, A(i k), is that small.
    """
    deviation = small_deviation(law)
    p = np.geomspace(0.3, 60.0, 24) / deviation
    # Chernoff's bound; a density of x falls as e^-(e^x): its own factor e^x is e^5 at most
    right = float(np.min((log_moment(law, p) + depth + 5.0) / p))
    step, count = 0.5 / deviation, 32
    while (size := _growth_on_line(law, 0.0, step, count).real)[-1] > -depth and count < 1000:
        count *= 2
    return right - math.log(law.mean_log_loss), step * float(np.count_nonzero(size > -depth))


# -- collisions and path at late times -------------------------------------------------------------

_LARGEST_POWER = 1000.0  # |theta|


def power_of(law: CollisionLaw, z: float) -> float | None:
    """theta with phi(theta) = 1/z; None beyond +-1000, and where phi is 1/z nowhere."""
    from scipy.optimize import brentq

    share = (z - 1.0) / z  # lambda(theta)

    def missed(p: float) -> float:
        return float(law.decay_rate(p)) - share

    deepest = float(law.quadrature.log_loss.max())
    lowest = max(-_LARGEST_POWER, (FOLDS - LARGEST_LOG) / deepest, law.lowest_power * (1.0 - 1e-12))
    low, high = (lowest, 0.0) if z < 1.0 else (0.0, 1.0)
    while z > 1.0 and missed(high) < 0.0 and high < _LARGEST_POWER:
        low, high = high, min(2.0 * high, _LARGEST_POWER)
    if missed(low) > 0.0 or missed(high) < 0.0:
        return None
    return float(brentq(missed, low, high, xtol=1e-300, rtol=1e-15, maxiter=500))


def log_amplitude(law: CollisionLaw, z: float, theta: float) -> float:
    """ln C; every factor is positive: the poles of Gamma(-theta) cancel with zeros of 1 - z phi."""
    n = math.ceil(_START + max(theta, 0.0))
    j = np.arange(float(n))
    rate = law.decay_rate(np.append(j, theta))
    near = np.abs(j - theta) < 0.05  # where the difference of phi is summed, not subtracted
    apart = np.where(near, 1.0, j - theta)
    slope = (rate[:-1] - rate[-1]) / apart  # (phi(theta) - phi(j))/(j - theta)
    if np.any(near):
        q = law.quadrature_for(n)
        step = float((j - theta)[near][0])
        ratio = -np.expm1(-step * q.log_loss) / step if step else q.log_loss
        slope[near] = (q.weight * np.exp(-theta * q.log_loss)) @ ratio
    numerator = np.log(z * slope).sum() + math.lgamma(n - theta)
    denominator = _log_left(law, z, j + 1.0 + theta).sum()
    top = np.array([n + 1.0 + theta])
    integral = _integrals(partial(_log_left, law, z), law, float(n), top)
    begin, end = (  # Taylor coefficients of ln(1 - z phi)
        taylor_of_log([(1.0 - z) + z * first, *(z * c for c in rest)])
        for first, *rest in (law.decay_taylor(p, MOST_ORDERS) for p in (np.array([float(n)]), top))
    )
    far = float(log_growth(integral, begin, end)[0])
    # the derivative along the imaginary axis, without cancellation: -phi'(theta) = lambda'(theta)
    falling = float(law.decay_symbol(np.array([theta + 1e-20j]))[0].imag) / 1e-20
    return float(numerator - denominator + far - math.log(z * falling))


def _log_left(law: CollisionLaw, z: float, p: FloatArray) -> FloatArray:
    """ln(1 - z phi(p))."""
    return np.asarray(np.log((1.0 - z) + z * law.decay_rate(p)))


def cumulants(law: CollisionLaw, n: int, of_path: bool) -> FloatArray:
    """The first n cumulants of N, or of X in l, per ln t, shape (n,).

    E[exp(u N)] ~ t^theta with -ln(1 - lambda(theta)) = u; E[exp(u X)] with lambda(theta) = u. The
    series of theta in u is Lagrange's reversion, and its coefficients times k! are the cumulants.
    """
    c = _taylor_at_zero(law, n + 1)
    if not of_path:
        c = [-one for one in taylor_of_log([np.ones(1), *(-one for one in c[1:])])]
    f = np.array([float(one[0]) for one in c[1:]])  # u/theta
    inverse = np.zeros(n)
    inverse[0] = 1.0 / f[0]
    for k in range(1, n):
        inverse[k] = -(f[1 : k + 1] @ inverse[k - 1 :: -1]) / f[0]
    power, out = np.eye(1, n)[0], np.zeros(n)
    for k in range(1, n + 1):
        power = np.convolve(power, inverse)[:n]
        out[k - 1] = math.factorial(k - 1) * power[k - 1]
    return out


def _taylor_at_zero(law: CollisionLaw, orders: int) -> list[NDArray[Any]]:
    """Taylor coefficients of lambda at 0, from order 0 to orders - 1, each (1,)."""
    if q := law.uniform_power:  # lambda = z/(z + q)
        return [np.array([-((-1.0 / q) ** k) if k else 0.0]) for k in range(orders)]
    if not law.reaches_rest:
        return law.decay_taylor(np.zeros(1), orders)
    # high powers of ln s see bounces beyond all points: from a circle, which encloses no pole
    turn = np.exp(2j * math.pi * np.arange(64) / 64)
    found = np.fft.fft(law.decay_symbol(-0.5 * law.lowest_power * turn)).real / 64
    return [np.array([found[k] / (-0.5 * law.lowest_power) ** k]) for k in range(orders)]

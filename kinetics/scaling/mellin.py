r"""Moments E[Y^z] of the scaling state for any z, and its density by Mellin inversion.

The logarithm of A(z) = kappa^z E[Y^z] obeys ln A(z+1) = ln A(z) + rho(z) with
rho(z) = ln(kappa z/lambda(z)), and is the principal solution of that recurrence
(:mod:`kinetics.numerics.recurrence`), A(0) = A(1) = 1. The density of x = ln(kappa Y) follows by
Mellin inversion along vertical lines through its saddle points, so that its error is relative to
itself in both tails.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import ComplexArray, FloatArray, one_blas_thread
from kinetics.numerics.gauss import gauss_legendre, panels_between
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

# The Euler-Maclaurin formula is used where Re z >= _START, or as far from the zeros of lambda: with
# 12 Taylor coefficients it leaves 2 * 12!/((2 pi)^14 16^13) = 1e-18.
_START = 16
_NEGLIGIBLE = 39.0  # e^-39 = 1e-17: what is left out at the ends of a line and of its period
# Of a line, in deviations: how far from its centre it serves at the ends, and beside others, where
# it loses e^(1.6^2/2) = 4 at most; and the next line is where the centre moves by so many.
_REACH, _SERVED, _APART = 2.0, 1.5, 2.5
_NOTHING = -800.0  # ln F below which F is 0
# Below e^-5 of the speed after a bounce, the tilted density changes between two such lines: closer.
_RARELY_LOST, _CLOSE = 5.0, 0.4
_LEAST = 0.02  # share of its terms that a sum must have: two digits are lost there
_DIFFERENCE = 0.2  # over the deviation, for derivatives of ln A that place lines
# Where g is a power of speed low down, lines closer to the lowest power would need ever more
# samples; the lowest line loses e^(0.25 |x|), 2e4 at v t = 1e-17 l.
_LOWEST_LINE = 0.25
_NEARLY_ELASTIC = 1e-8  # share of energy lost
_MOST_SAMPLES = 2000  # of a line: never reached
_OWN_FACTOR = 5.0  # e-folds


def log_second_moment(law: CollisionLaw) -> float:
    """ln A(2) = ln(kappa/lambda(1)) < ln 2: nearly the variance of x where that is small."""
    if law.energy_loss < _NEARLY_ELASTIC:
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


def _taylor_of_rho(law: CollisionLaw, z: NDArray[Any]) -> list[NDArray[Any]]:
    """Taylor coefficients of rho at z (n,), up to order 11."""
    p, orders = law.uniform_power, range(1, MOST_ORDERS)
    if p:
        return [np.log1p(z / p), *(-((-1.0 / (p + z)) ** n) / n for n in orders)]
    rate = law.decay_taylor(z, MOST_ORDERS)
    of_rate = taylor_of_log([c / rate[0] for c in rate])  # lambda < 0 for z < 0
    rest = [-((-1.0 / z) ** n) / n - of_rate[n] for n in orders]
    return [np.log(law.mean_log_loss * z / rate[0]), *rest]


def log_moment(law: CollisionLaw, z: FloatArray) -> FloatArray:
    """ln A(z), z real, of shape (n,)."""
    low = z < -_START
    if np.any(low) and not np.all(low):
        out = np.empty(z.shape)
        out[low], out[~low] = log_moment(law, z[low]), log_moment(law, z[~low])
        return out
    shift = _shift(law, float(z.min()))
    below = _rho(law, z[:, None] + np.arange(shift)).sum(axis=1)
    integral = np.array([_integral(law, float(shift), float(t)) for t in z + shift])
    return np.asarray(_from(law, shift, integral, z + shift) - below)


def _shift(law: CollisionLaw, a: float, height: float = 0.0) -> int:
    """How many steps of the recurrence lead from Re z = a to where rho is smooth."""
    far = law.largest_loss < math.log(2.0) and a - law.lowest_power > 2.0 * _START
    if a < -_START and far and 2.0 * math.pi / law.largest_loss - height > _START + 1.0:
        return 1
    return max(_START, math.ceil(_START - a))


def _from(law: CollisionLaw, n: int, integral: NDArray[Any], top: NDArray[Any]) -> NDArray[Any]:
    """ln A at ``top`` (n,), from the integral of rho from n up to there, by Euler-Maclaurin."""
    known = _rho(law, np.arange(1.0, n)).sum()  # ln A(n)
    begin = _taylor_of_rho(law, np.array([float(n)]))
    return np.asarray(known + log_growth(integral, begin, _taylor_of_rho(law, top)))


def _log_moment_on_line(law: CollisionLaw, a: float, step: float, count: int) -> ComplexArray:
    """ln A(a + i n step), n = 0 ... count - 1."""
    z = a + 1j * step * np.arange(count)
    shift = _shift(law, a, step * count)
    node, weight = gauss_legendre(10)
    offsets = np.concatenate([np.arange(shift), shift + 1j * step * node])
    at = z[:, None] + offsets
    rate = np.where(at == 0.0, 1.0, law.decay_rates(z, offsets))
    rho = np.log(np.where(at == 0.0, 1.0, law.mean_log_loss * at / rate))
    path = np.full(count, complex(_integral(law, float(shift), a + shift)))
    path[1:] = path[0] + 1j * step * np.cumsum(rho[:-1, shift:] @ weight)
    return np.asarray(_from(law, shift, path, z + shift) - rho[:, :shift].sum(axis=1))


def _integral(law: CollisionLaw, low: float, high: float) -> float:
    """Integral of rho from low to high on the real axis, where it is smooth."""
    # rho is analytic within about _START of the path, or 2 pi over the largest loss if that is
    # further and the lowest power as well: 24 Gauss points for a panel that is no longer leave less
    # than rounding
    edges = [min(low, high)]
    while len(edges) == 1 or edges[-1] < max(low, high):
        unit = max(_START, min(2.0 / law.largest_loss, edges[-1] - law.lowest_power))
        edges.append(min(edges[-1] + unit, max(low, high)))
    nodes, weights = panels_between(np.array(edges), 24)
    return math.copysign(1.0, high - low) * float(_rho(law, nodes) @ weights)


# -- Mellin inversion through the saddle -----------------------------------------------------------


class Line(NamedTuple):
    """One Mellin line Re z = exponent: A(z)/A(exponent) at exponent + i n step.

    centre, deviation : mean and standard deviation of x under the density e^(exponent x) g(x)
    """

    exponent: float
    centre: float
    deviation: float
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
        total = _sum(line, x[serving == i])
        if i + 1 < len(lines):
            # near e = 0 little may be left of the tilted density above its centre
            lost = total < _LEAST * (2.0 * np.abs(line.samples).sum() - 1.0)
            lost &= x[serving == i] > line.centre
            serving[np.nonzero(serving == i)[0][lost]] = i + 1
            total = total[~lost]
        mine, total = serving == i, total * line.step / (2.0 * math.pi)
        out[mine] = np.log(np.maximum(total, 1e-300)) + line.log_moment - line.exponent * x[mine]
    out[x > centre[-1] + _REACH * deviation[-1]] = -math.inf
    if not law.reaches_rest:
        unknown = math.isfinite(law.lowest_power)
        out[x < centre[0] - _REACH * deviation[0]] = math.nan if unknown else -math.inf
    return out


@one_blas_thread
def _extend(law: CollisionLaw, lowest: float, highest: float, lines: list[Line]) -> None:
    """Make lines from the bulk (x near 0) outwards, until both x are served or F is 0 there."""
    if not lines:
        lines.append(_line(law, 0.0, math.sqrt(log_second_moment(law))))

    def something(line: Line) -> bool:  # Chernoff: ln g(x) <= ln A(a) - a x
        return line.log_moment - (line.exponent + law.dimension) * line.centre > _NOTHING

    while (end := lines[-1]).centre + _SERVED * end.deviation < highest and something(end):
        lines.append(_line(law, end.exponent + _APART / end.deviation, end.deviation))
    while (end := lines[0]).centre - _SERVED * end.deviation > lowest and something(end):
        step = _APART / end.deviation
        if law.largest_loss > _RARELY_LOST:
            step = min(step, _CLOSE)
        exponent = max(end.exponent - step, law.lowest_power + _LOWEST_LINE)
        if exponent == end.exponent:
            break
        lines.insert(0, _line(law, exponent, end.deviation))


def _sum(line: Line, x: FloatArray) -> FloatArray:
    """The tilted density at x, shape (n,), as the sum over the samples of a line."""
    n = np.arange(line.samples.size)
    turn = np.exp(-1j * np.outer(x - line.centre, n * line.step))
    # the phase of the centre is taken out of the samples: no large arguments. Without BLAS, whose
    # threads would wait for each other
    rotated = line.samples * np.exp(-1j * n * line.step * line.centre)
    return np.asarray(2.0 * np.einsum("ij,j", turn, rotated).real - 1.0)


def _line(law: CollisionLaw, a: float, scale: float) -> Line:
    """A on the line Re z = a, in steps that resolve the tilted density, until it is negligible."""
    # E[s^p] overflows below p = -700/(-ln e): bounds from there are not needed
    deepest = min(600.0 / float(law.quadrature.log_loss.max()), -law.lowest_power)
    small = min(_DIFFERENCE / scale, _DIFFERENCE * (a - law.lowest_power))
    steps = np.array([0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0]) / scale
    down = np.append(steps, 0.5 * min(0.2 / scale, a - law.lowest_power))
    down = down[down - a < deepest]
    found = log_moment(law, np.concatenate([[a, a + small, a - small], a + steps, a - down]))
    log_a, (more, less) = float(found[0]), found[1:3] - found[0]
    mean, variance = float(more - less) / (2.0 * small), float(more + less) / small**2
    # Chernoff: where the tilted density is negligible on either side
    above, below = np.split(found[3:] - log_a, [steps.size])
    right = float(np.min((above + _NEGLIGIBLE) / steps))
    left = float(np.max(-(below + _NEGLIGIBLE) / down))
    step = 2.0 * math.pi / (right - left)
    samples = [np.ones(1, dtype=complex)]
    count = 1
    while np.max(np.abs(samples[-1][-4:])) >= math.exp(-_NEGLIGIBLE) and count <= _MOST_SAMPLES:
        block = max(32, count)
        samples.append(np.exp(_log_moment_on_line(law, a, step, count + block)[count:] - log_a))
        count += block
    return Line(a, mean, math.sqrt(variance), step, log_a, np.concatenate(samples))


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
    # Chernoff's bound; a density of x falls as e^-(e^x), and its own factor e^x is allowed for
    right = float(np.min((log_moment(law, p) + depth + _OWN_FACTOR) / p))
    step, count = 0.5 / deviation, 32
    while (size := _log_moment_on_line(law, 0.0, step, count).real)[-1] > -depth and count < 1000:
        count *= 2
    return right - math.log(law.mean_log_loss), step * float(np.count_nonzero(size > -depth))

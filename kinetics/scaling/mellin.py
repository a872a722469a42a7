r"""Moments E[Y^z] of the scaling state for any z, and its density by Mellin inversion.

The logarithm of A(z) = kappa^z E[Y^z] obeys ln A(z+1) = ln A(z) + rho(z) with
rho(z) = ln(kappa z/lambda(z)), and is the principal solution of that recurrence
(:mod:`kinetics.numerics.recurrence`), A(0) = A(1) = 1. The density of x = ln(kappa Y) follows by
Mellin inversion along vertical lines through its saddle points, so that its error is relative to
itself in both tails.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import ComplexArray, FloatArray
from kinetics.numerics.gauss import equal_panels, panels_of
from kinetics.numerics.recurrence import MOST_ORDERS, log_growth, taylor_of_log

# The Euler-Maclaurin formula is used where Re z >= _START, or as far from the zeros of lambda: with
# 12 Taylor coefficients it leaves 2 * 12!/((2 pi)^14 16^13) = 1e-18.
_START = 16
_NEGLIGIBLE = 39.0  # e^-39 = 1e-17: what is left out at the ends of a line and of its period
_REACH = 2.0  # deviations from its centre up to which a line serves: it loses e^(2^2/2) = 7 there
_NOTHING = -800.0  # ln F below which F is 0
_LEAST = 0.01  # share of its terms that a sum must have: two digits are lost there
_NEAR = 0.3  # deviations between the centre of a line and the x it is made for: changes no result
_DIFFERENCE = 0.2  # deviations, for derivatives of ln A that choose the line: changes no result
# Where g is a power of speed low down, lines closer to the lowest power would need ever more
# samples; the lowest line loses e^(0.25 |x|), 2e4 at v t = 1e-17 l.
_LOWEST_LINE = 0.25
_NEARLY_ELASTIC = 1e-8  # share of energy lost
_MOST_SAMPLES = 2000  # of a line: never reached


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
    orders = range(1, MOST_ORDERS)
    p = law.uniform_power
    if p:
        return [np.log1p(z / p), *(-((-1.0 / (p + z)) ** n) / n for n in orders)]
    rate = law.decay_taylor(z, MOST_ORDERS)
    of_rate = taylor_of_log([c / rate[0] for c in rate])  # lambda < 0 for z < 0
    rest = [-((-1.0 / z) ** n) / n - of_rate[n] for n in orders]
    return [np.log(law.mean_log_loss * z / rate[0]), *rest]


def log_moment(law: CollisionLaw, z: NDArray[Any], path_from: float | None = None) -> NDArray[Any]:
    """ln A(z), z of shape (n,), real or complex.

    Complex z must lie on one vertical line in rising order of Im z; the path of integration
    then runs up that line from Re z = path_from.
    """
    shift = max(_START, math.ceil(_START - float(np.min(z.real))))
    low = z.real < -_START
    if np.any(low) and _far_from_zeros(law, float(np.max(np.abs(z.imag)))):
        if not np.all(low):
            out = np.empty(z.shape, dtype=z.dtype)
            out[low], out[~low] = log_moment(law, z[low]), log_moment(law, z[~low])
            return out
        shift = 1
    below = _rho(law, z[:, None] + np.arange(shift)).sum(axis=1)
    known = _rho(law, np.arange(1.0, shift)).sum()  # ln A(shift)
    top, base = z + shift, np.array([float(shift)])
    if path_from is None:
        integral = np.array([_integral(law, float(shift), float(t)) for t in top])
    else:
        heights = np.concatenate([[0.0], z.imag])
        y, weight = panels_of(np.stack([heights[:-1], heights[1:]], axis=1), 10)
        pieces = 1j * (_rho(law, path_from + shift + 1j * y) * weight).sum(axis=1)
        integral = _integral(law, float(shift), path_from + shift) + np.cumsum(pieces)
    growth = log_growth(integral, _taylor_of_rho(law, base), _taylor_of_rho(law, top))
    return np.asarray(known + growth - below)


def _far_from_zeros(law: CollisionLaw, height: float) -> bool:
    """Whether rho is as smooth at |Im z| <= height as it is beyond _START in general.

    Near e = 1 it is: at the zeros of lambda all bounces turn s^z once round at least.
    """
    if not law.largest_loss < math.log(2.0) or math.isfinite(law.lowest_power):
        return False
    return 2.0 * math.pi / law.largest_loss - height > _START + 1.0


def _integral(law: CollisionLaw, low: float, high: float) -> float:
    """Integral of rho from low to high on the real axis, where it is smooth."""
    # rho is analytic within about _START of the path, or 2 pi over the largest loss if that is
    # further: 24 Gauss points for a panel that is no longer leave less than rounding
    unit = max(float(_START), min(2.0 / law.largest_loss, _START - law.lowest_power))
    signed = math.copysign(unit, high - low)
    nodes, weights = equal_panels(abs(high - low) / unit, 24)
    return float(_rho(law, low + signed * nodes) @ weights) * signed


def log_growth_constant(law: CollisionLaw, b: float) -> float:
    """ln of the limit of E[Y^p]/Gamma(p+b) for large p, b the law's tail exponent, to 1e-10.

    E[Y^(p+1)]/Gamma(p+1+b) exceeds E[Y^p]/Gamma(p+b) by the factor (p/(p+b))/lambda(p): a sum of
    its logarithm over the integers, by the Euler-Maclaurin formula from n on.
    """

    def excess(p: FloatArray) -> FloatArray:
        return np.asarray(-np.log(law.decay_rate(p)) - np.log1p(b / p))

    n = 24.0
    head = float(excess(np.arange(1.0, n)).sum())
    # the integral in u = n/p up to p = last, and beyond from three terms of the series in 1/p
    last = 2000.0 * max(b, 1.0)
    u, w = equal_panels(1.0 - n / last, 40, 0.25)
    u = u + n / last
    integral = float((excess(n / u) * n / u**2) @ w)
    at = last * np.array([1.0, 1.5, 2.0])
    terms = np.linalg.solve(at[:, None] ** -np.array([2.0, 3.0, 4.0]), excess(at))
    integral += float(terms @ (last ** -np.array([1.0, 2.0, 3.0]) / np.array([1.0, 2.0, 3.0])))
    # Taylor coefficients at n: of rho, less those of ln(p + b); far out they vanish
    begin = [c[0] for c in _taylor_of_rho(law, np.array([n]))]
    for order in range(1, len(begin)):
        begin[order] += (-1.0 / (n + b)) ** order / order
    begin[0] -= math.log(law.mean_log_loss * (n + b))
    end = [np.zeros(())] * len(begin)
    tail = float(log_growth(np.asarray(integral), begin, end))
    return -math.log(law.mean_log_loss) - math.lgamma(1.0 + b) + head + tail


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
    lines : those made for this law so far; new ones are added
    """
    out = np.full(x.shape, -math.inf)
    todo = np.ones(x.shape, dtype=bool)
    # from the bulk (x near 0) outwards, and no further on a side once F is 0
    while np.any(todo):
        nearest = int(np.argmin(np.where(todo, np.abs(x), math.inf)))
        line = _known(lines, float(x[nearest]))
        if line is None:
            line = _line_at(law, float(x[nearest]))
            lines += [line] if line is not None else []
        beyond = (x >= x[nearest]) if x[nearest] > 0.0 else (x <= x[nearest])
        if line is None:
            todo &= ~beyond
            continue
        near = np.abs(x - line.centre) <= _REACH * line.deviation
        near[near] = _keeps(line, x[near])
        near[nearest] = True
        if line.exponent == law.lowest_power + _LOWEST_LINE:
            below = x < (line.centre if law.reaches_rest else line.centre - _REACH * line.deviation)
            near |= below
        near &= todo
        total = _sum(line, x[near])
        unknown = math.nan if math.isfinite(law.lowest_power) and not law.reaches_rest else 1e-300
        total = np.where(total > 0.0, total, unknown) * line.step / (2.0 * math.pi)
        out[near] = np.log(total) + line.log_moment - line.exponent * x[near]
        if line.exponent == law.lowest_power + _LOWEST_LINE and not law.reaches_rest:
            out[below] = math.nan
        todo &= ~near
        if out[nearest] - law.dimension * x[nearest] < _NOTHING:
            todo &= ~beyond
    return out


def _known(lines: list[Line], x: float) -> Line | None:
    """One of the lines made before that serves x."""
    for line in lines:
        near = abs(x - line.centre) <= _REACH * line.deviation
        if near and _keeps(line, np.array([x]))[0]:
            return line
    return None


def _sum(line: Line, x: FloatArray) -> FloatArray:
    """The tilted density at x, shape (n,), as the sum over the samples of a line."""
    n = np.arange(line.samples.size)
    turn = np.exp(-1j * np.outer(x - line.centre, n * line.step))
    # the phase of the centre is taken out of the samples: no large arguments
    rotated = line.samples * np.exp(-1j * n * line.step * line.centre)
    return np.asarray(2.0 * (turn @ rotated).real - 1.0)


def _keeps(line: Line, x: FloatArray) -> NDArray[np.bool_]:
    """Where the sum over a line is not small beside its terms, so that no digits are lost.

    Near e = 0 the tilted density of a low exponent has a long tail towards rest and a short one the
    other way: two deviations from its centre there may be nothing left of it.
    """
    return np.asarray(_sum(line, x) > _LEAST * (2.0 * np.abs(line.samples).sum() - 1.0))


def _line_at(law: CollisionLaw, x: float) -> Line | None:
    """The line whose tilted density e^(a x) g(x)/A(a) is centred on x; None where F is 0."""
    a, scale = 0.0, math.sqrt(log_second_moment(law))
    log_a, mean, variance = _cumulants(law, a, scale)
    for _ in range(60):
        scale = math.sqrt(variance)
        if abs(mean - x) < _NEAR * scale:
            break
        # Chernoff: ln g(x) is about ln A(a) - a x at most, for every a
        if log_a - (a + law.dimension) * x < _NOTHING:
            return None
        # Newton, but not further than the variance can be trusted
        move = (x - mean) / variance
        before = a
        a += max(-2.0 / scale, min(2.0 / scale, move))
        a = max(a, law.lowest_power + _LOWEST_LINE)
        if a == before:
            break
        log_a, mean, variance = _cumulants(law, a, scale)
    return _sample_line(law, a, (log_a, mean, math.sqrt(variance)))


def _cumulants(law: CollisionLaw, a: float, scale: float) -> tuple[float, float, float]:
    """ln A and its first two derivatives at a, about: by differences."""
    d = _DIFFERENCE / scale
    if math.isfinite(law.lowest_power):
        d = min(d, _DIFFERENCE * (a - law.lowest_power))
    left, mid, right = log_moment(law, np.array([a - d, a, a + d]))
    return float(mid), float(right - left) / (2 * d), float(right - 2 * mid + left) / d**2


def _sample_line(law: CollisionLaw, a: float, cumulants: tuple[float, float, float]) -> Line:
    """A on the line Re z = a, in steps that resolve the tilted density, until it is negligible."""
    log_a, mean, scale = cumulants
    # Chernoff: where the tilted density is negligible on either side
    steps = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 12.0]) / scale
    up = log_moment(law, a + steps) - log_a
    right = float(np.min((up + _NEGLIGIBLE) / steps))
    # E[s^p] overflows below p = -700/(-ln e): bounds from there are not needed
    steps = np.append(steps, [0.1 / scale, min(0.1 / scale, 0.5 * (a - law.lowest_power))])
    steps = steps[steps - a < min(600.0 / float(law.quadrature.log_loss.max()), -law.lowest_power)]
    down = log_moment(law, a - steps) - log_a
    left = float(np.max(-(down + _NEGLIGIBLE) / steps))
    step = 2.0 * math.pi / (right - left)
    samples = [np.ones(1, dtype=complex)]
    count = block = 1
    while np.max(np.abs(samples[-1][-4:])) >= math.exp(-_NEGLIGIBLE) and count <= _MOST_SAMPLES:
        block = max(32, count)
        z = a + 1j * step * np.arange(1, count + block)
        values = np.exp(log_moment(law, z, path_from=a)[count - 1 :] - log_a)
        samples.append(values)
        count += block
    return Line(a, mean, scale, step, log_a, np.concatenate(samples))

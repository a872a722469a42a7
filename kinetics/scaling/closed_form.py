r"""The scaling solution in closed form: the moments, the cooling rate and the scaled VDF.

Multiply the paper's scaled equation (label ``ifmu2``) by c^p and integrate: with Y = v t/l the
scaling state obeys, for every complex z,

    lambda(z) E[Y^(z+1)] = z E[Y^z],        E[Y] = 1/kappa.

E[Y^n] is therefore a finite product. Between the integers the logarithm of A(z) = kappa^z E[Y^z],
which obeys log A(z+1) = log A(z) + rho(z), rho(z) = log(kappa z/lambda(z)), is the principal
solution of that difference equation (Noerlund): the one given by the Euler-Maclaurin formula.
F(c) follows from A by Mellin inversion along lines through the saddle point, so that its relative
accuracy holds in both tails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, check_restitution, short
from kinetics.numerics.gauss import equal_panels
from kinetics.values import Value

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

# Euler-Maclaurin starts at Re z >= _START and uses derivatives up to order 11; the first
# neglected term is below 1e-17 there.
_START = 16
_BERNOULLI = (1 / 12, -1 / 720, 1 / 30240, -1 / 1209600, 1 / 47900160, -691 / 1307674368000)
# exp(-39) = 1e-17: what the periodised tail of an inverted line may weigh.
_NEGLIGIBLE = 39.0
# A line through the saddle serves c within this many standard deviations of its own centre.
_REACH = 2.0
_EXPONENT_LIMIT = 300.0
_NOTHING = -800.0  # ln F below which it is 0


class _Line(NamedTuple):
    """One Mellin line Re z = a: E[Y^z] sampled at a + i n step."""

    exponent: float
    centre: float
    deviation: float
    step: float
    log_moment: float
    phase: ComplexArray


@dataclass(frozen=True)
class ScalingSolution(Value):
    """The self-similar cooling state of the inelastic Lorentz gas, exactly.

    Parameters
    ----------
    restitution : e in [0, 1]

    Raises
    ------
    InputError (a ValueError) : restitution outside [0, 1] or not a number

    At e = 1 nothing cools and no scaling state is approached: ``cooling_rate`` is 0, ``a2`` and
    ``moment`` are the limits e -> 1 (a ring: -1/2 and 1), ``diffusion_slope`` is infinite, and
    :meth:`vdf` raises.

    >>> exact = ScalingSolution(0.0)
    >>> bool(abs(exact.cooling_rate - 2**0.5) < 1e-15), bool(abs(exact.a2 - 2) < 1e-14)
    (True, True)
    """

    restitution: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "restitution", check_restitution(self.restitution))

    @cached_property
    def law(self) -> CollisionLaw:
        """The collision law of this restitution."""
        return CollisionLaw(self.restitution)

    @cached_property
    def cooling_rate(self) -> float:
        """h(e) = M2/2 = 2 sqrt(kappa lambda(1)), dimensionless (paper, label ``compare2``)."""
        if self.restitution == 1.0:
            return 0.0
        return 2.0 * math.sqrt(self.law.mean_log_loss * float(self.law.decay_rate(1.0)))

    @cached_property
    def a2(self) -> float:
        """<c^4>/2 - 1 of the exact F (paper, label ``sonine5``); it exists for every e."""
        if self.restitution == 1.0:
            return -0.5
        law = self.law
        rates = law.decay_rate(np.array([1.0, 2.0, 3.0]))
        return float(3.0 * law.mean_log_loss * rates[0] / (rates[1] * rates[2]) - 1.0)

    @cached_property
    def diffusion_slope(self) -> float:
        """Limit of d<r^2>/d ln t in units of l^2: 2/[kappa (1 - <cos chi>)]."""
        if self.restitution == 1.0:
            return math.inf
        return 2.0 / (self.law.mean_log_loss * self.law.harmonic_decay_rate(0.0, 1))

    @property
    def tail_rate(self) -> float:
        """2/h: F(c) ~ c^tail_power exp(-tail_rate c) at high c; infinite at e = 1."""
        return math.inf if self.restitution == 1.0 else 2.0 / self.cooling_rate

    @property
    def tail_power(self) -> float:
        """1/(1-e^2) - 2, the power of c before the exponential tail; infinite at e = 1."""
        if self.restitution == 1.0:
            return math.inf
        return 1.0 / ((1.0 - self.restitution) * (1.0 + self.restitution)) - 2.0

    @cached_property
    def log_tail_amplitude(self) -> float:
        """ln A in F(c) ~ A c^tail_power exp(-tail_rate c), to 1e-10; InputError at e = 1.

        With b = 1/(1-e^2), E[Y^p]/Gamma(p+b) tends to 2 pi A (h/2)^b: a sum over the integers p
        of ln[(p/(p+b))/lambda(p)], by Euler-Maclaurin.
        """
        if self.restitution == 1.0:
            raise InputError("restitution: got 1.0; the scaled VDF exists for 0 <= e < 1 only")
        law, b = self.law, self.tail_power + 2.0

        def excess(p: FloatArray) -> FloatArray:
            # ln of the factor by which E[Y^p]/Gamma(p+b) grows from p to p+1
            return np.asarray(-np.log(law.decay_rate(p)) - np.log1p(b / p))

        n = 24.0
        head = float(excess(np.arange(1.0, n)).sum())
        # Euler-Maclaurin from n on; the integral in u = n/p up to p = last, beyond that from the
        # first three terms of the series in 1/p
        last = 2000.0 * b
        u, w = equal_panels(1.0 - n / last, 40, 0.25)
        u = u + n / last
        integral = float((excess(n / u) * n / u**2) @ w)
        at = last * np.array([1.0, 1.5, 2.0])
        terms = np.linalg.solve(at[:, None] ** -np.array([2.0, 3.0, 4.0]), excess(at))
        integral += float(terms @ (last ** -np.array([1.0, 2.0, 3.0]) / np.array([1.0, 2.0, 3.0])))
        step = 1.0
        around = excess(n + step * np.arange(-3.0, 4.0))
        first = float(around @ [-1, 9, -45, 0, 45, -9, 1]) / (60.0 * step)
        third = float(around @ [1, -8, 13, 0, -13, 8, -1]) / (8.0 * step**3)
        tail = integral + 0.5 * float(around[3]) - first / 12.0 + third / 720.0
        log_y = -math.log(law.mean_log_loss) - math.lgamma(1.0 + b) + head + tail
        return log_y + b * math.log(self.tail_rate) - math.log(2.0 * math.pi)

    def moment(self, p: float) -> float:
        """<c^p> for real p, |p| <= 300 (p > -1 at e = 0), with <c^0> = <c^2> = 1.

        Raises InputError for other p, and where the moment overflows.
        """
        p = self._check_exponent(p)
        if self.restitution == 1.0:
            return 1.0
        # <c^p> = E[Y^p]/E[Y^2]^(p/2) and E[Y^p] = kappa^-p A(p): the powers of kappa cancel
        log_a2 = math.log(self.law.mean_log_loss / float(self.law.decay_rate(1.0)))
        log_moment = float(self._log_a(np.array([p]))[0].real) - 0.5 * p * log_a2
        if log_moment > 709.0:
            raise InputError(f"p: got {p!r}; <c^p> overflows double precision there")
        return math.exp(log_moment)

    def scaled_speed_moment(self, p: float) -> float:
        """E[Y^p], the limit of <(v t/l)^p>; p and errors as in :meth:`moment`. 0 < e < 1 or e = 0.

        Raises InputError at e = 1, where v t has no limit.
        """
        p = self._check_exponent(p)
        if self.restitution == 1.0:
            raise InputError("restitution: got 1.0; v t has no limit law in the elastic gas")
        log_a = float(self._log_a(np.array([p]))[0].real)
        return math.exp(log_a - p * math.log(self.law.mean_log_loss))

    def vdf(self, c: ArrayLike) -> Any:
        """F(c), the scaled velocity distribution; same shape as c.

        Normalised in the plane: integral of 2 pi c F(c) dc = 1 and <c^2> = 1. Relative error
        below 1e-12 wherever F is not below 1e-280; near e = 1, where F is a ring of width
        sqrt(1 - e), what the rounding of c makes, some 1e-16/sqrt(1 - e). F(0) is 0
        for 0 < e < 1 (a hole) and infinite at e = 0, where F = exp(-sqrt(2) c)/(sqrt(2) pi c).

        Raises
        ------
        InputError : c negative or not finite; e = 1, where F is the ring delta(c - 1)/(2 pi)
        """
        c_ = np.asarray(c, dtype=float)
        if not np.all(np.isfinite(c_)) or np.any(c_ < 0.0):
            raise InputError(f"c: got {short(c)}; a scaled speed must be finite and not negative")
        if self.restitution == 1.0:
            raise InputError("restitution: got 1.0; the scaled VDF exists for 0 <= e < 1 only")
        if self.restitution == 0.0:
            with np.errstate(divide="ignore"):
                return (np.exp(-math.sqrt(2.0) * c_) / (math.sqrt(2.0) * math.pi * c_))[()]
        flat = c_.ravel()
        out = np.zeros_like(flat)
        inside = flat > 0.0
        # x = ln(kappa y), y = c sqrt(E[Y^2]); the density of x is that whose exponents are A(z)
        log_a2 = math.log(self.law.mean_log_loss / float(self.law.decay_rate(1.0)))
        x = np.log(flat[inside]) + 0.5 * log_a2
        with np.errstate(under="ignore"):
            log_f = self._log_density(x) - 2.0 * np.log(flat[inside])
            out[inside] = np.exp(log_f) / (2.0 * math.pi)
        return out.reshape(c_.shape)[()]

    # -- the principal solution of log A(z+1) - log A(z) = rho(z) ---------------------------

    def _check_exponent(self, p: float) -> float:
        try:
            number = float(p)
        except (TypeError, ValueError):
            number = math.nan
        if not abs(number) <= _EXPONENT_LIMIT:
            raise InputError(f"p: got {p!r}; it must be a real number of size up to 300")
        if self.restitution == 0.0 and number <= -1.0:
            raise InputError(f"p: got {p!r}; at restitution 0 moments exist for p > -1 only")
        return number

    def _rho(self, z: NDArray[Any]) -> NDArray[Any]:
        """log(kappa z/lambda(z)); 0 at z = 0."""
        law = self.law
        zero = np.abs(z) < 1e-290
        safe = np.where(zero, 1.0, z)
        ratio = law.mean_log_loss * safe / law.decay_rate(safe)
        return np.asarray(np.where(zero, 0.0, np.log(ratio)))

    def _odd_derivatives(self, z: NDArray[Any]) -> list[NDArray[Any]]:
        """rho^(n)(z)/n! for n = 1, 3, ..., 11, from the Taylor coefficients of lambda at z."""
        order = 2 * len(_BERNOULLI)
        if self.restitution == 0.0:
            # rho = log(1 + z)
            return [1.0 / (n * (1.0 + z) ** n) for n in range(1, order, 2)]
        q = self.law.quadrature_for(float(np.abs(z).max()))
        kernel = np.exp(-np.multiply.outer(z, q.log_loss)) * q.weight
        c = [self.law.decay_rate(z)]
        factor = np.ones_like(q.log_loss)
        for n in range(1, order):
            factor = factor * (-q.log_loss) / n
            c.append(-(kernel @ factor))
        d: list[NDArray[Any]] = [np.zeros_like(z)]
        for n in range(1, order):
            total = n * c[n]
            for k in range(1, n):
                total = total - k * d[k] * c[n - k]
            d.append(total / (n * c[0]))
        return [(1.0 / (n * z**n)) - d[n] for n in range(1, order, 2)]

    def _log_a(self, z: NDArray[Any], path_from: float | None = None) -> NDArray[Any]:
        """Log A(z), z of shape (n,), real or complex; A(0) = A(1) = 1.

        Complex z must lie on one vertical line in rising order of Im z; the path of integration
        then runs up that line from Re z = path_from.
        """
        shift = max(_START, math.ceil(_START - float(np.min(z.real))))
        low = z.real < -_START
        if np.any(low) and self._far_from_zeros(float(np.max(np.abs(z.imag)))):
            if not np.all(low):
                out = np.empty(z.shape, dtype=z.dtype)
                out[low], out[~low] = self._log_a(z[low]), self._log_a(z[~low])
                return out
            shift = 1
        steps = np.arange(shift)
        below = self._rho(z[:, None] + steps).sum(axis=1)
        base = np.array([float(shift)])
        known = self._rho(np.arange(1.0, shift)).sum()  # log A(shift)
        top = z + shift
        if path_from is None:
            integral = np.array([self._integral(float(shift), float(t)) for t in top])
        else:
            start = self._integral(float(shift), path_from + shift)
            nodes = np.concatenate([[0.0], z.imag])
            x, w = np.polynomial.legendre.leggauss(10)
            half = 0.5 * np.diff(nodes)
            middle = nodes[:-1] + half
            points = path_from + shift + 1j * (middle[:, None] + half[:, None] * x)
            pieces = 1j * half * (self._rho(points) @ w)
            integral = start + np.cumsum(pieces)
        value = known + integral - 0.5 * (self._rho(top) - self._rho(base))
        for j, (high, low) in enumerate(
            zip(self._odd_derivatives(top), self._odd_derivatives(base), strict=True)
        ):
            n = 2 * j + 1
            value = value + _BERNOULLI[j] * math.factorial(n) * (high - low)
        return np.asarray(value - below)

    def _far_from_zeros(self, height: float) -> bool:
        """Whether rho is as smooth at |Im z| <= height as it is beyond _START in general.

        Near e = 1 it is: the zeros of lambda are where all bounces turn s^z once round at least.
        """
        if not 0.5 < self.restitution < 1.0:
            return False
        return 2.0 * math.pi / -math.log(self.restitution) - height > _START + 1.0

    def _integral(self, low: float, high: float) -> float:
        """Integral of rho from low to high on the real axis, where it is smooth."""
        # rho is analytic within about _START of the path, or 2 pi/|ln e| if that is further
        unit = float(_START)
        if self.restitution > 0.0:
            unit = max(unit, 2.0 / abs(math.log(self.restitution)))
        signed = math.copysign(unit, high - low)
        nodes, weights = equal_panels(abs(high - low) / unit, 24)
        return float(self._rho(low + signed * nodes) @ weights) * signed

    # -- Mellin inversion through the saddle ------------------------------------------------

    def _cumulants(self, a: float, scale: float) -> tuple[float, float, float]:
        """Log A and its first two derivatives at a, by differences of width 0.2/scale."""
        d = 0.2 / scale
        if self.restitution == 0.0:
            d = min(d, 0.2 * (1.0 + a))
        left, mid, right = self._log_a(np.array([a - d, a, a + d]))
        return float(mid), float(right - left) / (2 * d), float(right - 2 * mid + left) / d**2

    def _line(self, x: float) -> _Line | None:
        """The line whose tilted density exp(a x) g(x)/A(a) is centred on x; None where F is 0."""
        scale = math.sqrt(math.log(self.law.mean_log_loss / float(self.law.decay_rate(1.0))))
        a = 0.0
        log_moment, mean, variance = self._cumulants(a, scale)
        for _ in range(60):
            scale = math.sqrt(variance)
            if abs(mean - x) < 0.3 * scale:
                break
            # Chernoff: ln g(x) is about log A(a) - a x at most, for every a
            if log_moment - (a + 2.0) * x < _NOTHING:
                return None
            # Newton, but not further than the variance can be trusted
            move = (x - mean) / variance
            a += max(-2.0 / scale, min(2.0 / scale, move))
            log_moment, mean, variance = self._cumulants(a, scale)
        scale = math.sqrt(variance)
        # Chernoff: where the tilted density is below 1e-17 on either side
        steps = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 12.0]) / scale
        up = self._log_a(a + steps) - log_moment
        right = float(np.min((up + _NEGLIGIBLE) / steps))
        # E[s^p] overflows below p = -700/(-ln e): bounds from there are not needed
        steps = np.append(steps, 0.1 / scale)
        steps = steps[steps - a < 600.0 / float(self.law.quadrature.log_loss.max())]
        down = self._log_a(a - steps) - log_moment
        left = float(np.max(-(down + _NEGLIGIBLE) / steps))
        step = 2.0 * math.pi / (right - left)
        block = 32
        samples = [np.ones(1, dtype=complex)]
        count = 1
        while True:
            omega = step * np.arange(count, count + block)
            z = a + 1j * np.concatenate([step * np.arange(1, count), omega])
            values = np.exp(self._log_a(z, path_from=a)[count - 1 :] - log_moment)
            samples.append(values)
            count += block
            if np.max(np.abs(values[-4:])) < 1e-17 or count > 2000:
                break
            block = count
        return _Line(a, mean, scale, step, log_moment, np.concatenate(samples))

    def _log_density(self, x: FloatArray) -> FloatArray:
        """Log of the density of x = ln(kappa Y), shape (n,)."""
        out = np.full(x.shape, -math.inf)
        todo = np.ones(x.shape, dtype=bool)
        # from the bulk (x near 0) outwards, and no further on a side once F is below e^-800
        while np.any(todo):
            nearest = int(np.argmin(np.where(todo, np.abs(x), math.inf)))
            line = self._line(float(x[nearest]))
            beyond = (x >= x[nearest]) if x[nearest] > 0.0 else (x <= x[nearest])
            if line is None:
                todo &= ~beyond
                continue
            near = todo & (np.abs(x - line.centre) <= _REACH * line.deviation)
            n = np.arange(line.phase.size)
            turn = np.exp(-1j * np.outer(x[near] - line.centre, n * line.step))
            # the centre's own phase is taken out of the samples: no large arguments
            rotated = line.phase * np.exp(-1j * n * line.step * line.centre)
            total = 2.0 * (turn @ rotated).real - 1.0
            total = np.maximum(total, 1e-300) * line.step / (2.0 * math.pi)
            out[near] = np.log(total) + line.log_moment - line.exponent * x[near]
            todo &= ~near
            if out[nearest] - 2.0 * x[nearest] < _NOTHING:
                todo &= ~beyond
        return out

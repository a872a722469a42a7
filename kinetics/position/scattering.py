r"""The intermediate scattering function of a tracer: <exp(i k.r)> from the backward equation.

For a tracer that starts with speed v at angle theta to k, psi = <exp(i k.r(t))> is a function of
theta and T = v t/l alone, for each K = k l. The inelastic Lorentz equation with its
free-streaming term (paper, label ``inelaslorentz``) gives for it

    dpsi/dT = i K cos(theta) psi + E[psi(theta + chi, s T)] - psi,    psi = 1 at T = 0,

and for the harmonics of psi = sum_m i^|m| a_|m| exp(i m theta), which stay real,

    da_m/dT = (K/2) (a_(m-1) - a_(m+1)) + E[cos(m chi) a_m(s T)] - a_m     (-K a_1 for m = 0).

On panels in X = ln T, as in :mod:`kinetics.moments.backward`, each panel is a block-tridiagonal
system in m, solved from both ends to the middle for all wave numbers at once, with as many
harmonics as count on that panel. a_0 is the mean over the directions: all that an isotropic start,
or a radial density, needs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics.panels import PanelRule, PanelShifts

FloatArray = NDArray[np.float64]

_TERMS = 40  # of the power series at the start
_SERIES = 5.0  # (K + 2) T up to which the series loses two digits at most
_SATURATION = 38.0  # beyond ln(1/kappa) + this, a_m falls as a power of T, to rounding
_RISING = 0.75  # a_m below this power of the tolerance do not matter while they rise with T
_TURNING = 3.5  # T at which flights along k are resolved worst
_FEWEST_NODES, _MOST_NODES = 6, 20
_MORE = 6  # harmonics that a panel may add
_NOTHING = 0.1  # of the tolerance
_FAR = 0.01  # of the tolerance, what comes from farther down than is looked at


@dataclass(frozen=True)
class Waves:
    """a_m for some wave numbers.

    Attributes
    ----------
    wave_numbers : K = k l, shape (n_k,)
    rule : the collocation
    start : X where the panels begin
    values : a_m at the nodes, shape (n_panels, n_kept, nodes, n_k); m up to n_kept - 1
    coefficients : of the power series in T below the panels, shape (n_terms, n_kept, n_k)
    ended : whether everything was below the tolerance at the last panel: 0 from there on
    error_estimate : absolute, of a_0 and of those kept
    systems : how many systems of rule.nodes - 1 equations were solved
    """

    wave_numbers: FloatArray
    rule: PanelRule
    start: float
    values: FloatArray
    coefficients: FloatArray
    ended: bool
    error_estimate: float
    systems: int

    def __call__(self, x: FloatArray, m: int = 0) -> FloatArray:
        """a_m at X = x (n_x,), -inf allowed: shape (n_x, n_k)."""
        level = (x - self.start) / self.rule.width
        out = np.empty((x.size, self.wave_numbers.size))
        low = level < 0.0
        if low.any():
            out[low] = _sum(self.coefficients[:, m], np.exp(x[low]))
        count = self.values.shape[0]
        inside = level[~low]
        index = np.minimum(inside.astype(int), count - 1)
        rows = self.rule.rows(np.minimum(inside - index, 1.0))
        found = np.einsum("ij,ijk->ik", rows, self.values[index, m])
        beyond = inside > count
        if beyond.any():
            found[beyond] = self._late(inside[beyond] - count, m)
        out[~low] = found
        return out

    def _late(self, panels: FloatArray, m: int) -> FloatArray:
        """Beyond the last panel: 0, or the power of T with which the last panel falls."""
        if self.ended:
            return np.zeros((panels.size, self.wave_numbers.size))
        last = self.values[-1, m, -1]
        with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
            fall = np.where(last != 0.0, np.abs(last / self.values[-1, m, 0]), 0.0)
            return np.asarray(last * np.minimum(1.0, fall) ** panels[:, None])


def solve_waves(
    law: CollisionLaw,
    wave_numbers: FloatArray,
    highest: float,
    tolerance: float,
    kept: int = 0,
) -> Waves:
    """Solve for wave numbers K = k l (n_k,), of similar size, up to X = highest.

    Parameters
    ----------
    tolerance : absolute, of a_0 and of those kept
    kept : largest m that is wanted, if it is not negligible
    """
    largest = float(wave_numbers.max())
    rule = _rule(largest, highest, tolerance)
    first = math.log(_SERIES / (largest + 2.0))
    start = rule.width * math.floor(min(first, highest) / rule.width)
    limit = highest
    if law.restitution < 1.0:
        limit = min(limit, _SATURATION - math.log(law.mean_log_loss))
    count = max(1, math.ceil((limit - start) / rule.width))
    # a_m beside a_0 must have ended themselves, not only what they give back
    top = _harmonics(largest, min(highest, limit), tolerance**2 if kept else tolerance)
    return _sweep(law, wave_numbers, rule, start, count, top, tolerance, kept)


def _rule(largest: float, highest: float, tolerance: float) -> PanelRule:
    """Panels that resolve exp(-T + i K T), the fastest that there is."""
    # early, K T counts
    turns = largest * min(1.0, math.exp(highest) / _TURNING)
    width = min(1.0, 1.5 / (turns + 1.0))
    digits = math.log10(1.0 / tolerance)
    # measured, for widths of up to 1.5/(K + 1)
    nodes = math.ceil(2.0 + digits * (0.85 + 0.5 * turns * width))
    return PanelRule(min(_MOST_NODES, max(_FEWEST_NODES, nodes)), width)


def _harmonics(largest: float, highest: float, tolerance: float) -> int:
    """m beyond which a_m is left out."""
    digits = math.log10(1.0 / tolerance)
    # measured at late times; early, free flights reach m = K T and no further
    late = 2.0 + digits * (0.45 + largest)
    early = 4.0 + 2.0 * digits + largest * math.exp(min(highest, 10.0))
    return _even(math.ceil(min(late, early)))


def _coefficients(law: CollisionLaw, wave_numbers: FloatArray, top: int) -> FloatArray:
    """Of T^j in a_m, shape (terms, top + 1, n_k)."""
    q = law.quadrature_for(float(_TERMS), top)
    cosine = np.stack([q.harmonic(m) for m in range(top + 1)]) * q.weight
    loss = 1.0 - cosine @ np.exp(-np.outer(q.log_loss, np.arange(_TERMS)))
    loss[0] = [law.decay_rate(float(j)) for j in range(_TERMS)]
    out = np.zeros((_TERMS + 1, top + 1, wave_numbers.size))
    out[0, 0] = 1.0
    for j in range(_TERMS):
        a = out[j]
        coupled = np.zeros_like(a)
        coupled[1:] += a[:-1]
        coupled[:-1] -= a[1:]
        coupled[0] -= a[1]
        out[j + 1] = (0.5 * wave_numbers * coupled - loss[:, j, None] * a) / (j + 1.0)
    return out


def _sum(coefficients: FloatArray, path: FloatArray) -> FloatArray:
    """The series at small T = path (n,): shape (n, ...)."""
    with np.errstate(under="ignore"):
        powers = path[:, None] ** np.arange(_TERMS + 1)
    return np.tensordot(powers, coefficients, axes=1)


def _sweep(
    law: CollisionLaw,
    wave_numbers: FloatArray,
    rule: PanelRule,
    start: float,
    count: int,
    top: int,
    tolerance: float,
    kept: int,
) -> Waves:
    """Panel after panel upwards, with as many harmonics as count there, ``top`` at most (even)."""
    n, size = rule.nodes, wave_numbers.size
    q = law.quadrature_for(2.0 * n / rule.width, top)
    loss, gain = PanelShifts(rule, q.log_loss).kernel(
        q.weight,
        np.stack([q.harmonic(m) for m in range(top + 1)]),
        np.stack([q.harmonic_loss(m) for m in range(top + 1)]),
    )
    recent = _shares(law, rule.width, gain.shape[2] // n)
    # next to nothing comes from farther down, where e is about 0
    far = np.count_nonzero(np.cumsum(recent) < _FAR * tolerance)
    gain, recent = gain[:, :, far * n :], recent[far:]
    reach = gain.shape[2] // n
    # (panels, m, nodes, n_k): the products with the kernels are over whole blocks then
    table = np.zeros((reach + count, top + 1, n, size))
    local = rule.local * rule.width
    series = _coefficients(law, wave_numbers, top)
    if reach:
        x = (start + (np.arange(reach) - reach)[:, None] * rule.width + local).ravel()
        before = _sum(series, np.exp(x)).reshape(reach, n, top + 1, size)
        table[:reach] = np.moveaxis(before, 2, 1)
    largest = np.abs(table).max(axis=(1, 2, 3), initial=0.0)  # of each panel
    known = _sum(series, np.exp(np.array([start])))[0]
    # steady free flights beyond the last harmonic: a_(m+1) = closure a_m
    closure = wave_numbers / (1.0 + np.sqrt(1.0 + wave_numbers**2))
    done, ended = count, False
    used, left_out, systems = 0, 0.0, 0
    # what comes back to m = 0 is the square at most; others are wanted as they are
    rising = 0.1 * tolerance if kept else tolerance**_RISING
    for j in range(count):
        rate = np.exp(start + j * rule.width + local)
        # free flights of T reach m = K T
        more = 4 + int(min(_MORE, float(wave_numbers.max()) * (rate[-1] - rate[0])))
        needed = max(_last_above(known, rising) + more, min(used, _last_above(known, tolerance)))
        used = min(top, _even(needed))
        drive = np.zeros((used + 1, n, size))
        if reach:
            below = np.moveaxis(table[j : j + reach, : used + 1], 0, 1)
            drive = rate[:, None] * (gain[: used + 1] @ below.reshape(used + 1, reach * n, size))
        found = _panel(
            rule, loss[: used + 1], rate, drive, known[: used + 1], wave_numbers, closure
        )
        systems += (used + 1) * size
        table[reach + j, : used + 1] = found
        known = table[reach + j, :, -1]
        # what the highest harmonic misses goes back to m = 0 as weakened as it came
        miss = float(np.abs(found[used]).max())
        left_out = max(left_out, miss if kept else miss**2)
        largest[reach + j] = np.abs(found).max()
        # nothing that follows is larger than the mean over what is collided out of
        if recent @ largest[reach + j + 1 - recent.size : reach + j + 1] < _NOTHING * tolerance:
            done, ended = j + 1, True
            break
    values = table[reach : reach + done]
    last, before_last = rule.last_coefficients(np.moveaxis(values[:, : kept + 1], 2, 3))
    fall = np.minimum(1.0, (last + 1e-17) / (before_last + 1e-17))
    chebyshev = float((last * np.sqrt(fall)).max())
    return Waves(
        wave_numbers,
        rule,
        start,
        values[:, : kept + 1].copy(),
        series[:, : kept + 1].copy(),
        ended,
        chebyshev + left_out,
        systems,
    )


def _even(m: int) -> int:
    return m + m % 2


def _last_above(known: FloatArray, least: float) -> int:
    """The last m whose a_m (m, n_k) is above."""
    return int(np.flatnonzero(np.abs(known).max(axis=1) > least).max(initial=0))


def _shares(law: CollisionLaw, width: float, reach: int) -> FloatArray:
    """Shares of the collisions that come out of the last panels, farthest first."""
    e = law.restitution
    if reach == 0:
        return np.ones(1)
    with np.errstate(under="ignore"):
        ratio = np.exp(-width * np.arange(reach + 1))
    # of the impact parameters up to y, collisions lose more than s(y)
    impact = np.sqrt(np.maximum(0.0, ratio**2 - e * e) / (1.0 - e * e))
    impact[-1] = 0.0
    return -np.diff(impact)[::-1]


def _panel(
    rule: PanelRule,
    loss: FloatArray,
    rate: FloatArray,
    drive: FloatArray,
    known: FloatArray,
    wave_numbers: FloatArray,
    closure: FloatArray,
) -> FloatArray:
    """One panel: block elimination from both ends to the middle; shape (m, nodes, n_k).

    The number of harmonics is odd. The first node is known, the others are solved for.
    """
    n, size, pairs = rule.nodes - 1, wave_numbers.size, (drive.shape[0] - 1) // 2
    rate = rate[1:]
    scale = 1.0 / np.maximum(1.0, rate)
    turn = (0.5 * rate * scale * wave_numbers[:, None])[None, :, :, None]  # (1, n_k, nodes, 1)
    turn = np.concatenate([turn, -turn])
    blocks: FloatArray = (
        rule.derivative[1:] * scale[:, None] + (rate * scale)[:, None] * loss[:, 1:]
    )
    right = drive[:, 1:] * scale[:, None] - blocks[:, :, :1] * known[:, None]
    right = np.ascontiguousarray(np.moveaxis(right, 2, 1))  # (m, n_k, nodes)
    blocks = blocks[:, None, :, 1:]
    # from above a_m = part[0] (a_(m-1), 1), from below a_m = part[1] (a_(m+1), 1)
    diagonal = np.arange(n)
    both = np.zeros((2, size, n, n + 1))
    both[:, :, diagonal, diagonal] = turn[..., 0]
    both[1, :, diagonal, diagonal] *= 2.0
    parts = np.zeros((pairs + 1, 2, size, n, n + 1))
    parts[0, 0, :, diagonal, diagonal] = closure
    for i in range(pairs):
        ends = [-1 - i, i]
        added = turn * parts[i]
        both[..., n] = right[ends] - added[..., n]
        parts[i + 1] = np.linalg.solve(blocks[ends] + added[..., :n], both)
        if i == 0:  # a_1 stands for a_(-1) too
            both[1, :, diagonal, diagonal] *= 0.5
    added = (turn * parts[pairs]).sum(axis=0)
    a = np.linalg.solve(blocks[pairs] + added[..., :n], (right[pairs] - added[..., n])[..., None])
    found = np.empty((2 * pairs + 1, size, n + 1))
    found[:, :, 0] = known
    found[pairs, :, 1:] = a[..., 0]
    for i in range(pairs - 1, -1, -1):
        a = parts[i + 1, ..., :n] @ a + parts[i + 1, ..., n:]
        found[[-1 - i, i], :, 1:] = a[..., 0]
    return np.moveaxis(found, 1, 2)

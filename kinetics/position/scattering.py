r"""<exp(i k.r)> of a tracer, from the backward equation.

For a tracer that starts with speed v at angle theta to k, psi = <exp(i k.r(t))> is a function of
theta and T = v t/l alone, for each K = k l (the equation with its free-streaming term, paper, label
``inelaslorentz``):

    dpsi/dT = i K cos(theta) psi + E[psi(theta + chi, s T)] - psi,    psi = 1 at T = 0.

The harmonics of psi = sum_m i^|m| a_|m| exp(i m theta) stay real,

    da_m/dT = (K/2) (a_(m-1) - a_(m+1)) + E[cos(m chi) a_m(s T)] - a_m     (-K a_1 for m = 0),

in space, as Legendre polynomials, nearly so (:mod:`kinetics.position.directions`; a_m below is b_m
there). On panels in X = ln T each panel is a block-tridiagonal system in m, solved for all wave
numbers at once, with as many harmonics as count on that panel.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import takewhile

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.moments.backward import asymptotic_from
from kinetics.moments.delayed import Loops, Returns, met_again, series_end
from kinetics.numerics import FOLDS, LARGEST_LOG, ROUNDING, FloatArray
from kinetics.numerics.chebyshev import Chebyshev, PanelShifts, with_returns
from kinetics.position.directions import coupling, eliminate, iterate

# The power series at the start: (K + 2) T up to _SERIES, where the largest term, 5^5/5!, costs less
# than two digits, and the term after the last is 5^41/41! = 1e-21.
_SERIES, _TERMS = 5.0, 40
NEGLIGIBLE = 0.01  # of the tolerance: values that count as 0, and gain from far below
# Nodes of a panel: some, for each decimal digit of the tolerance so many, and more for each turn of
# K T on it; and T at which flights along k are resolved worst.
_SOME, _FOR_DIGIT, _FOR_TURN, _TURNING = 2.0, 0.85, 0.5, 3.5
_RISING = 0.75  # a_m below this power of the tolerance do not matter while they rise with T
# Harmonics that a panel adds, and further ones as free flights reach them; no more than so many
# where only m = 0 is wanted, to which the last ones give back their square.
_MORE, _MOST_MORE = 4, 6
_LASTING = tuple(2**n for n in range(1, 10))  # m that are looked at where bounces hardly turn
_SAFETY = 2.0  # the error over the last coefficients: 1.2 was the largest seen


def _rule(law: CollisionLaw, largest: float, highest: float, tolerance: float) -> Chebyshev:
    """Panels that resolve exp(-T + i K T), which varies fastest of all.

    Among light scatterers a bounce takes u = 1 + e of the speed at most, and these waves last until
    T^(3/2) K u = 1, where the paths of the tracers differ by 1/K, or all are slow, at T u = 1.
    """
    u = 1.0 + min(law.disk_restitutions, default=0.0)
    lasting = max(1.0, max(u * largest, u**1.5) ** (-2.0 / 3.0))
    turns = largest * min(lasting, math.exp(min(highest, LARGEST_LOG)) / _TURNING)
    width = min(1.0, 1.5 / (turns + 1.0))
    digits = math.log10(1.0 / tolerance)
    nodes = math.ceil(_SOME + digits * (_FOR_DIGIT + _FOR_TURN * turns * width))
    return Chebyshev(max(6, nodes), width)


def _harmonics(law: CollisionLaw, largest: float, highest: float, tolerance: float) -> int:
    """m beyond which a_m is left out: even."""
    digits = math.log10(1.0 / tolerance)
    # and, within a factor of two, those of which a bounce keeps more than half
    late = _SOME + digits * (0.45 + largest)
    late += sum(takewhile(lambda m: law.harmonic_decay_rate(0.0, m) < 0.5, _LASTING))
    # free flights reach m = K T and no further
    early = _SOME * (1.0 + digits) + largest * math.exp(min(highest, 10.0))
    return 2 * math.ceil(0.5 * min(late, early))


class Waves:
    """a_m for some wave numbers, in space b_m of `directions`, as a function of X = ln T.

    wave_numbers : K = k l, of similar size, shape (n_k,)
    start : X where the panels begin
    values : a_m at the nodes, shape (n_panels, n_kept, nodes, n_k); m up to n_kept - 1
    coefficients : of the power series in T below the panels, shape (n_terms, n_kept, n_k)
    ended : whether everything is below the tolerance at the last panel, and 0 from there on
    errors : absolute, up to each panel, by the last Chebyshev coefficients; root of the sum of the
        squares of all harmonics that are kept (m and -m), shape (n_panels,)
    systems : how many systems of rule.nodes - 1 equations were solved
    work : products of numbers that this took, about: of the kernels, and on the panels
    """

    def __init__(
        self, law: CollisionLaw, wave_numbers: FloatArray, highest: float, tolerance: float,
        kept: int = 0, most_work: float = math.inf,
    ) -> None:  # fmt: skip
        """Solve on panels up to X = highest.

        tolerance : absolute, of a_0 and of those kept
        kept : largest m that is wanted, if it is not negligible
        most_work : OverflowError, with the K that could be had, where more may be needed (some
            three times what is)
        """
        self.law, self.wave_numbers, self.tolerance = law, wave_numbers, tolerance
        largest = float(wave_numbers.max())
        self.rule = rule = _rule(law, largest, highest, tolerance)
        limit = highest if law.is_elastic else min(highest, asymptotic_from(law))
        # where harmonics are kept, those left out must be negligible themselves; otherwise only
        # what they give back to m = 0, which is their square
        self._top = top = _harmonics(law, largest, limit, tolerance**2 if kept else tolerance)
        first, medium = math.log(_SERIES / (largest + 2.0)), met_again(law)
        if law.returns(0)[0]:  # panels from which a bounce straight back leads to none below them
            first = min(first, limit - min(law.largest_loss, FOLDS) - 2.0 * rule.width)
        if medium is not None:
            first = min(first, series_end(medium))
        self.start = rule.width * math.floor(min(first, highest) / rule.width)
        count = max(1, math.ceil((limit - self.start) / rule.width))
        self._kept = min(kept, top)
        # row m of the equations over the coupling: free flights then look the same for all m
        self._coupling = coupling(top, law.dimension)
        by_row = self._coupling[:, None, None]
        loss, self._gain = self._kernels(count, most_work)
        self._rise, self._loss = rule.derivative / by_row, loss / by_row
        self._loops: Loops | None = None
        if medium is not None:
            self._loops = Loops(medium, rule, self.start, count, range(top + 1))
            self._loops.shares *= self._coupling[:, None]
            self._loops.shares[0] = 0.0  # at once, in the kernel
        self._of_series = min(top, _TERMS)  # the last harmonic that begins with one of its powers
        self._run(count)

    def _kernels(self, count: int, most_work: float) -> tuple[FloatArray, FloatArray]:
        """What a panel loses, and gains from those below it, for each harmonic."""
        law, rule, top, tolerance = self.law, self.rule, self._top, self.tolerance
        # collisions that lose very much lead to where a_0 is 1, but for K T, and all others 0
        deep = 2.0 - math.log(tolerance)
        # no tracer is further away than T: a_m is (e K T/2 m)^m at most, and nothing before panel
        order = np.arange(1, top + 1)
        rise = np.log(2.0 * order) - math.log(float(self.wave_numbers.max())) - 1.0
        rise += math.log(NEGLIGIBLE * tolerance) / order
        first = np.floor((np.append(-FOLDS, rise) - self.start) / rule.width)
        self._first = np.minimum(first, count).astype(int)
        reach = count - self._first + math.ceil(deep / rule.width)
        back = np.minimum(reach, law.largest_loss / rule.width)
        work = float((count - self._first) @ (rule.nodes + back)) * rule.nodes**2
        if work > most_work:  # it grows as the cube
            raise OverflowError(float(self.wave_numbers.max()) * (most_work / work) ** (1.0 / 3.0))
        q = law.quadrature_for(2.0 * rule.nodes / rule.width, top)
        lost = np.stack(list(q.harmonic_losses(top)))
        shifts = PanelShifts(rule, np.minimum(q.log_loss, count * rule.width + deep))
        loss, gain = shifts.kernel(q.weight, 1.0 - lost, lost, reach)
        self.work = float(lost.size * rule.nodes**2)
        if law.returns(0)[0]:
            alone = gain
            eps = np.array([law.returns(m)[0] for m in range(top + 1)])
            if met_again(law) is not None:
                eps[1:] = 0.0  # they take time
            loss, gain = with_returns(rule, loss, alone, eps, law.returns(0)[1])
            self.work += float(alone.size * gain.shape[2])
        return loss, gain

    def _run(self, count: int) -> None:
        """Up to ``count`` panels, each with as many harmonics as matter there."""
        kept = self._kept
        n, size, local = self.rule.nodes, self.wave_numbers.size, self.rule.local * self.rule.width
        # from how many panels below a gain matters, and about how much comes from each of them
        gains = np.abs(self._gain[0]).max(axis=0, initial=0.0).reshape(-1, n).sum(axis=1)
        far = int(np.count_nonzero(np.cumsum(gains) < NEGLIGIBLE * self.tolerance))
        reach, recent = gains.size - far, np.append(gains[far:], 1.0)
        series, total, returns = self._coefficients()
        few = self._of_series + 1  # harmonics
        # all panels, those below the first by the series; high harmonics are 0 until they rise
        x = self.start + (np.arange(reach) - reach)[:, None] * self.rule.width + local
        filled = _series_sum(total, np.exp(x.ravel())).reshape(reach, n, few, size)
        panels = np.zeros((self._top + 1, reach + count, n, size))
        panels[:few, :reach] = np.moveaxis(filled, 2, 0)
        largest = deque(np.abs(filled).max(axis=(1, 2, 3)).tolist(), maxlen=recent.size)
        known = np.zeros((self._top + 1, size))
        known[:few] = _series_sum(series, np.exp(np.array([self.start])))[0]
        values: list[FloatArray] = []
        errors: list[float] = []
        used, self.systems, self.ended = 0, 0, False
        for j in range(count):
            rate = np.exp(self.start + j * self.rule.width + local)
            used = self._panel_harmonics(known, used, rate)
            drive = self._from_below(panels[: used + 1], j, reach)
            loss, come = self._loss[: used + 1], drive
            if returns:
                loss, come = returns.begin(j, loss, drive)
            found = self._solve_panel(rate, rate[:, None] * come, known[: used + 1], loss)
            self.systems += (used + 1) * size
            self.work += (used + 1) * size * n**2 * (n + reach)
            known[: used + 1], known[used + 1 :] = found[:, -1], 0.0
            values.append(np.zeros((kept + 1, n, size)))
            values[-1][: used + 1] = found[: kept + 1]
            panels[: used + 1, reach + j] = returns.end(j, found) if returns else found
            # what the highest harmonic misses goes back to m = 0 as weakened as it came
            miss = float(np.abs(found[used]).max())
            # and the polynomials of the panel leave out what their last two coefficients say
            last, before = self.rule.last_coefficients(np.moveaxis(values[-1], 1, 2))
            fall = np.minimum(1.0, (last + 1e-17) / (before + 1e-17))
            each = (last * np.sqrt(fall)).max(axis=1)
            left = _SAFETY * math.sqrt(4.0 * float(each @ each) - 3.0 * each[0] ** 2)
            errors.append(left + (miss if kept else miss**2))
            largest.append(float(np.abs(found).max()))
            # nothing that follows is larger than the mean over what collisions lead to it from
            if len(largest) == recent.size and recent @ largest < NEGLIGIBLE * self.tolerance:
                self.ended = True
                break
        self.values, self.errors = np.array(values), np.maximum.accumulate(errors)
        self.coefficients = series[:, : kept + 1].copy()

    def __call__(self, x: FloatArray, m: int = 0) -> FloatArray:
        """a_m at X = x (n_x,), -inf allowed: shape (n_x, n_k)."""
        level = (x - self.start) / self.rule.width
        out = np.empty((x.size, self.wave_numbers.size))
        low = level < 0.0
        if low.any():  # harmonic m begins with T^m: the series has no more of them than terms
            series = self.coefficients[:, m : m + 1]
            out[low] = _series_sum(series, np.exp(x[low])).sum(axis=1)
        count, inside = self.values.shape[0], level[~low]
        index = np.minimum(inside.astype(int), count - 1)
        rows = self.rule.rows(np.minimum(inside - index, 1.0))
        found = np.einsum("ij,ijk->ik", rows, self.values[index, m])
        beyond = inside > count
        if beyond.any() and self.ended:
            found[beyond] = 0.0
        elif beyond.any():  # a_m goes on with the power of T with which the last panel falls
            first, last = self.values[-1, m, 0], self.values[-1, m, -1]
            with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
                fall = np.where(last != 0.0, np.minimum(1.0, np.abs(last / first)), 0.0)
                found[beyond] = last * fall ** (inside[beyond] - count)[:, None]
        out[~low] = found
        return out

    def error_at(self, x: FloatArray) -> FloatArray:
        """The error at X = x (n_x,): shape (n_x,)."""
        level = np.floor((x - self.start) / self.rule.width)
        padded = np.concatenate([[0.0], self.errors, [0.0 if self.ended else self.errors[-1]]])
        return padded[np.clip(level + 1.0, 0.0, padded.size - 1.0).astype(int)]

    def _from_below(self, panels: FloatArray, j: int, reach: int, together: int = 8) -> FloatArray:
        """The gain of panel j from those below it, (m, nodes, n_k); panels from -reach on.

        together : harmonics whose gain is found at once
        """
        used, _, n, size = panels.shape
        drive = np.zeros((used, n, size))
        for low in range(0, used, together):
            few = slice(low, min(low + together, used))
            back = min(reach, j - int(self._first[low]))
            if back > 0:
                come = panels[few, j + reach - back : j + reach].reshape(-1, back * n, size)
                drive[few] = self._gain[few, :, -back * n :] @ come
        return np.asarray(drive / self._coupling[:used, None, None])

    def _coefficients(self) -> tuple[FloatArray, FloatArray, Returns | None]:
        """Of T^j in a_m, and in what collisions act on, (terms + 1, n_m, n_k); delayed returns."""
        order = np.arange(float(_TERMS))
        q = self.law.quadrature_for(float(_TERMS), self._of_series)
        powers = q.weight[:, None] * np.exp(-np.outer(q.log_loss, order))
        kept = [(1.0 - lost) @ powers for lost in q.harmonic_losses(self._of_series)]
        rates = 1.0 - np.stack(kept)
        loops, few = self._loops, len(kept)
        if not loops:
            rates = np.stack([self.law.met_again(order, rate, m) for m, rate in enumerate(rates)])
        rates[0] = self.law.decay_rate(order)
        out = np.zeros((_TERMS + 1, few, self.wave_numbers.size))
        out[0, 0] = 1.0
        total, lost = out.copy(), np.zeros_like(out)
        modes = np.zeros((_TERMS + 1, loops.weights.shape[1] if loops else 0, *lost.shape[1:]))
        for j in range(_TERMS):
            a = out[j]
            coupled = np.zeros_like(a)
            coupled[1:] += a[:-1]
            coupled[:-1] -= a[1:]
            coupled[0] -= a[1]
            coupled *= 0.5 * self.wave_numbers * self._coupling[:few, None]
            lost[j] = -rates[:, j, None] * total[j]
            total[j + 1] = out[j + 1] = (coupled + lost[j]) / (j + 1.0)
            if loops:
                lost[j] /= self._coupling[:few, None]
                modes[j + 1] = loops.term(j + 1, modes[j], lost[j])
                weights = loops.shares[:few] @ loops.weights
                total[j + 1] += np.einsum("mj,jmk->mk", weights, modes[j + 1])
        return out, total, Returns(loops, lost, modes) if loops else None

    def _panel_harmonics(self, known: FloatArray, used: int, rate: FloatArray) -> int:
        """The last harmonic of a panel that begins with a_m = known (m, n_k): even."""
        size, tolerance, kept = np.abs(known).max(axis=1), self.tolerance, self._kept
        # what comes back to m = 0 is the square at most; those that are kept matter themselves
        rising = 0.1 * tolerance if kept else tolerance**_RISING
        flights = float(self.wave_numbers.max()) * (rate[-1] - rate[0])  # they reach m = K T
        more = _MORE + int(flights if kept else min(_MOST_MORE, flights))
        first, last = (int(np.flatnonzero(size > x).max(initial=0)) for x in (rising, tolerance))
        needed = max(first + more, min(used, last))
        return min(self._top, needed + needed % 2)

    def _solve_panel(
        self, rate: FloatArray, drive: FloatArray, known: FloatArray, loss: FloatArray
    ) -> FloatArray:
        """One panel: shape (m, nodes, n_k)."""
        count, flights = drive.shape[0], rate[-1] - rate[0]
        rate = rate[1:]
        scale = 1.0 / np.maximum(1.0, rate)
        lost = (rate * scale)[:, None] * loss[:, 1:]
        blocks: FloatArray = self._rise[:count, 1:] * scale[:, None] + lost
        right = drive[:, 1:] * scale[:, None] - blocks[:, :, :1] * known[:, None]
        blocks, turn = np.ascontiguousarray(blocks[:, :, 1:]), 0.5 * rate * scale
        inner = None
        # of x radians of K T, iteration makes e^x of its rounding, and takes e x/2 rounds and some
        # for each digit: up to half of what rounding allows, a third of the time
        if float(self.wave_numbers.max()) * flights < 0.5 * math.log(self.tolerance / ROUNDING):
            inner = iterate(blocks, turn, right, self.wave_numbers, 1e-3 * self.tolerance)
        if inner is None:
            inner = eliminate(blocks, turn, right, self.wave_numbers)
        return np.concatenate([known[:, None], inner], axis=1)


def _series_sum(coefficients: FloatArray, path: FloatArray) -> FloatArray:
    """The power series with these coefficients (n_terms, ...) at T = path (n,): (n, ...)."""
    with np.errstate(under="ignore"):
        powers = path[:, None] ** np.arange(coefficients.shape[0])
    return np.tensordot(powers, coefficients, axes=1)

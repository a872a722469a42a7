r"""The intermediate scattering function of a tracer: <exp(i k.r)> from the backward equation.

For a tracer that starts with speed v at angle theta to k, psi = <exp(i k.r(t))> is a function of
theta and T = v t/l alone, for each K = k l. The inelastic Lorentz equation with its
free-streaming term (paper, label ``inelaslorentz``) gives for it

    dpsi/dT = i K cos(theta) psi + E[psi(theta + chi, s T)] - psi,    psi = 1 at T = 0,

and for the harmonics of psi = sum_m i^|m| a_|m| exp(i m theta), which stay real,

    da_m/dT = (K/2) (a_(m-1) - a_(m+1)) + E[cos(m chi) a_m(s T)] - a_m     (-K a_1 for m = 0).

In space the harmonics are Legendre polynomials, and in the right units they obey nearly the same
equations (:mod:`kinetics.position.directions`); a_m below is b_m there.

On panels in X = ln T, as in :mod:`kinetics.moments.backward`, each panel is a block-tridiagonal
system in m, solved from both ends to the middle for all wave numbers at once, with as many
harmonics as count on that panel. a_0 is the mean over the directions: all that an isotropic start,
or a radial density, needs.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.collision.memory import asymptotic_from
from kinetics.numerics import FloatArray
from kinetics.numerics.panels import PanelRule, PanelShifts
from kinetics.position.coupled_harmonics import eliminate, iterate
from kinetics.position.directions import coupling
from kinetics.position.returned import Returned
from kinetics.position.waves import Waves, carried, series_sum, together

# The power series at the start: (K + 2) T up to _SERIES, where the largest term, 5^5/5!, costs less
# than two digits, and the term after the last is 5^41/41! = 1e-21.
_SERIES, _TERMS = 5.0, 40
_FEWEST_NODES = 6
_NO_POWER = 1e-18  # a ratio of speeds of which no power but the zeroth counts
_NEGLIGIBLE = 0.01  # of the tolerance: values that count as 0, and gain from far below
# For each decimal digit of the tolerance so many nodes, and more for each turn of K T on a panel.
_SOME, _FOR_DIGIT, _FOR_TURN = 2.0, 0.85, 0.5
_TURNING = 3.5  # T at which flights along k are resolved worst
# Harmonics for each digit: late, besides K for each, and early, besides the K T of free flights.
_LATE_FOR_DIGIT, _EARLY_FOR_DIGIT = 0.45, 2.0
_RISING = 0.75  # a_m below this power of the tolerance do not matter while they rise with T
# Harmonics that a panel adds, and further ones as free flights reach them; no more than so many
# where only m = 0 is wanted, to which the last ones give back their square.
_MORE, _MOST_MORE = 4, 6
_MEMORY = 2e8  # bytes, of what is kept of the harmonics of all wave numbers at once
_PANELS = 32  # for which there is room at first
# A panel on which free flights turn K T by less is solved by iteration: a third of the time.
_FEW_TURNS = 10.0


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
    rule, start, count, top = _extent(law, float(wave_numbers.max()), highest, tolerance, kept)
    return Sweep(law, wave_numbers, rule, start, top, count).run(count, tolerance, kept)


def most_at_once(
    law: CollisionLaw, largest: float, highest: float, tolerance: float, kept: int = 0
) -> int:
    """How many wave numbers up to ``largest`` can be solved for at once within _MEMORY."""
    rule, _, count, top = _extent(law, largest, highest, tolerance, kept)
    n, deepest = rule.nodes, min(40.0, law.largest_loss)
    panels = count + min(count, deepest / rule.width) if kept else deepest / rule.width + _PANELS
    return max(1, int(_MEMORY / (8.0 * (top + 1.0) * n * (min(panels, 2.0 * count) + 2.0 * n))))


def _extent(
    law: CollisionLaw, largest: float, highest: float, tolerance: float, kept: int
) -> tuple[PanelRule, float, int, int]:
    """The collocation, where the panels begin, how many there are at most, the last harmonic."""
    rule = _rule(largest, highest, tolerance)
    first = math.log(_SERIES / (largest + 2.0))
    start = rule.width * math.floor(min(first, highest) / rule.width)
    limit = highest
    if not law.is_elastic:
        limit = min(limit, asymptotic_from(law))
    count = max(1, math.ceil((limit - start) / rule.width))
    # where harmonics are kept, those left out must be negligible themselves; otherwise only what
    # they give back to m = 0, which is their square
    top = _harmonics(largest, min(highest, limit), tolerance**2 if kept else tolerance)
    return rule, start, count, top


def _rule(largest: float, highest: float, tolerance: float) -> PanelRule:
    """Panels that resolve exp(-T + i K T), which varies fastest of all."""
    turns = largest * min(1.0, math.exp(min(highest, 700.0)) / _TURNING)
    width = min(1.0, 1.5 / (turns + 1.0))
    digits = math.log10(1.0 / tolerance)
    nodes = math.ceil(_SOME + digits * (_FOR_DIGIT + _FOR_TURN * turns * width))
    return PanelRule(max(_FEWEST_NODES, nodes), width)


def _harmonics(largest: float, highest: float, tolerance: float) -> int:
    """m beyond which a_m is left out: even."""
    digits = math.log10(1.0 / tolerance)
    late = _SOME + digits * (_LATE_FOR_DIGIT + largest)
    # free flights reach m = K T and no further
    early = _SOME + _EARLY_FOR_DIGIT * digits + largest * math.exp(min(highest, 10.0))
    return _even(math.ceil(min(late, early)))


def _even(m: int) -> int:
    return m + m % 2


class Sweep:
    """The equations of some wave numbers, solved on panel after panel upwards.

    Parameters
    ----------
    law : the collision law
    wave_numbers : K, shape (n_k,)
    rule : the collocation
    start : X where the panels begin
    top : the last harmonic, even
    count : how many panels there are, at most
    """

    def __init__(
        self,
        law: CollisionLaw,
        wave_numbers: FloatArray,
        rule: PanelRule,
        start: float,
        top: int,
        count: int,
    ) -> None:
        self.law, self.wave_numbers, self.rule = law, wave_numbers, rule
        self.start, self.top = start, top
        q = law.quadrature_for(2.0 * rule.nodes / rule.width, top)
        # collisions that lose more speed lead from every panel to where the series holds
        near = q.log_loss <= count * rule.width
        few = q.part(near)
        shifts = PanelShifts(rule, few.log_loss)
        lost = np.stack(list(few.harmonic_losses(top)))
        loss, gain = shifts.kernel(few.weight, 1.0 - lost, lost)
        # row m of the equations over the coupling: free flights then look the same for all m
        self._coupling = coupling(top, law.dimension)
        by_row = self._coupling[:, None, None]
        self._rise, self._loss, self._gain = rule.derivative / by_row, loss / by_row, gain / by_row
        # the gain from far below, of (T times the ratio here)^j, per T^j of a_m: (terms + 1, m)
        self._far_ratio = math.exp(-count * rule.width)
        self._far = np.zeros((_TERMS + 1, top + 1))
        if not near.all():
            diagonal = np.arange(rule.nodes)
            many = q.part(~near)
            self._loss[:, diagonal, diagonal] += many.weight.sum() / self._coupling[:, None]
            with np.errstate(under="ignore"):
                ratio = many.ratio / self._far_ratio  # at most 1, as powers of T overflow
                above = ratio > _NO_POWER
                powers = many.weight[above] * ratio[above] ** np.arange(1, _TERMS + 1)[:, None]
            for m, lost_ in enumerate(many.harmonic_losses(top)):
                harmonic = 1.0 - lost_
                self._far[0, m] = many.weight @ harmonic / self._coupling[m]
                self._far[1:, m] = powers @ harmonic[above] / self._coupling[m]
        self._returned: Returned | None = None
        if law.returns(0)[0]:
            self._returned = Returned(law, rule, self._loss, self._coupling)
            self._loss = self._returned.loss

    def run(self, count: int, tolerance: float, kept: int) -> Waves:
        """Up to ``count`` panels, each with as many harmonics as count there."""
        n, size, local = self.rule.nodes, self.wave_numbers.size, self.rule.local * self.rule.width
        gain, recent = self._near_gain(tolerance)
        reach = gain.shape[2] // n
        series = self._coefficients()
        collided = self._collided(series)
        far = collided * self._far[:, :, None]
        # what collisions act on, (panels, m, nodes, n_k): the products with the kernels are over
        # whole blocks then
        table = np.zeros((reach + min(count, _PANELS), self.top + 1, n, size))
        table[:reach] = self._below(collided, reach)
        largest = np.zeros(reach + count)  # of each panel
        largest[:reach] = np.abs(table[:reach]).max(axis=(1, 2, 3), initial=0.0)
        known = series_sum(series, np.exp(np.array([self.start])))[0]
        values: list[FloatArray] = []
        ended = False
        used, systems, left_out = 0, 0, np.zeros(count)
        for j in range(count):
            if reach + j == table.shape[0]:
                table = np.concatenate([table, np.zeros_like(table)])
            rate = np.exp(self.start + j * self.rule.width + local)
            used = self._panel_harmonics(known, used, rate, tolerance, kept)
            drive = self._drive(gain, table[j : j + reach, : used + 1], far[:, : used + 1], rate)
            found = self._solve_panel(rate, drive, known[: used + 1], tolerance)
            systems += (used + 1) * size
            panel = table[reach + j]
            panel[: used + 1] = found
            known = panel[:, -1].copy()
            values.append(panel[: kept + 1].copy())
            if self._returned is not None:
                panel[: used + 1] = self._returned.collided(found)
            # what the highest harmonic misses goes back to m = 0 as weakened as it came
            miss = float(np.abs(found[used]).max())
            left_out[j] = miss if kept else miss**2
            largest[reach + j] = np.abs(found).max()
            # nothing that follows is larger than the mean over what collisions lead to it from
            if (
                recent @ largest[reach + j + 1 - recent.size : reach + j + 1]
                < _NEGLIGIBLE * tolerance
            ):
                ended = True
                break
        last = self._last_coefficients(np.array(values))
        errors = together(last) + left_out[: j + 1]
        errors = carried(errors, largest[reach : reach + j + 1])
        return Waves(
            self.wave_numbers,
            self.rule,
            self.start,
            np.array(values),
            series[:, : kept + 1].copy(),
            ended,
            float(last.max()) + float(left_out.max()),
            errors,
            systems,
        )

    def _drive(
        self, gain: FloatArray, below: FloatArray, far: FloatArray, rate: FloatArray
    ) -> FloatArray:
        """What drives a panel over the coupling, (m, nodes, n_k), with T = rate at its nodes.

        below : the panels that the gain comes from, (reach, m, nodes, n_k)
        far : coefficients of what comes from farther down, (terms, m, n_k)
        """
        reach, used, n, size = below.shape
        drive = np.zeros((used, n, size))
        if reach:
            below = np.moveaxis(below, 0, 1).reshape(used, reach * n, size)
            drive = rate[:, None] * (gain[:used] @ below)
        if self._far.any():
            come = series_sum(far, self._far_ratio * rate)
            drive += rate[:, None] * np.moveaxis(come, 1, 0)
        if self._returned is not None:
            drive = rate[:, None] * self._returned.drive(drive / rate[:, None])
        return drive

    def _collided(self, series: FloatArray) -> FloatArray:
        """Coefficients of T^j in what collisions act on: a_m, or b of `returned`."""
        if self._returned is None:
            return series
        powers = np.arange(_TERMS + 1.0)
        loss = np.stack([self.law.harmonic_decay_rate(powers, m) for m in range(self.top + 1)])
        psi = -loss.T[:, :, None] * series
        self._returned.start(self._below(psi, self._returned.reach))
        back = np.array([self.law.returns(m)[0] for m in range(self.top + 1)])
        back = back * np.exp(-powers * self.law.returns(0)[1])[:, None]
        return np.asarray(series + back[:, :, None] * psi)

    def _near_gain(self, tolerance: float) -> tuple[FloatArray, FloatArray]:
        """The gain from the panels that matter, and the shares of the collisions out of each.

        Next to nothing comes from farther down, where e is about 0.
        """
        recent = _shares(self.law, self.rule.width, self._gain.shape[2] // self.rule.nodes)
        far = np.count_nonzero(np.cumsum(recent) < _NEGLIGIBLE * tolerance)
        return self._gain[:, :, far * self.rule.nodes :], recent[far:]

    def _coefficients(self) -> FloatArray:
        """Of T^j in a_m, shape (terms, top + 1, n_k)."""
        q = self.law.quadrature_for(float(_TERMS), self.top)
        powers = q.weight[:, None] * np.exp(-np.outer(q.log_loss, np.arange(_TERMS)))
        loss = 1.0 - np.stack([(1.0 - lost) @ powers for lost in q.harmonic_losses(self.top)])
        loss = np.stack([self.law.met_again(np.arange(_TERMS), r, m) for m, r in enumerate(loss)])
        loss[0] = self.law.decay_rate(np.arange(_TERMS))
        out = np.zeros((_TERMS + 1, self.top + 1, self.wave_numbers.size))
        out[0, 0] = 1.0
        for j in range(_TERMS):
            a = out[j]
            coupled = np.zeros_like(a)
            coupled[1:] += a[:-1]
            coupled[:-1] -= a[1:]
            coupled[0] -= a[1]
            coupled *= self._coupling[:, None]
            out[j + 1] = (0.5 * self.wave_numbers * coupled - loss[:, j, None] * a) / (j + 1.0)
        return out

    def _below(self, series: FloatArray, reach: int) -> FloatArray:
        """a_m on the panels below the first, by the series, (reach, top + 1, nodes, n_k)."""
        below = (np.arange(reach) - reach)[:, None] * self.rule.width
        x = self.start + below + self.rule.local * self.rule.width
        found = series_sum(series, np.exp(x.ravel()))
        return np.moveaxis(found.reshape(*x.shape, *found.shape[1:]), 2, 1)

    def _panel_harmonics(
        self, known: FloatArray, used: int, rate: FloatArray, tolerance: float, kept: int
    ) -> int:
        """The last harmonic of a panel that begins with a_m = known (m, n_k): even.

        used : that of the panel below; rate : T at the nodes
        """
        size = np.abs(known).max(axis=1)

        def last_above(least: float) -> int:
            return int(np.flatnonzero(size > least).max(initial=0))

        # what comes back to m = 0 is the square at most; those that are kept matter themselves
        rising = 0.1 * tolerance if kept else tolerance**_RISING
        flights = float(self.wave_numbers.max()) * (rate[-1] - rate[0])  # they reach m = K T
        more = _MORE + int(flights if kept else min(_MOST_MORE, flights))
        needed = max(last_above(rising) + more, min(used, last_above(tolerance)))
        return min(self.top, _even(needed))

    def _solve_panel(
        self, rate: FloatArray, drive: FloatArray, known: FloatArray, tolerance: float
    ) -> FloatArray:
        """One panel: shape (m, nodes, n_k).

        rate : T at the nodes; drive : the gain from below, shape (m, nodes, n_k); known : a_m at
        the first node, shape (m, n_k). The number of harmonics is odd.
        """
        count, flights = drive.shape[0], rate[-1] - rate[0]
        rate = rate[1:]
        scale = 1.0 / np.maximum(1.0, rate)
        blocks: FloatArray = (
            self._rise[:count, 1:] * scale[:, None]
            + (rate * scale)[:, None] * self._loss[:count, 1:]
        )
        right = drive[:, 1:] * scale[:, None] - blocks[:, :, :1] * known[:, None]
        blocks, turn = np.ascontiguousarray(blocks[:, :, 1:]), 0.5 * rate * scale
        inner = None
        if float(self.wave_numbers.max()) * flights < _FEW_TURNS:
            inner = iterate(blocks, turn, right, self.wave_numbers, 1e-3 * tolerance)
        if inner is None:
            inner = eliminate(blocks, turn, right, self.wave_numbers)
        return np.concatenate([known[:, None], inner], axis=1)

    def _last_coefficients(self, values: FloatArray) -> FloatArray:
        """What the Chebyshev coefficients leave out, by their last two, (n_panels, n_kept, n_k)."""
        last, before = self.rule.last_coefficients(np.moveaxis(values, 2, 3))
        fall = np.minimum(1.0, (last + 1e-17) / (before + 1e-17))
        return np.asarray(last * np.sqrt(fall))


def _shares(law: CollisionLaw, width: float, reach: int) -> FloatArray:
    """Shares of the collisions that come out of the last panels, farthest first."""
    if reach == 0:
        return np.ones(1)
    panel = np.minimum(law.quadrature.log_loss / width, reach - 1.0).astype(int)
    return np.bincount(panel, law.quadrature.weight, reach)[::-1]

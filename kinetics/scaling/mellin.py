r"""The density of x = ln(kappa Y), Y = v t/l, by Mellin inversion of its moments A(z).

v is the speed, t the time, l the mean free path and kappa = E[-ln s], s the speed ratio of a
collision. The density g(x) has the exponential moments A(z) (:mod:`kinetics.scaling.log_moments`).
Along the vertical line Re z = a,

    e^(a x) g(x) = (1/2 pi) int A(a + i k) e^(-i k x) dk,

and the left side, over A(a), is the tilted density, which is of the order of one where a is the
saddle point of x. Each x is served by the line whose tilted density has x near its middle, so that
the error is relative to g itself in both tails. Begin with :class:`MellinInversion`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.numerics import FOLDS, LARGEST_LOG, ComplexArray, FloatArray, one_blas_thread
from kinetics.results.value import Value
from kinetics.scaling.log_moments import (
    log_moment,
    log_moment_along_line,
    log_second_moment,
    small_deviation,
)

#: How far from its centre a line serves, in its deviations, and half of the way to the next one.
#: Chosen: the sum of the line loses e^(1.25^2/2) = 2, and 4 between lines of different deviations.
REACH_IN_DEVIATIONS = 1.25
#: The same where the largest loss of a bounce is below a deviation: the tilted density is nearly
#: Gaussian there. Chosen: the sum of the line loses e^(2.4^2/2) = 18.
REACH_NEAR_GAUSSIAN = 2.4
#: Largest loss -ln s above which lines on the left are closer: where a bounce may leave e^-5 of the
#: speed, the tilted density changes between two lines. Chosen: at half and at twice of each F moves
#: by 3e-14 at most (e from 0 to 0.99, c from 0.01 to 8).
DEEP_LOSS = 5.0
#: Largest distance of their exponents there; origin as of `DEEP_LOSS`.
MAX_STEP_AT_DEEP_LOSS = 0.4
#: Smallest share of the sum of its terms' sizes that the sum of a line may have: below, it has lost
#: two digits, and the next line serves. Chosen.
MIN_SHARE_OF_TERMS = 0.02
#: Distance of the lowest line from the lowest power of a law, where g is a power of the speed low
#: down. Chosen: lines closer to it would need ever more samples, and this one loses e^(0.25 |x|),
#: 2e4 at v t = 1e-17 l.
DISTANCE_TO_LOWEST_POWER = 0.25

#: Tilts, over 1/deviation, at which Chernoff's bound of the tilted density is taken. Chosen: at
#: half and at twice of those F moves by 8e-14 at most, where it was measured for `DEEP_LOSS`.
CHERNOFF_TILTS = np.array([0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0])
#: Step of the differences of ln A that give the mean and the deviation, over 1/deviation or over
#: the distance to the lowest power; origin as of `CHERNOFF_TILTS`.
DIFFERENCE_STEP = 0.2
#: One more tilt to the left, over the step of the differences; origin as of `CHERNOFF_TILTS`.
SMALLEST_TILT = 2.5
#: Largest -p ln s at which E[s^p] is computed. Chosen: near 710 it overflows.
MAX_LOG_OF_POWER = 600.0
#: Smallest number of samples of a line. Chosen: at half and at twice F moves by 5e-14.
MIN_SAMPLES = 32
#: Samples that are kept beyond the last one that counts. Chosen: at half and at twice F moves by
#: 7e-15.
SPARE_SAMPLES = 4
#: Smallest sum of a line of which the logarithm is taken. Chosen: F is 0 in double precision there.
MIN_SUM = 1e-300

#: Tilts, over 1/deviation, at which :func:`extent_of` takes Chernoff's bound. Measured: from half
#: the least, or to twice the largest, F does not move.
EXTENT_TILTS = np.geomspace(0.3, 60.0, 24)
#: Step of the wave number of :func:`extent_of`, over 1/deviation. Measured: at half and at twice F
#: does not move.
EXTENT_STEP = 0.5
#: Number of steps from which on :func:`extent_of` does not look further. Measured: at half and at
#: twice F does not move.
MAX_EXTENT_STEPS = 1000


@dataclass(frozen=True, eq=False, repr=False)
class MellinLine(Value):
    """A on the line Re z = a, and the tilted density e^(a x) g(x)/A(a) to which it belongs.

    Parameters
    ----------
    exponent : a
    log_moment : ln A(a)
    centre, deviation : mean and standard deviation of x under the tilted density
    reach : how far from its centre it serves
    step : the distance of two samples
    samples : A(a + i n step)/A(a), n = 0, 1, ..., shape (n_samples,)
    """

    exponent: float
    log_moment: float
    centre: float
    deviation: float
    reach: float
    step: float
    samples: ComplexArray

    @property
    def distance_to_next(self) -> float:
        """The distance of the exponents of two lines that are two reaches apart."""
        return 2.0 * self.reach / self.deviation**2

    def sum_at(self, x: FloatArray) -> FloatArray:
        """Return the sum of the samples times e^(-i k (x - centre)), shape of x (n,)."""
        k = self.step * np.arange(self.samples.size)
        turn = np.exp(-1j * np.outer(x - self.centre, k))
        # the phase of the centre is taken out of the samples: no large arguments. Without BLAS,
        # whose threads would wait for each other
        rotated = self.samples * np.exp(-1j * k * self.centre)
        return np.asarray(2.0 * np.einsum("ij,j", turn, rotated).real - 1.0)

    @property
    def sum_of_sizes(self) -> float:
        """The sum of the sizes of the terms of :meth:`sum_at`."""
        return float(2.0 * np.abs(self.samples).sum() - 1.0)

    def log_density(self, x: FloatArray, sum_at_x: FloatArray) -> FloatArray:
        """Return ln g(x), shape of x, from :meth:`sum_at`."""
        tilted = sum_at_x * self.step / (2.0 * math.pi)
        return np.log(np.maximum(tilted, MIN_SUM)) + self.log_moment - self.exponent * x


class MellinInversion:
    """ln g(x) of one law; it keeps the lines that were needed so far, and is safe on threads.

    The lines lie side by side from the smallest to the largest x that was asked for: a few hundred
    reach from where F is the least positive double on one side to the same on the other.
    """

    def __init__(self, law: CollisionLaw) -> None:
        self._law = law
        self._lines: tuple[MellinLine, ...] = ()  # by their exponents, never changed in place
        self._lock = Lock()

    def log_density(self, x: FloatArray) -> FloatArray:
        """Return ln g(x), shape (n,); -inf where F ~ g/c^d is 0.

        It is NaN where a medium makes g unknown: at speeds that only powers below the lowest one
        resolve.
        """
        if x.size == 0:
            return np.zeros(0)
        lines = self._lines_around(float(x.min()), float(x.max()))
        log_g = np.full(x.shape, -math.inf)
        serving = _serving_line(lines, x)
        for i, line in enumerate(lines):
            served = np.nonzero(serving == i)[0]
            total = line.sum_at(x[served])
            if i + 1 < len(lines):
                # near e = 0 little may be left of the tilted density above its centre
                has_lost_digits = total < MIN_SHARE_OF_TERMS * line.sum_of_sizes
                has_lost_digits &= x[served] > line.centre
                serving[served[has_lost_digits]] = i + 1
                served = served[~has_lost_digits]
                total = total[~has_lost_digits]
            log_g[served] = line.log_density(x[served], total)
        log_g[x > lines[-1].centre + lines[-1].reach] = -math.inf
        if not self._law.reaches_rest:
            is_unknown = math.isfinite(self._law.lowest_power)
            lowest = lines[0].centre - 2.0 * REACH_IN_DEVIATIONS * lines[0].deviation
            log_g[x < lowest] = math.nan if is_unknown else -math.inf
        return log_g

    def _lines_around(self, lowest: float, highest: float) -> tuple[MellinLine, ...]:
        """Return lines that serve from the lowest to the highest x, or to where F is 0."""
        with self._lock:
            lines = self._lines
            if not lines or not lines[0].centre < lowest <= highest < lines[-1].centre:
                self._lines = _extended(self._law, lines, lowest, highest)
            return self._lines


def _serving_line(lines: tuple[MellinLine, ...], x: FloatArray) -> NDArray[np.intp]:
    """Return the index of the line that serves each x, shape (n,)."""
    borders = []
    for lower, upper in pairwise(lines):  # where x is as many deviations off both
        between = lower.centre * upper.deviation + upper.centre * lower.deviation
        borders.append(between / (lower.deviation + upper.deviation))
    return np.searchsorted(np.array(borders), x)


@one_blas_thread
def _extended(
    law: CollisionLaw, lines: tuple[MellinLine, ...], lowest: float, highest: float
) -> tuple[MellinLine, ...]:
    """Return the lines with more on each side, until both x are served or F is 0 there."""
    if not lines:
        lines = (_line_at(law, 0.0, math.sqrt(log_second_moment(law)), MIN_SAMPLES),)
    while lines[-1].centre + lines[-1].reach < highest and _has_density(law, lines[-1]):
        lines = (*lines, _line_beside(law, lines[-1], lines[-1].distance_to_next))
    while lines[0].centre - lines[0].reach > lowest and _has_density(law, lines[0]):
        step = _step_to_the_left(law, lines[0])
        if step <= 0.0:
            break
        lines = (_line_beside(law, lines[0], -step), *lines)
    return lines


def _has_density(law: CollisionLaw, line: MellinLine) -> bool:
    """Return whether F may be above 0 at the centre of a line, by Chernoff's bound."""
    log_g = line.log_moment - line.exponent * line.centre  # g is not larger
    return log_g - law.dimension * line.centre > -LARGEST_LOG - FOLDS


def _step_to_the_left(law: CollisionLaw, line: MellinLine) -> float:
    """Return by how much the next line on the left has a lower exponent; not above 0: none."""
    step = line.distance_to_next
    if law.largest_loss > DEEP_LOSS:
        step = min(step, MAX_STEP_AT_DEEP_LOSS)
    return min(step, line.exponent - law.lowest_power - DISTANCE_TO_LOWEST_POWER)


def _line_beside(law: CollisionLaw, line: MellinLine, step: float) -> MellinLine:
    """Return the line whose exponent is larger by a step."""
    return _line_at(law, line.exponent + step, line.deviation, line.samples.size)


def _line_at(law: CollisionLaw, a: float, deviation: float, n_samples: int) -> MellinLine:
    """Return the line Re z = a, in steps that resolve the tilted density.

    Parameters
    ----------
    a : the exponent
    deviation, n_samples : about the deviation of x, and how many samples the line takes
    """
    # E[s^p] overflows further down: bounds from there are not needed
    deepest_power = min(MAX_LOG_OF_POWER / float(law.quadrature.log_loss.max()), -law.lowest_power)
    h = DIFFERENCE_STEP * min(1.0 / deviation, a - law.lowest_power)
    right_tilts = CHERNOFF_TILTS / deviation
    left_tilts = np.append(right_tilts, SMALLEST_TILT * h)
    left_tilts = left_tilts[left_tilts - a < deepest_power]
    log_moments = log_moment(
        law, np.concatenate([[a, a + h, a - h], a + right_tilts, a - left_tilts])
    )
    log_a = float(log_moments[0])
    rise, fall = log_moments[1:3] - log_a
    # Chernoff: where the tilted density is negligible on either side
    of_right, of_left = np.split(log_moments[3:] - log_a, [right_tilts.size])
    right_end = float(np.min((of_right + FOLDS) / right_tilts))
    left_end = float(np.max(-(of_left + FOLDS) / left_tilts))
    step = 2.0 * math.pi / (right_end - left_end)
    deviation_there = math.sqrt(rise + fall) / h
    is_nearly_gaussian = law.largest_loss < deviation_there
    reach = REACH_NEAR_GAUSSIAN if is_nearly_gaussian else REACH_IN_DEVIATIONS
    return MellinLine(
        exponent=a,
        log_moment=log_a,
        centre=float(rise - fall) / (2.0 * h),
        deviation=deviation_there,
        reach=deviation_there * reach,
        step=step,
        samples=_sample_line(law, a, step, n_samples),
    )


def _sample_line(law: CollisionLaw, a: float, step: float, n_samples: int) -> ComplexArray:
    """Return A(a + i n step)/A(a), n = 0, 1, ..., until it is negligible.

    Parameters
    ----------
    a, step : the exponent of the line and the distance of its samples
    n_samples : about how many it takes
    """
    negligible = math.exp(-FOLDS)
    samples = np.ones(1, dtype=complex)
    n_next = n_samples
    while np.max(np.abs(samples[-SPARE_SAMPLES:])) >= negligible:
        begin = a + 1j * step * (samples.size - 1)
        growth = np.exp(log_moment_along_line(law, begin, step, n_next + 1)[1:])
        samples = np.append(samples, samples[-1] * growth)
        n_next = max(MIN_SAMPLES, samples.size // 2)
    last_counting = int(np.flatnonzero(np.abs(samples) >= negligible)[-1])
    return samples[: max(MIN_SAMPLES, last_counting + 1 + SPARE_SAMPLES)]


@lru_cache(maxsize=4)  # all harmonics of a scene ask for the same
def extent_of(law: CollisionLaw, depth: float) -> tuple[float, float]:
    """Return where the scaling state ends, to the density of a distribution in time.

    Returns
    -------
    ln(v t/l) above which the state weighs e^-depth; and the wave number at which the transform of
    its density, A(i k), is that small
    """
    deviation = small_deviation(law)
    p = EXTENT_TILTS / deviation
    # Chernoff's bound; a density of x falls as e^-(e^x): its own factor e^x is e^5 at most
    right_end = float(np.min((log_moment(law, p) + depth + 5.0) / p))
    step = EXTENT_STEP / deviation
    count = MIN_SAMPLES
    log_size = log_moment_along_line(law, 0.0, step, count).real
    while log_size[-1] > -depth and count < MAX_EXTENT_STEPS:
        count *= 2
        log_size = log_moment_along_line(law, 0.0, step, count).real
    highest_wave_number = step * float(np.count_nonzero(log_size > -depth))
    return right_end - math.log(law.mean_log_loss), highest_wave_number

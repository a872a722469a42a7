"""Averages over an initial state: one smooth function of v t for each observable (`backward`).

Those of the displacement come from the equation with its free-streaming term (paper, label
``inelaslorentz``), as chains of scalar equations; no profile in space is needed.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.moments.backward import (
    DISPLACEMENT_ALONG_START,
    MEAN_COLLISIONS,
    MSD_SLOPE,
    SQUARED_DISPLACEMENT,
    START,
    STEEPEST,
    BackwardEquation,
    Observable,
    quartic_displacement,
    speed_power,
)
from kinetics.moments.delayed import DelayedReturns
from kinetics.numerics import LARGEST_LOG, FloatArray
from kinetics.numerics.chebyshev import Chebyshev, panel_rule
from kinetics.states.state import LogMeasure, State
from kinetics.validation import MAX_HARMONICS, real_number, whole_number

_PIECE = 5000  # points at once, so that their interpolation weights stay in the cache


@dataclass(frozen=True)
class Averages:
    """Averages over an initial state, at given times.

    mean_free_path in d, times (n_times,) in d/U; degree, lowest, harmonic: largest and smallest
    power of the speed and largest angular harmonic that will be asked for; nodes: of a panel of
    the backward equation, by default from rtol and degree. What is kept: harmonics of the start,
    and powers by p and m and matrices by the points that they average over.
    """

    law: CollisionLaw
    mean_free_path: float
    state: State
    times: FloatArray
    rtol: float
    degree: float = 4.0
    lowest: float = 0.0
    nodes: int | None = None
    harmonic: int = 2
    _measures: dict[int, LogMeasure | None] = field(default_factory=dict, init=False, compare=False)
    _kept: dict[Any, NDArray[Any]] = field(default_factory=dict, init=False, compare=False)

    def with_nodes(self, nodes: int) -> Averages:
        """The same with so many nodes of a panel; the initial state is not made again."""
        other = replace(self, nodes=nodes)
        other._measures.update(self._measures)
        return other

    def _is_closed(self, y: Observable) -> bool:
        """Whether y has a closed form: speeds are kept, and a harmonic decays at one rate."""
        decays = not (y.harmonic and self.law.returns(0)[0])
        return self.law.is_elastic and y.is_power and decays

    def error_estimate(self, y: Observable) -> float:
        """Relative, of averages of y over all panels, that is over all times."""
        return 0.0 if self._is_closed(y) else self.equation.error_estimate(y)

    @cached_property
    def _fall(self) -> float:
        """-ln E[s^p], p = degree: by so much <v^p> may fall until a first bounce counts in it."""
        if self.degree <= 0.0:
            return 0.0
        return -math.log(max(float(self.law.mean_speed_ratio_power(self.degree)), 1e-300))

    def measure(self, m: int) -> LogMeasure | None:
        """Harmonic m of the initial state as weighted points; None where it is zero."""
        if m not in self._measures:
            # where <v^p> falls by more than e^4 before a bounce, slow tracers that have not
            # collided make what is left of it: a share of the start, 1e-26 at least
            share = math.exp(-min(self._fall, 60.0)) if self._fall > STEEPEST else 1.0
            self._measures[m] = self.state.harmonic(
                m, self.rtol * share, self.lowest, max(self.degree, 2.0)
            )
        return self._measures[m]

    @property
    def speeds(self) -> LogMeasure:
        """The initial speeds: harmonic 0, which is never zero."""
        found = self.measure(0)
        assert found is not None
        return found

    def start_error(self, harmonics: Collection[int]) -> float:
        """Relative error estimate of what is not resolved of these harmonics of the start."""
        measures = [self.measure(m) for m in harmonics]
        return max((measure.error for measure in measures if measure is not None), default=0.0)

    @cached_property
    def log_stretch(self) -> FloatArray:
        """ln(t/l) per time, -inf at t = 0, shape (n_times,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.times) - math.log(self.mean_free_path))

    @cached_property
    def log_reference(self) -> FloatArray:
        """ln of a speed of the order of the thermal one, (n_times,), as the unit of its powers."""
        return self._reference(self.log_stretch)

    @cached_property
    def log_first(self) -> float:
        """ln of the root mean square of the initial speeds."""
        return 0.5 * self.speeds.log_second_moment()

    def _reference(self, log_stretch: FloatArray) -> FloatArray:
        if self.law.is_elastic:
            return np.full(log_stretch.shape, self.log_first)
        return np.minimum(self.log_first, -log_stretch - math.log(self.law.mean_log_loss))

    @cached_property
    def equation(self) -> BackwardEquation:
        """The backward equation, up to the largest v t that occurs."""
        highest = max(float(self.speeds.x.max() + self.log_stretch[-1]), START)
        power = max(abs(self.degree), abs(self.lowest))
        width = max(STEEPEST / max(self._fall, STEEPEST), 1.0 / 32.0)  # more would take seconds
        width = min(STEEPEST / max(power, STEEPEST), width)
        # nodes for every law within one or two of what is needed, because a node is about a digit;
        # what is missing costs a second solve. Of higher powers narrower panels do the rest
        guess = 2.0 + 0.75 * min(power, 4.0) - 1.12 * math.log10(self.rtol)
        delayed = bool(self.law.returns(0)[0])
        nodes = self.nodes or math.ceil(guess) + 2 * delayed
        kind = DelayedReturns if delayed else BackwardEquation
        return kind(self.law, highest, nodes, width, self.harmonic, self.rtol)

    def power(self, p: float, m: int = 0) -> NDArray[Any]:
        """<(v/v_ref)^p exp(-i m phi)>, v_ref = exp(log_reference), shape (n_times,)."""
        if (p, m) not in self._kept:
            self._kept[p, m] = self.average(speed_power(p, m))
        return self._kept[p, m]

    def average(
        self, y: Observable, m: int | None = None, start: float = 0.0, leading: int = 0
    ) -> NDArray[Any]:
        """<(v(0)/v_first)^start y T^-n (v(0)/v_ref)^n exp(-i m phi)>, n = p + leading, (n_times,).

        Lengths in l; v_first is the root mean square of the initial speeds; m by default that of y.
        """
        found = self.measure(y.harmonic if m is None else m)
        if found is None:
            return np.zeros(self.times.shape)
        w = found.weight
        if start:
            w = w * np.exp(start * (found.x - self.log_first))
        if self._is_closed(y):
            # a speed is kept, and harmonic m relaxes at its own rate, 1 - E[cos(m chi)]
            with np.errstate(under="ignore", over="ignore"):
                kept = np.exp(y.degree * (found.x - self.log_reference[:, None]))
                if y.harmonic:
                    rate = self.law.harmonic_decay_rate(0.0, y.harmonic)
                    kept *= np.exp(-rate * np.exp(found.x + self.log_stretch[:, None]))
            return np.asarray(kept @ w)
        return self._at_times(LogMeasure(found.x, w), y, leading)

    def _at_times(self, points: LogMeasure, y: Observable, leading: int) -> NDArray[Any]:
        """The average at all times, (n_times,); where there are many, most by interpolation."""
        equation, width, p = self.equation, self.equation.width, y.degree + leading
        late = np.isfinite(self.log_stretch)
        stretch = self.log_stretch[late]
        # a node is about one digit: with two more a hundredth of rtol remains
        rule = panel_rule(equation.nodes + 2, width)
        level = (stretch + points.x.max() - equation.start) / width
        which = np.ceil(level).astype(int) - 1
        first, count = (int(which[0]), int(which[-1] - which[0]) + 1) if which.size else (0, 0)
        reach = 2 + int((points.x.max() - points.x.min()) / width)
        if rule.nodes * (points.x.size + count * reach) >= points.x.size * stretch.size:
            return self._at(points, y, leading, self.log_stretch)
        # powers of T as their unit, where each panel begins; v_ref has a kink in ln t
        panel = first + 1 - reach + np.arange(count + reach - 1)
        begin = equation.start + width * panel
        x = begin[:, None] + width * equation.rule.local
        value, low = equation.at(y, x, leading)
        low_begin = np.where(panel < 0, begin, 0.0)
        unit = begin[reach - 1 :] - points.x.max()
        unit += self._reference(unit)
        window = np.arange(count)[:, None] + np.arange(reach)
        with np.errstate(under="ignore", over="ignore", invalid="ignore"):
            value *= np.exp(p * (np.where(low, x, 0.0) - low_begin[:, None]))
            scale = np.exp(p * (low_begin[window] - unit[:, None]))
        key = points.x.tobytes(), points.weight.tobytes()
        if key not in self._kept:  # most observables of a scene share them
            self._kept[key] = self._rows_of(points, rule, reach)
        values = (value[window] * scale[:, :, None]).reshape(count, -1) @ self._kept[key]
        back = np.exp(p * (unit[which - first] - stretch - self._reference(stretch)))
        out = np.empty(self.times.shape, dtype=values.dtype)
        out[late] = np.einsum("ij,ij->i", rule.rows(level - which), values[which - first]) * back
        out[~late] = self._at(points, y, leading, self.log_stretch[~late])
        return out

    def _rows_of(self, points: LogMeasure, rule: Chebyshev, reach: int) -> NDArray[Any]:
        """The average at the nodes of a panel in ln t from y in so many panels up to that in X."""
        inner, order = self.equation.rule, np.argsort(points.x)
        out = np.zeros((rule.nodes * reach, inner.nodes), dtype=points.weight.dtype)
        for part in np.array_split(order, 1 + order.size * rule.nodes // _PIECE):
            place = rule.local[:, None] + (points.x[part] - points.x.max()) / self.equation.width
            below = np.minimum(np.floor(place), 0.0)
            rows = inner.shares((place - below).ravel())
            weight = np.tile(points.weight[part], rule.nodes) / np.einsum("ij->i", rows)
            into = np.arange(1, rule.nodes + 1)[:, None] * reach - 1 + below.astype(int)
            found, begin = np.unique(into, return_index=True)  # it rises
            out[found] += np.add.reduceat(weight[:, None] * rows, begin, axis=0)
        return out.reshape(rule.nodes, -1).T

    def _at(
        self, points: LogMeasure, y: Observable, leading: int, log_stretch: FloatArray
    ) -> NDArray[Any]:
        """The average at these ln(t/l), (n,)."""
        x, w, p = points.x, points.weight, y.degree + leading
        out = np.empty(log_stretch.shape, dtype=w.dtype)
        # in pieces of the time axis, so that memory stays flat
        piece = max(1, _PIECE // x.size)
        for first in range(0, log_stretch.size, piece):
            stretch = log_stretch[first : first + piece, None]
            reference = self._reference(stretch)
            value, low = self.equation.at(y, x + stretch, leading)
            with np.errstate(under="ignore", over="ignore", invalid="ignore"):
                unit = np.where(low, x, -stretch) - reference
                out[first : first + piece] = (value * np.exp(p * unit)) @ w
        return out


# -- outputs ---------------------------------------------------------------------------------------


class Part(NamedTuple):
    """One observable of the backward equation that an output is made of."""

    factor: float  # how often its relative error enters that of the output
    observable: Observable
    start: int  # harmonic of the initial state over which it is averaged


@cache
def parts_of(output: str, dimension: int) -> tuple[Part, ...]:
    """What an output of this file is made of; nothing for other outputs."""
    square, along = speed_power(2.0), speed_power(1.0, 1)
    pairs = {
        "thermal_speed": [(0.5, square)], "temperature": [(1.0, square)],
        "a2": [(2.0, square), (1.0, speed_power(4.0))], "mean_velocity": [(1.0, along)],
        "velocity_tensor": [(1.0, square), (1.0, speed_power(2.0, 2))],
        "collisions": [(1.0, MEAN_COLLISIONS)], "msd": [(1.0, SQUARED_DISPLACEMENT)],
        "kurtosis": [(2.0, SQUARED_DISPLACEMENT), (1.0, quartic_displacement(dimension))],
        "velocity_autocorrelation": [(1.0, along)], "diffusion_coefficient": [(1.0, MSD_SLOPE)],
        "mean_displacement": [(1.0, DISPLACEMENT_ALONG_START)],
    }.get(output, [])  # fmt: skip
    # <v(0).v> is over all initial velocities: v(0) itself takes the direction out
    own = output != "velocity_autocorrelation"
    return tuple(Part(factor, y, y.harmonic * own) for factor, y in pairs)


def moment_arguments(law: CollisionLaw, state: State, p: Any, m: Any) -> tuple[float, int]:
    """p and m of <v^p exp(-i m phi)>; InputError out of range, or where it does not exist."""
    p = real_number("p", p, -40.0, 40.0)
    m = whole_number("m", m, 0, MAX_HARMONICS)
    lowest = max(state.lowest_moment, law.lowest_power)
    if p <= lowest:
        raise InputError(f"p: got {p!r}; moments of this scene exist for p > {lowest:g} only")
    return p, m


def thermal_speed(averages: Averages) -> FloatArray:
    """v0 = sqrt(<v^2>) in U, shape (n_times,) (paper, label ``v0defi``)."""
    return np.asarray(np.exp(averages.log_reference) * np.sqrt(averages.power(2.0)))


def temperature(averages: Averages) -> FloatArray:
    """<v^2>/d in m U^2, shape (n_times,) (paper, label ``thermo``)."""
    square = np.exp(averages.log_reference) ** 2 * averages.power(2.0)
    return np.asarray(square / averages.law.dimension)


def a2(averages: Averages) -> FloatArray:
    """<v^4> d/((d+2) <v^2>^2) - 1, shape (n_times,) (paper, label ``sonine5``)."""
    gaussian = averages.law.dimension / (averages.law.dimension + 2.0)
    return np.asarray(gaussian * averages.power(4.0) / averages.power(2.0) ** 2 - 1.0)


def mean_velocity(averages: Averages) -> FloatArray:
    """(<v_x>, <v_y>) in U, shape (n_times, 2), from harmonic 1; in space (n_times, 3)."""
    return as_vector(averages.law, np.exp(averages.log_reference) * averages.power(1.0, 1))


def as_vector(law: CollisionLaw, along: NDArray[Any]) -> FloatArray:
    """The vector whose harmonic 1 is ``along``, (n_times,): (n_times, 2), in space (n_times, 3)."""
    found = np.zeros((along.size, law.dimension))
    found[:, 0], found[:, 1] = along.real, -along.imag  # in space it is real
    return found


def velocity_tensor(averages: Averages) -> FloatArray:
    """<v_i v_j> in U^2, shape (n_times, 2, 2), from harmonics 0 and 2; in space (n_times, 3, 3)."""
    square = np.exp(averages.log_reference) ** 2
    trace, second = square * averages.power(2.0), square * averages.power(2.0, 2)
    d = averages.law.dimension
    tensor = np.zeros((averages.times.size, d, d))
    tensor[:, 0, 0] = (trace + (d - 1.0) * second.real) / d
    for i in range(1, d):  # in space the rest is shared by y and z
        tensor[:, i, i] = (trace - second.real) / d
    tensor[:, 0, 1] = tensor[:, 1, 0] = -0.5 * second.imag  # in space 0
    return tensor


def collisions(averages: Averages) -> FloatArray:
    """Mean number of collisions of a tracer since t = 0, shape (n_times,)."""
    return np.asarray(averages.average(MEAN_COLLISIONS))


def _flown(averages: Averages) -> FloatArray:
    """v_ref t in d, (n_times,): averages of T^-n y times its n-th power do not underflow early."""
    return np.asarray(np.exp(averages.log_reference) * averages.times)


def root_mean_square(averages: Averages) -> FloatArray:
    """sqrt(<r^2>)(t) in d, shape (n_times,); also where <r^2> is out of range."""
    square = averages.average(SQUARED_DISPLACEMENT, leading=2)
    return np.asarray(np.sqrt(square) * _flown(averages))


def msd(averages: Averages) -> FloatArray:
    """<r^2>(t) in d^2, shape (n_times,)."""
    with np.errstate(over="ignore", under="ignore"):
        return root_mean_square(averages) ** 2


def kurtosis(averages: Averages) -> FloatArray:
    """<r^4>/<r^2>^2, shape (n_times,); at t = 0 its limit, <v^4>/<v^2>^2."""
    if averages.law.is_elastic:  # late it stands still, and fourth powers of v t/l overflow
        last = LARGEST_LOG / 6.0 - averages.log_first + math.log(averages.mean_free_path)
        if averages.times[-1] > (last := math.exp(min(last, LARGEST_LOG))):
            averages = replace(averages, times=np.minimum(averages.times, last))
    second = averages.average(SQUARED_DISPLACEMENT, leading=2)
    fourth = averages.average(quartic_displacement(averages.law.dimension), leading=4)
    return np.asarray(fourth / second**2)


def velocity_autocorrelation(averages: Averages) -> FloatArray:
    """<v(0) . v(t)> in U^2, shape (n_times,); negative where most bounces go backwards."""
    found = averages.average(speed_power(1.0, 1), m=0, start=1.0)
    return np.asarray(found * np.exp(averages.log_first + averages.log_reference))


def diffusion_coefficient(averages: Averages) -> tuple[FloatArray, FloatArray]:
    """D(t) = d<r^2>/dt/(2 d) in d U, and the slope d<r^2>/d ln t in d^2, (n_times,) each.

    The elastic D tends to (3/8) l <v> in the plane and (1/3) l <v> in space; tracers that cool have
    a slope that tends to 2 l^2/(kappa (1 - <cos chi>)).
    """
    mean, flown = averages.average(MSD_SLOPE, leading=1), _flown(averages)
    with np.errstate(over="ignore", under="ignore"):
        speed = np.exp(averages.log_reference) / (2.0 * averages.law.dimension)
        return mean * flown * speed, mean * flown * flown


def mean_displacement(averages: Averages) -> FloatArray:
    """<r>(t) of a directed start in d, shape (n_times, 2), in space (n_times, 3)."""
    along = averages.average(DISPLACEMENT_ALONG_START, leading=1)
    return as_vector(averages.law, along * _flown(averages))

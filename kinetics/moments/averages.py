"""Averages over an initial state: of each observable, one smooth function of v t (`backward`).

    <y>(t) = sum_k w_k (v_k/l)^p f(v_k t/l),     y(X) = T^p f(T),  T = e^X

over the initial speeds v_k with their weights w_k, for each observable y of the backward equation;
l is the mean free path, p the power of the speed of y, and f a function of T alone. Times are in
d/U, lengths in d, and speeds in U: d is the contact distance, U the unit of speed. Those of the
displacement come from the equation with its free-streaming term (paper, label ``inelaslorentz``),
as chains of scalar equations; no profile in space is needed. Begin with `Averages.average`; which
averages an output is made of is in `outputs`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.moments.backward import MAX_LOG_CHANGE_ON_PANEL, START, BackwardEquation
from kinetics.moments.delayed_equation import DelayedBackwardEquation
from kinetics.moments.observables import Observable, speed_power
from kinetics.moments.point_average import PointAverage, ReferenceSpeed
from kinetics.moments.start import StartHarmonics
from kinetics.numerics import FloatArray, NumberArray
from kinetics.numerics.cache import Cache
from kinetics.states.state import LogMeasure, State
from kinetics.validation import MAX_HARMONICS, real_number, whole_number

#: Least power p of a moment <v^p> that can be asked for. Chosen: far beyond what data give.
LEAST_POWER = -40.0
#: Largest power p of such a moment. Chosen.
LARGEST_POWER = 40.0
#: Least E[s^p] of which the logarithm is taken: close to the smallest number.
LEAST_MEAN_POWER = 1e-300
#: Most e-folds by which <v^p> may fall before a first bounce counts: averages over the start are
#: then right to 1e-26 of rtol, so that slow tracers, which have not collided, are resolved. Origin
#: not recorded.
MAX_FALL_OF_START = 60.0
#: The narrowest panel, in X. Chosen: narrower ones would take seconds.
NARROWEST_PANEL = 1.0 / 32.0

#: The nodes of a panel are BASE_NODES + NODES_PER_POWER (p, at most MAX_POWER_OF_NODES) +
#: NODES_PER_DIGIT (digits of rtol), and ADDED_NODES_IF_DELAYED in a medium. Measured: for every law
#: within one or two of what is needed, because a node is about a digit; what is missing costs a
#: second solution. Of higher powers narrower panels do the rest.
BASE_NODES = 2.0
#: See `BASE_NODES`.
NODES_PER_POWER = 0.75
#: See `BASE_NODES`.
MAX_POWER_OF_NODES = 4.0
#: See `BASE_NODES`.
NODES_PER_DIGIT = 1.12
#: See `BASE_NODES`.
ADDED_NODES_IF_DELAYED = 2

#: Number of averages that are kept. Chosen: all outputs of a scene need about 15.
AVERAGES_KEPT = 32
#: Number of sets of points of the start that are kept, with what averages over them share. Chosen:
#: outputs need 4, of different harmonics and weights.
POINT_AVERAGES_KEPT = 8


@dataclass(frozen=True)
class PowerRange:
    """What will be averaged.

    Parameters
    ----------
    lowest, highest : smallest and largest power of the speed; <r^2> counts as a second power
    harmonic : the largest angular harmonic
    """

    lowest: float = 0.0
    highest: float = 4.0
    harmonic: int = 2

    @property
    def largest_size(self) -> float:
        """The largest absolute value of a power."""
        return max(abs(self.highest), abs(self.lowest))


@dataclass(frozen=True, eq=False)
class Averages:
    """Averages over an initial state, at given times; begin with `over`.

    Parameters
    ----------
    law : the collision law
    mean_free_path : l in d
    start : the initial state
    times : rising, in d/U, shape (n_times,)
    rtol : relative accuracy
    powers : what will be averaged
    log_fall : by how many e-folds the largest of these powers may fall until a first bounce counts
    nodes : Chebyshev nodes of a panel of the backward equation; None: from rtol and powers
    """

    law: CollisionLaw
    mean_free_path: float
    start: StartHarmonics
    times: FloatArray
    rtol: float
    powers: PowerRange
    log_fall: float
    nodes: int | None = None

    @classmethod
    def over(
        cls,
        law: CollisionLaw,
        mean_free_path: float,
        state: State,
        times: FloatArray,
        rtol: float,
        powers: PowerRange = PowerRange(),
    ) -> Averages:
        """Return averages over an initial state; the arguments are those of the class."""
        # where <v^p> falls much before a first bounce, slow tracers that have not collided make
        # what is left of it: a small share of the start
        log_fall = log_fall_of(law, powers.highest)
        share = 1.0
        if log_fall > MAX_LOG_CHANGE_ON_PANEL:
            share = math.exp(-min(log_fall, MAX_FALL_OF_START))
        start = StartHarmonics(state, rtol * share, powers.lowest, max(powers.highest, 2.0))
        return cls(law, mean_free_path, start, times, rtol, powers, log_fall)

    def with_nodes(self, nodes: int) -> Averages:
        """Return the same with so many nodes of a panel."""
        return replace(self, nodes=nodes)

    def at_times(self, times: FloatArray) -> Averages:
        """Return the same at other times."""
        return replace(self, times=times)

    @property
    def state(self) -> State:
        """The initial state."""
        return self.start.state

    # -- the equation, and units ------------------------------------------------------------------

    @cached_property
    def log_stretch(self) -> FloatArray:
        """ln(t/l) per time, -inf at t = 0, shape (n_times,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.times) - math.log(self.mean_free_path))

    @cached_property
    def reference(self) -> ReferenceSpeed:
        """A speed of the order of the thermal one, v_ref."""
        return ReferenceSpeed(self.law, 0.5 * self.start.speeds.log_second_moment())

    @cached_property
    def log_reference(self) -> FloatArray:
        """ln of v_ref in U, shape (n_times,)."""
        return self.reference.log_at(self.log_stretch)

    @cached_property
    def equation(self) -> BackwardEquation:
        """The backward equation, up to the largest v t that occurs."""
        highest = max(float(self.start.speeds.x.max() + self.log_stretch[-1]), START)
        power = self.powers.largest_size
        # a power, or an average, may not change more across a panel
        width_of_fall = MAX_LOG_CHANGE_ON_PANEL / max(self.log_fall, MAX_LOG_CHANGE_ON_PANEL)
        width_of_power = MAX_LOG_CHANGE_ON_PANEL / max(power, MAX_LOG_CHANGE_ON_PANEL)
        width = min(width_of_power, max(width_of_fall, NARROWEST_PANEL))
        takes_time = bool(self.law.returns(0)[0])
        nodes = self.nodes or _choose_nodes(self.rtol, power, takes_time)
        equation_class = DelayedBackwardEquation if takes_time else BackwardEquation
        return equation_class(self.law, highest, nodes, width, self.powers.harmonic, self.rtol)

    # -- averages ---------------------------------------------------------------------------------

    def power(self, p: float, m: int = 0) -> NumberArray:
        """Return <(v/v_ref)^p exp(-i m phi)>, shape (n_times,)."""
        return self.average(speed_power(p, m))

    def average(
        self,
        y: Observable,
        start_harmonic: int | None = None,
        start_power: float = 0.0,
        leading: int = 0,
    ) -> NumberArray:
        """Return <(v(0)/v_0)^q y T^-n (v(0)/v_ref)^n exp(-i m phi)>, shape (n_times,).

        Parameters
        ----------
        y : the observable; lengths in l
        start_harmonic : m of the initial state; None: that of y
        start_power : q; v_0 is the root mean square of the initial speeds
        leading : n = y.degree + leading; the first `leading` terms of the power series of y must
            vanish
        """
        m = y.harmonic if start_harmonic is None else start_harmonic
        key = (y, m, start_power, leading)
        return self._averages.get(key, lambda: self._compute(y, m, start_power, leading))

    @cached_property
    def _averages(self) -> Cache[tuple[Observable, int, float, int], NumberArray]:
        """Averages that were computed."""
        return Cache(AVERAGES_KEPT)

    @cached_property
    def _point_averages(self) -> Cache[tuple[int, float], PointAverage]:
        """What averages over the same points share, by m and q."""
        return Cache(POINT_AVERAGES_KEPT)

    def _compute(self, y: Observable, m: int, start_power: float, leading: int) -> NumberArray:
        """Average over the points of harmonic m of the start."""
        points = self._points(m, start_power)
        if points is None:
            return np.zeros(self.times.shape)
        if self.is_closed(y):
            return self._closed_average(y, points)
        average = self._point_averages.get(
            (m, start_power),
            lambda: PointAverage(self.equation, points, self.log_stretch, self.reference),
        )
        return average.average(y, leading)

    def _points(self, m: int, start_power: float) -> LogMeasure | None:
        """Return harmonic m of the start, its weights times (v/v_0)^start_power."""
        points = self.start.harmonic(m)
        if points is None or start_power == 0.0:
            return points
        factor = np.exp(start_power * (points.x - self.reference.log_initial))
        return LogMeasure(points.x, points.weight * factor)

    def is_closed(self, y: Observable) -> bool:
        """Return whether y has a closed form: speeds are kept, a harmonic decays at one rate."""
        has_returns = bool(self.law.returns(0)[0])
        decays_at_one_rate = y.harmonic == 0 or not has_returns
        return self.law.is_elastic and y.is_power and decays_at_one_rate

    def _closed_average(self, y: Observable, points: LogMeasure) -> NumberArray:
        """Average v^p exp(-(1 - E[cos(m chi)]) v t/l) over points, in units of v_ref^p."""
        with np.errstate(under="ignore", over="ignore"):
            values = np.exp(y.degree * (points.x - self.log_reference[:, None]))
            if y.harmonic:
                rate = self.law.harmonic_decay_rate(0.0, y.harmonic)
                values *= np.exp(-rate * np.exp(points.x + self.log_stretch[:, None]))
        return np.asarray(values @ points.weight)

    def error_estimate(self, y: Observable) -> float:
        """Return the relative error of averages of y over all panels, that is over all times."""
        if self.is_closed(y):
            return 0.0
        return self.equation.error_estimate(y)


def log_fall_of(law: CollisionLaw, p: float) -> float:
    """Return -ln E[s^p], by which <v^p> may fall until a first bounce counts; 0 for p < 0."""
    if p <= 0.0:
        return 0.0
    return -math.log(max(float(law.mean_speed_ratio_power(p)), LEAST_MEAN_POWER))


def _choose_nodes(rtol: float, power: float, takes_time: bool) -> int:
    """Return the nodes of a panel for a relative accuracy; see `BASE_NODES`."""
    digits = -math.log10(rtol)
    nodes_of_power = NODES_PER_POWER * min(power, MAX_POWER_OF_NODES)
    nodes = math.ceil(BASE_NODES + nodes_of_power + NODES_PER_DIGIT * digits)
    if takes_time:
        nodes += ADDED_NODES_IF_DELAYED
    return nodes


def check_moment(law: CollisionLaw, state: State, p: object, m: object) -> tuple[float, int]:
    """Return p and m of <v^p exp(-i m phi)> as numbers.

    Raises
    ------
    InputError : one of them is out of range, or the moment does not exist
    """
    power = real_number("p", p, LEAST_POWER, LARGEST_POWER)
    harmonic = whole_number("m", m, 0, MAX_HARMONICS)
    lowest = max(state.lowest_moment, law.lowest_power)
    if power <= lowest:
        raise InputError(f"p: got {power!r}; moments of this scene exist for p > {lowest:g} only")
    return power, harmonic

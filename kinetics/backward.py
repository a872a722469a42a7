r"""The time-dependent equation, solved backwards: one smooth function of v t per observable.

The mean of an observable at time t, seen as a function of the speed u at time 0, obeys the
backward equation, the adjoint of the inelastic Lorentz equation (paper, label ``inelaslorentz2``).
The equation has no scale of its own, so for an observable of degree p in the speed the mean is
u^p times a function of T = u t/l alone. With y(X) = T^p (that function), X = ln T,

    dy/dX = p y + e^X ( E[cos(m chi) y(X - xi)] - y + sources ),     xi = -ln s >= 0,

m the angular harmonic. y at X needs y below X only, and the kernel does not depend on X: on equal
panels the collision term is the same few small matrices everywhere, and one sweep upwards gives
every later time for every initial state. Nothing depends on how rough that state is: its speeds
only enter when the result is averaged over them.

Examples, with the sources in brackets:
    v^p                 : m = 0, degree p
    collisions N        : m = 0, degree 0, [1]
    v_hat(0).r = l chi1 : m = 1, degree 0, [1]
    r^2 = l^2 rho       : m = 0, degree 0, [2 chi1]
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.panels import PanelRule

FloatArray = NDArray[np.float64]

_START = -2.0  # below X = -2 the power series in T converges within _TERMS terms
_TERMS = 40
_WIDTH = 1.0
# Beyond ln(1/kappa) + 38 corrections to the asymptote are below rounding.
_SATURATION = 38.0
_FEWEST, _MOST = 6, 48


def nodes_for(rtol: float, degree: float = 2.0) -> int:
    """Chebyshev nodes of a panel that reach rtol for powers of the speed up to degree.

    From a measurement: the error falls 8 times a node, T^p wants 1.4 nodes for each p > 2.
    """
    wanted = 3.0 + 1.06 * math.log10(1.0 / rtol) + 1.4 * max(0.0, abs(degree) - 2.0)
    return int(min(_MOST, max(_FEWEST, math.ceil(wanted))))


@dataclass(frozen=True)
class Observable:
    """One unknown of the backward equation.

    Attributes
    ----------
    degree : p, the power of the speed by which it scales
    harmonic : m
    constant : source that does not depend on X
    sources : (factor, observable) pairs that drive it
    growth : late, it is a polynomial of this degree in ln T; 0 to 2
    """

    degree: float = 0.0
    harmonic: int = 0
    constant: float = 0.0
    sources: tuple[tuple[float, Observable], ...] = ()
    growth: int = 1


MEAN_COLLISIONS = Observable(constant=1.0)
DISPLACEMENT_ALONG_START = Observable(harmonic=1, constant=1.0)
SQUARED_DISPLACEMENT = Observable(sources=((2.0, DISPLACEMENT_ALONG_START),))
# <exp(i k.r)> to the fourth order in k, harmonic by harmonic (kinetics/scattering.py)
_SECOND_HARMONIC = Observable(harmonic=2, sources=((0.25, DISPLACEMENT_ALONG_START),))
_THIRD_ORDER = Observable(
    harmonic=1, sources=((-0.125, SQUARED_DISPLACEMENT), (-0.5, _SECOND_HARMONIC))
)
QUARTIC_DISPLACEMENT = Observable(sources=((-64.0, _THIRD_ORDER),), growth=2)


def speed_power(p: float, harmonic: int = 0) -> Observable:
    """v^p cos(m (phi - phi_0))."""
    return Observable(degree=p, harmonic=harmonic, growth=0)


# d r^2/d ln t, driven by the velocity along the start
MSD_SLOPE = Observable(degree=1.0, sources=((2.0, speed_power(1.0, 1)),), growth=0)


def moment_series(
    law: CollisionLaw, y: Observable, known: dict[Observable, FloatArray] | None = None
) -> FloatArray:
    """Coefficients a_k of y = T^p sum_k a_k T^k, from the moment hierarchy, shape (41,).

    ``known`` keeps what was found on the way.
    """
    known = {} if known is None else known
    if y in known:
        return known[y]
    driven = y.constant != 0.0 or bool(y.sources)
    sources = [(factor, moment_series(law, other, known)) for factor, other in y.sources]
    a = np.zeros(_TERMS + 1)
    if not driven:
        a[0] = 1.0
    for k in range(_TERMS):
        drive = y.constant if k == 0 else 0.0
        drive += sum(factor * s[k] for factor, s in sources)
        # at e = 0 the decay of T^0 needs no average: nothing is driven at degree 0 then
        loss = a[k] * law.harmonic_decay_rate(y.degree + k, y.harmonic) if a[k] else 0.0
        a[k + 1] = (drive - loss) / (k + 1.0)
    known[y] = a
    return a


@dataclass(frozen=True)
class _Panels:
    """y on consecutive panels from _START on."""

    values: FloatArray  # (n_panels, nodes)
    series: FloatArray  # coefficients of T^k below _START
    degree: float


@dataclass
class BackwardEquation:
    """Solves for observables on panels in X = ln(u t/l), and keeps what it solved.

    Parameters
    ----------
    law : the collision law, e < 1 (the elastic case is elementary: see evolve.py)
    highest : largest X that will be asked for
    nodes : Chebyshev nodes of a panel
    """

    law: CollisionLaw
    highest: float
    nodes: int
    _solved: dict[Observable, _Panels] = field(default_factory=dict, repr=False)
    _series: dict[Observable, FloatArray] = field(default_factory=dict, repr=False)
    _kernels: dict[int, tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        limit = _SATURATION - math.log(self.law.mean_log_loss)
        self.count = max(1, math.ceil((min(self.highest, limit) - _START) / _WIDTH))

    # -- discretisation -----------------------------------------------------------------------

    @cached_property
    def rule(self) -> PanelRule:
        """The collocation of a panel."""
        return PanelRule(self.nodes, _WIDTH)

    def _kernel(self, m: int) -> tuple[FloatArray, FloatArray]:
        """Loss matrix of a panel on itself, and gain from those below it, farthest first."""
        if m not in self._kernels:
            loss, gain = self.rule.kernel(self.law, [m])
            self._kernels[m] = loss[0], gain[0]
        return self._kernels[m]

    # -- solution -----------------------------------------------------------------------------

    def _solve(self, y: Observable) -> _Panels:
        if y in self._solved:
            return self._solved[y]
        sources = [(factor, self._solve(other).values) for factor, other in y.sources]
        series = moment_series(self.law, y, self._series)
        loss, gain = self._kernel(y.harmonic)
        n = self.nodes
        reach = gain.shape[1] // n
        local = self.rule.local
        table = np.empty((reach + self.count, n))
        for k in range(reach):
            x = _START + (k - reach + local) * _WIDTH
            table[k] = np.exp(y.degree * x) * np.polynomial.polynomial.polyval(np.exp(x), series)
        known = math.exp(y.degree * _START) * float(
            np.polynomial.polynomial.polyval(math.exp(_START), series)
        )
        drift = self.rule.derivative - y.degree * np.eye(n)
        for j in range(self.count):
            rate = np.exp(_START + (j + local) * _WIDTH)
            drive = gain @ table[j : j + reach].ravel() + y.constant
            for factor, values in sources:
                drive = drive + factor * values[j]
            # rows are divided by the collision rate where that is large
            scale = 1.0 / np.maximum(1.0, rate)
            matrix = drift * scale[:, None] + (rate * scale)[:, None] * loss
            right = rate * scale * drive
            matrix[0] = 0.0
            matrix[0, 0] = 1.0
            right[0] = known
            table[reach + j] = np.linalg.solve(matrix, right)
            known = float(table[reach + j, -1])
        self._solved[y] = _Panels(table[reach:], series, y.degree)
        return self._solved[y]

    def solve(self, observable: Observable) -> FloatArray:
        """Values at the nodes of all panels, shape (n_panels, nodes)."""
        return self._solve(observable).values

    def error_estimate(self, observable: Observable) -> float:
        """What the Chebyshev coefficients of a panel leave out, relative to its smaller end.

        For a harmonic m > 0 of a power, which decays by itself, relative to m = 0.
        """
        values = self._solve(observable).values
        last, before = self.rule.last_coefficients(values)
        if observable.harmonic and not observable.sources and not observable.constant:
            scale = self._solve(speed_power(observable.degree)).values
        else:
            scale = values
        # powers rise as e^(p X) over a panel: its lower end has the largest relative error
        ends = np.minimum(np.abs(scale[:, 0]), np.abs(scale[:, -1]))
        top = np.maximum(np.maximum(ends, 1e-3 * np.abs(scale).max(axis=1)), 1e-300)
        floor = 1e-16 * top
        # between the last coefficient, which is too much, and the first one left out
        fall = np.minimum(1.0, (last + floor) / (before + floor))
        error = np.maximum(last, floor) * np.sqrt(fall)
        # errors of panels add up while an observable grows
        return float(np.sum(error / top))

    def evaluate(self, observable: Observable, x: FloatArray) -> FloatArray:
        """y(X) at X = x, any shape."""
        small, large = self.reduced(observable, x)
        with np.errstate(invalid="ignore"):
            return np.asarray(
                np.where(np.isnan(large), small * np.exp(observable.degree * x), large)
            )

    def reduced(
        self, observable: Observable, x: FloatArray, leading: int = 0
    ) -> tuple[FloatArray, FloatArray]:
        """y T^-(p + leading) where X = x is below the panels, y elsewhere; NaN where not.

        Below the panels by the power series, whose first ``leading`` terms must vanish; above
        them on the asymptote, a polynomial in X. Apart, because T^p alone may overflow. x
        of any shape, -inf allowed.
        """
        panels = self._solve(observable)
        flat = x.ravel()
        level = (flat - _START) / _WIDTH
        low = level < 0.0
        small = np.full(flat.shape, np.nan)
        large = np.full(flat.shape, np.nan)
        series = panels.series[leading:]
        small[low] = np.polynomial.polynomial.polyval(np.exp(flat[low]), series)
        inside = level[~low]
        index = np.minimum(inside.astype(int), self.count - 1)
        rows = self.rule.rows(np.minimum(inside - index, 1.0))
        value = np.einsum("ij,ij->i", rows, panels.values[index])
        beyond = inside > self.count
        value[beyond] = self._asymptote(panels.values, observable.growth, inside[beyond])
        large[~low] = value
        return small.reshape(x.shape), large.reshape(x.shape)

    def _asymptote(self, values: FloatArray, growth: int, level: FloatArray) -> FloatArray:
        """The polynomial in X through the ends of the last panels, at X in panels."""
        ends = values[-1:-4:-1, -1] if values.shape[0] > 3 else values[-1, [-1, 0, 0]]
        if growth == 0:
            return np.full(level.shape, ends[0])
        first = ends[0] - ends[1]
        u = level - self.count
        if growth < 2 or values.shape[0] <= 3:
            return np.asarray(ends[0] + first * u)
        second = ends[0] - 2.0 * ends[1] + ends[2]
        return np.asarray(ends[0] + first * u + 0.5 * second * u * (u + 1.0))

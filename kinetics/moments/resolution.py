"""How many nodes a panel of the backward equation needs: read off before it is solved.

Below T = v t/l of a few, an observable is its power series in T (`backward.moment_series`), which
costs next to nothing. Its Chebyshev coefficients on the first panels say how fast those of the
solution fall: the nodes are the fewest for which the error estimate of the solution, applied to
these coefficients, is what is asked for. Later panels are smoother, because the observable tends
to a power or to a polynomial in ln T there; but near e = 1 a power of the speed still changes at
T = 1/kappa. All speeds are the same then, dv/dt = -kappa v^2/l, and what v^p tends to is
(T/(1 + kappa T))^p. And where a bounce nearly stops a tracer, a power of the speed falls as e^-T
until those that have collided are most of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.moments.backward import (
    START,
    TERMS,
    Observable,
    fall_of,
    left_out,
    moment_series,
    scale_of,
    smaller_ends,
)
from kinetics.numerics import FloatArray

FEWEST, MOST = 5, 48  # fewer have no decay to look at; more only add rounding
_LONGEST = 3.5  # of the panels in X: they end at T = e^2 or less, as far as the series reaches
_DEGREE = 32  # of the Chebyshev series: more than the nodes of 15 digits
# In nine of ten cases later panels hold at most 2.8 times what the last of these holds;
# a guess that is too small costs a second solve.
_LATER = 4.0
_ABOVE_NOISE = 10.0  # coefficients below so many times the rounding of the series say nothing


@dataclass(frozen=True)
class _EarlyPanels:
    """Nodes of the panels from START on, and what takes a power series to Chebyshev series there.

    Attributes
    ----------
    x : X at the nodes, shape (n_panels, _DEGREE + 1)
    powers : T^k, shape (n_panels * (_DEGREE + 1), TERMS + 1)
    transform : values at the nodes of a panel to coefficients, (_DEGREE + 1, _DEGREE + 1)
    """

    x: FloatArray
    powers: FloatArray
    transform: FloatArray


@lru_cache(maxsize=8)
def _early_panels(width: float) -> _EarlyPanels:
    k = np.arange(_DEGREE + 1)
    local = 0.5 * (1.0 - np.cos(math.pi * k / _DEGREE))
    x = START + width * (np.arange(math.ceil(_LONGEST / width))[:, None] + local)
    halves = np.where((k == 0) | (k == _DEGREE), 0.5, 1.0)
    cosines = np.cos(math.pi / _DEGREE * np.outer(k, k))
    powers = np.exp(np.multiply.outer(x.ravel(), np.arange(TERMS + 1)))
    return _EarlyPanels(x, powers, 2.0 / _DEGREE * halves[:, None] * cosines)


@dataclass(frozen=True)
class Decay:
    """What Chebyshev series leave out of an observable on all panels, relative to it.

    Attributes
    ----------
    error : of series of 2, 3, ... nodes, shape (_DEGREE,)
    noise : rounding of the error
    """

    error: FloatArray
    noise: float

    def nodes_for(self, rtol: float) -> int:
        """The fewest nodes for which the error is about rtol."""
        enough = np.nonzero(self.error <= rtol)[0]
        clear = np.nonzero(self.error <= _ABOVE_NOISE * self.noise)[0]
        last = int(clear[0]) - 1 if clear.size else self.error.size - 1
        if enough.size and enough[0] <= last + 1:
            index = int(enough[0])
        else:
            # beyond the noise the error goes on falling as it did, by e a node at least; to half
            # of rtol, because one node too few costs a second solve, and one too many 5 %
            middle = last // 2
            rate = math.log(self.error[middle] / self.error[last]) / max(last - middle, 1)
            index = last + math.ceil(math.log(2.0 * self.error[last] / rtol) / max(rate, 1.0))
        return min(MOST, max(FEWEST, 2 + index))


def decay_of(
    law: CollisionLaw,
    y: Observable,
    width: float = 1.0,
    known: dict[Observable, FloatArray] | None = None,
) -> Decay:
    """How fast the Chebyshev coefficients of y fall; e < 1.

    ``known`` keeps power series from one call to the next.
    """
    panels = _early_panels(width)
    x, series = panels.x, moment_series(law, y, known)
    power = np.exp(y.degree * x)
    values = scale = power * (panels.powers @ series).reshape(x.shape)
    if scale_of(y) != y:
        scale = power * (panels.powers @ moment_series(law, scale_of(y), known)).reshape(x.shape)
    elif not (y.sources or y.constant):
        latest, fall = math.exp(x[-1, -1]), fall_of(law, y.degree)
        if law.mean_log_loss * latest < 1.0:
            # the change at T = 1/kappa comes later: (T/(1 + T))^p on as many panels about T = 1
            values = scale = np.concatenate([values, (1.0 + np.exp(-x)) ** -y.degree])
        elif fall > latest:
            # e^-T on as many panels, of which the last ends where <v^p> has fallen
            values = scale = np.concatenate([values, np.exp(-fall * np.exp(x - x[-1, -1]))])
    ends = smaller_ends(scale)
    size = np.abs(values @ panels.transform)
    by_panel = left_out(size[:, 1:], size[:, :-1]) / ends[:, None]
    error = by_panel.sum(axis=0) + _LATER * by_panel[len(x) - 1]
    # where T is largest: rounding of the largest term, and the first term that is missing
    terms = np.abs(series) * panels.powers[-1]
    noise = power[-1, -1] * (np.finfo(float).eps * terms.max() + terms[-1])
    return Decay(error, float(len(x) * noise / ends[len(x) - 1]))

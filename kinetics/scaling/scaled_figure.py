"""Figures of the scaled velocity distribution: F(c) beside what it is often taken for.

F is drawn with the Gaussian of the same <c^2>, which the paper expands about, and with its own
exponential tail, F ~ C c^q exp(-2 c/h). Moments are drawn as points, beside those of the Gaussian.
Begin with :func:`draw_vdf`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.results.labels import axis_label
from kinetics.results.plot import (
    DENSITY_BOTTOM,
    LOGARITHMIC_ABOVE,
    N_COLOURS,
    SOURCE,
    add_legend,
    n_curves_of,
    new_axes,
    show_tails,
    source_on,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The larger of two speeds at which the constant C of the tail is read off, times 2/h; the other is
#: half of it. Chosen: F is above the 1e-100 down to which the solver goes.
RATE_TIMES_SPEED_OF_TAIL = 200.0
#: Largest difference of ln C at those two speeds at which the tail is drawn: it is of first order
#: in 1/c, and extrapolated. Chosen: near e = 1 the tail begins where F is too small to matter.
MAX_DIFFERENCE_OF_LOG_CONSTANT = 0.5
#: The tail is drawn where it is below so many times the largest F: it may be infinite at rest.
TAIL_TOP = 3.0


@dataclass(frozen=True)
class Tail:
    """F at high c: constant * c^power * exp(-rate * c)."""

    constant: float
    power: float
    rate: float

    def at(self, c: FloatArray) -> FloatArray:
        """Return the tail at scaled speeds above 0, shape of c."""
        return np.asarray(self.constant * c**self.power * np.exp(-self.rate * c))


def tail_of(
    vdf: Callable[[FloatArray], FloatArray], cooling_rate: float, power: float
) -> Tail | None:
    """Return the exponential tail of F; None where there is none, or only beyond all that is shown.

    Parameters
    ----------
    vdf : F
    cooling_rate : h
    power : q, as `ScalingSolution.tail_power`
    """
    if not (cooling_rate > 0.0 and math.isfinite(power)):
        return None
    rate = 2.0 / cooling_rate
    scaled = np.array([0.5, 1.0]) * RATE_TIMES_SPEED_OF_TAIL
    far = scaled / rate
    density = vdf(far)
    if np.any(density == 0.0):
        return None
    nearer, farther = np.log(density) - power * np.log(far) + scaled
    if abs(farther - nearer) > MAX_DIFFERENCE_OF_LOG_CONSTANT:
        return None
    return Tail(math.exp(2.0 * farther - nearer), power, rate)


def gaussian_vdf(c: FloatArray, dimension: int) -> FloatArray:
    """Return the Gaussian density in the space of velocities with <c^2> = 1, shape of c."""
    norm = (dimension / (2.0 * math.pi)) ** (0.5 * dimension)
    return np.asarray(norm * np.exp(-0.5 * dimension * c**2))


def gaussian_moment(p: FloatArray, dimension: int) -> FloatArray:
    """Return <c^p> of the Gaussian with <c^2> = 1, shape of p."""
    from scipy.special import gammaln

    log_ratio = gammaln(0.5 * (dimension + p)) - gammaln(0.5 * dimension)
    return np.asarray(np.exp(log_ratio + 0.5 * p * math.log(2.0 / dimension)))


def draw_vdf(
    c: FloatArray,
    density: FloatArray,
    tail: Tail | None,
    dimension: int,
    ax: Axes | None,
    system: Sequence[str],
    shows_all: bool = False,
) -> Axes:
    """Draw F over c on a logarithmic ordinate, with the Gaussian and the exponential tail.

    Parameters
    ----------
    c, density : scaled speeds, and F there, (n,)
    tail : of F, or None
    dimension : 2 or 3
    ax : to draw on; None for new ones
    system : what the title says
    shows_all : whether the ordinate reaches down to the least F, or to `DENSITY_BOTTOM`
    """
    ax = ax if ax is not None else new_axes()
    source = source_on(ax, SOURCE, system)
    index = n_curves_of(ax, SOURCE)
    colour = f"C{index % N_COLOURS}"
    finite = np.isfinite(density)
    largest = float(density[finite].max())
    ax.plot(c[finite], density[finite], color=colour, label=source)
    if tail is not None:
        moving = c[c > 0.0]
        asymptote = tail.at(moving)
        is_shown = asymptote < TAIL_TOP * largest
        words = rf"tail $\propto c^{{{tail.power:.3g}}}\,e^{{-{tail.rate:.3g}c}}$"
        ax.plot(moving[is_shown], asymptote[is_shown], ":", lw=2, color=colour, label=words)
    if index == 0:
        ax.plot(c, gaussian_vdf(c, dimension), "--", color="0.4", label="Gaussian")
    ax.set(xlabel=axis_label("c", "1"), ylabel=axis_label("F(c)", "1"))
    bottom = DENSITY_BOTTOM
    if shows_all:
        bottom = min(bottom, float(density[finite & (density > 0.0)].min()) / largest)
    show_tails(ax, largest, bottom)
    add_legend(ax)
    return ax


def draw_moments(
    p: FloatArray, moments: FloatArray, dimension: int, ax: Axes | None, system: Sequence[str]
) -> Axes:
    """Draw <c^p> as points over p, with the moments of the Gaussian.

    Parameters
    ----------
    p, moments : powers, and <c^p>, (n,)
    dimension : 2 or 3
    ax : to draw on; None for new ones
    system : what the title says
    """
    ax = ax if ax is not None else new_axes()
    source = source_on(ax, SOURCE, system)
    index = n_curves_of(ax, SOURCE)
    ax.plot(p, moments, "o", color=f"C{index % N_COLOURS}", label=source)
    if index == 0:
        of_gaussian = gaussian_moment(p, dimension)
        ax.plot(p, of_gaussian, "s", mfc="none", color="0.4", label="Gaussian")
    ax.set(xlabel=axis_label("p", "1"), ylabel=axis_label("<c^p>", "1"))
    if max(moments) > LOGARITHMIC_ABOVE * min(moments):
        ax.set_yscale("log")
    add_legend(ax)
    return ax

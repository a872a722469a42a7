r"""Loops from a scatterer back to it, in a medium, as a sum of exponentials of their path.

A tracer among fixed disks of a finite density n = rho d^2 (rho their number density, d the contact
distance) may come back to the scatterer that it has just left. l is the mean free path, e the
restitution, and eps the chance per collision that such a loop begins (:meth:`Medium.returns`).

The theory (:mod:`kinetics.collision.medium`) lets tracers return at once. A real return is a loop
of some path y, half of it before a bounce straight back and half after it, at a fraction r of the
speed. Paths y are in l. k(y) dy is the chance per collision of a loop of a path near y. There are
two kinds:

- near loops, between near pairs of scatterers, have k = (2 e/(1 + e)) n exp(-0.6 y)/y from y = 2 n
  on (one neighbour and back), r = e. 0.6 is the mean corridor that is known to be empty. What is
  flown of them is y - 2 n.
- far loops, of the size of l, are the rest of eps: the integral of k over both kinds is eps, so
  that the late <r^2> grows as with returns at once. They are spread as exp(-0.9 y/b) -
  exp(-1.1 y/b), nearly y exp(-y/b), with a width b in l. For averages of the displacement b is
  fitted to <r^2> of simulations, and r = e. For powers of the speed nothing is fitted
  (:attr:`Medium.of_speed`, :attr:`Medium.far_loops`): far loops leave a share of the speed of
  their own, nearly e^2, and what else comes back does so at once.

A mode is one of the exponentials. For the angular harmonic m a loop counts with the sign (-1)^m, as
it ends in the opposite direction. Begin with `LoopSpectrum`; :mod:`kinetics.moments.delayed` makes
of it what loops bring to the panels of an equation in X = ln T, where T = v t/l is the path in mean
free paths that a tracer would have flown at its first speed v.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.collision.law import CollisionLaw
from kinetics.collision.medium import CORRIDOR, Medium
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import equal_panels

#: Width b of far loops, over e l, in averages of the displacement. Fitted to <r^2> of simulations
#: before 30 mean free times: the best value of each e is between 0.5 and 2. Half or twice of it
#: changes <r^2> by 6e-3 (e = 0.7, n = 0.04).
FAR_WIDTH = 1.8
#: By this fraction of 1/b the two rates of far loops are below and above 1/b. Chosen:
#: exp(-0.9 y/b) - exp(-1.1 y/b) is nearly 0.2 (y/b) exp(-y/b), and equal rates would need another
#: form. Half of it changes <r^2> by 6e-5, twice by 2e-4 (e = 0.7, n = 0.04): less than the fit of
#: b does.
FAR_RATE_DIFFERENCE = 0.1
#: Number of exponentials for near loops, but for the slowest one. Measured: the sum is off by 2e-3
#: of k at most for y < 20 l, because of the slowest rates; half as many leave 5e-2 at n = 0.001,
#: twice as many change averages of the speed and of the displacement by 3e-9.
NEAR_MODES = 20
#: Slowest of these rates, less CORRIDOR, in 1/l; slower ones are taken together as one mode.
#: Measured: half of it leaves 8e-4 of k in place of 2e-3, twice 2e-2; averages change by 6e-6 and
#: by 4e-5.
SLOWEST_NEAR_RATE = 0.02
#: Fastest of these rates, less CORRIDOR, times the shortest loop, 2 n: faster ones have the weight
#: exp(-12), and what they lack of the integral is given to the fastest mode. Measured: half or
#: twice of it changes averages by 5e-8 at most.
FASTEST_NEAR_RATE = 12.0
#: Least length of the shortest near loop, 2 n, in l; in more dilute media it is taken to be so
#: long. Chosen: rates stay moderate there. Half or twice of it changes averages by 3e-7 at
#: n = 1e-4, and by nothing at 0.04.
SHORTEST_LOOP = 1e-3


def met_again(law: CollisionLaw) -> Medium | None:
    """Return the medium whose scatterers a tracer comes back to; None where it does not.

    It does not where the law has no medium (dilute scatterers), or where e = 0.
    """
    if law.medium is None or law.medium.restitution == 0.0:
        return None
    return law.medium


@dataclass(frozen=True)
class LoopModes:
    """k(y) of near loops and of far loops, as sums of weight exp(-rate y) over modes.

    Parameters
    ----------
    rates : in 1/l, shape (n_modes,)
    weights : of near loops (row 0) and of far ones (row 1) in 1/l, shape (2, n_modes); 0 where a
        mode belongs to the other kind
    speed_ratios : r of near loops and of far ones, shape (2,)
    """

    rates: FloatArray
    weights: FloatArray
    speed_ratios: FloatArray

    @property
    def near_share(self) -> float:
        """The integral of k over near loops: the chance per collision that one begins."""
        return float((self.weights[0] / self.rates).sum())


@dataclass(frozen=True)
class LoopSpectrum:
    """k(y) for the angular harmonics m: the sum of shares_m,kind weights_kind,mode exp(-rate y).

    :class:`kinetics.moments.delayed.Loops` takes it.

    Parameters
    ----------
    rates : in 1/l, shape (n_modes,)
    weights : of each kind of loops in 1/l, shape (n_kinds, n_modes)
    shares : by which the weights of a kind count for a harmonic, with the sign (-1)^m, shape
        (n_m, n_kinds)
    speed_ratios : the different r that occur, shape (n_ratios,)
    has_ratio : 1 where a mode has this r, else 0; shape (n_ratios, n_modes). Each mode has one
    """

    rates: FloatArray
    weights: FloatArray
    shares: FloatArray
    speed_ratios: FloatArray
    has_ratio: FloatArray

    @property
    def mode_ratios(self) -> FloatArray:
        """r of each mode, shape (n_modes,)."""
        return self.speed_ratios @ self.has_ratio

    @property
    def mode_paces(self) -> FloatArray:
        """Time of a loop over its path, at the speed that it begins with: shape (n_modes,)."""
        return pace_of(self.speed_ratios) @ self.has_ratio


def pace_of(speed_ratio: FloatArray) -> FloatArray:
    """Return the time of a loop over its path, at the speed that it begins with.

    Half of the path is flown at the fraction r of the speed: (1 + 1/r)/2, of the shape of r.
    """
    return 0.5 * (1.0 + 1.0 / speed_ratio)


def displacement_spectrum(medium: Medium, harmonics: range) -> LoopSpectrum:
    """Return the loops of averages of displacements and directions.

    The integral of k over both kinds is eps (-1)^m of each harmonic, `Medium.returns(m)[0]`, of
    which near loops are the same part for all m, and far loops the rest. Both have r = e.

    Parameters
    ----------
    medium : the scatterers, e > 0
    harmonics : the angular harmonics m
    """
    modes = loop_modes(medium)
    # one ratio for all modes: to give far loops another one, write it as in `speed_spectrum`
    ratios = np.unique(modes.speed_ratios)
    assert ratios.size == 1
    shares = []
    for m in harmonics:
        sign = (-1.0) ** m
        all_returns, _ = medium.returns(m)  # eps (-1)^m
        shares.append((sign, all_returns - sign * modes.near_share))
    return LoopSpectrum(
        rates=modes.rates,
        weights=modes.weights,
        shares=np.array(shares),
        speed_ratios=ratios,
        has_ratio=np.ones((1, modes.rates.size)),
    )


def speed_spectrum(medium: Medium) -> LoopSpectrum:
    """Return the loops of averages of powers of the speed, m = 0; the medium has e > 0.

    Far loops have a ratio r and a chance of their own, which is in the weights.
    """
    modes = loop_modes(medium, of_speed=True)
    return LoopSpectrum(
        rates=modes.rates,
        weights=modes.weights,
        shares=np.ones((1, 2)),
        speed_ratios=modes.speed_ratios,
        has_ratio=(modes.weights != 0.0).astype(float),
    )


def series_end(medium: Medium) -> float:
    """Return X = ln T up to which power series in T hold, with which an equation begins.

    It is ln of the time T of a loop whose path is 1/rate of the fastest mode.
    """
    modes = loop_modes(medium)
    near_pace = float(pace_of(modes.speed_ratios)[0])
    return math.log(near_pace / float(modes.rates.max()))


@lru_cache(maxsize=16)
def loop_modes(medium: Medium, of_speed: bool = False) -> LoopModes:
    """Return near loops and far ones as sums of exponentials; near ones are the same in both cases.

    Parameters
    ----------
    medium : the scatterers, e > 0
    of_speed : if true, far loops are those of powers of the speed, with their own ratio, width and
        chance. If not, those of displacements: r = e, the fitted width, and the integral 1, which
        `displacement_spectrum` multiplies by their chance
    """
    e = medium.restitution
    near_rates, near_weights = _near_modes(medium)
    if of_speed:
        far_ratio, far_width, far_share = medium.far_loops
    else:
        far_ratio = e
        far_width = FAR_WIDTH * e
        far_share = 1.0
    # w (exp(-s_0 y) - exp(-s_1 y)) has the integral w (s_1 - s_0)/(s_0 s_1)
    far_rates = (1.0 + FAR_RATE_DIFFERENCE * np.array([-1.0, 1.0])) / far_width
    far_weight = far_share * far_rates.prod() / (far_rates[1] - far_rates[0])
    weights = np.zeros((2, near_rates.size + 2))
    weights[0, :-2] = 2.0 * e / (1.0 + e) * medium.density * near_weights
    weights[1, -2] = far_weight
    weights[1, -1] = -far_weight
    return LoopModes(np.append(near_rates, far_rates), weights, np.array([e, far_ratio]))


def _near_modes(medium: Medium) -> tuple[FloatArray, FloatArray]:
    """Write exp(-0.6 (y + a))/(y + a), a = 2 n, as a sum of exponentials of y.

    Here y is what is flown of a loop of the path y + a. The function is the integral of
    exp(-(0.6 + g) (y + a)) over g > 0. It is taken by Gauss points in ln g from SLOWEST_NEAR_RATE
    to FASTEST_NEAR_RATE/a, and one mode for all smaller g. The fastest mode is given the rest of
    the integral over y, so that this is exact.

    Returns
    -------
    Rates in 1/l and weights, without the factor (2 e/(1 + e)) n, shape (NEAR_MODES + 1,) each
    """
    from scipy.special import exp1

    shortest = max(2.0 * medium.density, SHORTEST_LOOP)
    log_range = math.log(FASTEST_NEAR_RATE / shortest / SLOWEST_NEAR_RATE)
    log_g, step = equal_panels(log_range, NEAR_MODES, math.inf)  # Gauss points on one panel
    g = np.append(0.5 * SLOWEST_NEAR_RATE, SLOWEST_NEAR_RATE * np.exp(log_g))
    rates = CORRIDOR + g
    weights = np.append(SLOWEST_NEAR_RATE, step * g[1:]) * np.exp(-rates * shortest)
    # the fastest loops are given what is missing of the integral, for the true 2 n
    integral = exp1(2.0 * CORRIDOR * medium.density)
    weights[-1] += rates[-1] * (integral - (weights / rates).sum())
    return rates, weights

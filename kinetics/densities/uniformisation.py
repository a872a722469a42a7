r"""Masses at nodes of ln v that collide: the exponential of their linear equation.

Speeds v_j are in U, times in l/U, l the mean free path; masses are shares of all tracers. Node j
loses mass at the rate v_j, and a share b_k of it arrives k nodes below, the same for all nodes, so
that with the vector of masses y

    dy/dt = A y,    (A y)_j = -v_j y_j + sum over k of b_k v_{j-k} y_{j-k}.

By uniformisation exp(A t) is the Poisson average, of mean v_0 t, of powers of 1 + A/v_0, where v_0
is the largest rate. All terms are non-negative where shares and masses are: no mass ever is below
0, and their sum is kept to rounding. One such power is called a sweep. Begin with
:meth:`CollidingMasses.advance`.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.densities.harmonic import HarmonicArray
from kinetics.numerics import ROUNDING, FloatArray

#: Most products of masses with shares of bounces. Measured: a second or two.
MAX_WORK = 1e10
#: What a sweep costs beside its products, counted in products. Measured: without it, what takes too
#: long was only given up after 39 s, with it after 6 s (commit 00d7f3ab).
WORK_PER_SWEEP = 1e4
#: Number of shares of bounces from which on transforms are quicker than a direct sum, and the
#: products per node that they then cost. Measured: from some 150 shares on for 2000 nodes or more,
#: from 1000 on for 500 nodes.
TRANSFORM_FROM = 300
#: A node at the fast end of the axis with less than this fraction of all mass is left out: far
#: below rounding. Chosen. The smaller it is, the longer the fastest tracers set the steps. At half
#: and at twice shares move by 1e-15.
EMPTY = 1e-25
#: Collisions of the fastest tracers in one step: so few that the fast end of the axis empties on
#: the way, so many that the tail of the Poisson distribution (`MORE_SWEEPS`) costs little. Chosen:
#: at half and at twice nothing moves.
COLLISIONS_PER_STEP = 64.0
#: A step is the last one if less than this fraction of the duration remains. Chosen: rounding.
REMAINING_NEGLIGIBLE = 1e-15
#: The Poisson average ends where the weights that are left are below this. Chosen: rounding.
POISSON_TAIL = 1e-16
#: Standard deviations above the mean at which the Poisson average ends at the latest: the weights
#: there are e^-72. Chosen. Its rounding may hold up the other end.
MAX_POISSON_DEVIATIONS = 12.0
#: Sweeps that are added to these, for small means. Chosen: at half and at twice
#: nothing moves.
MORE_SWEEPS = 40.0
#: Results of a transform below this fraction of the largest are rounding, and set to 0: else the
#: fast end of the axis would never empty. Chosen: four roundings.
ROUNDING_OF_TRANSFORM = 4.0 * ROUNDING


class CollidingMasses:
    """Masses at nodes of ln v as they collide. Node 0 is the fastest: bounces raise the index.

    Attributes
    ----------
    mass : at the nodes, from the fastest to the slowest, shape (n_nodes,)
    work : products of masses with shares so far
    is_positive : whether no mass can be below 0; harmonics m > 0 may have any sign
    """

    def __init__(self, speed: FloatArray, arrival_shares: FloatArray, mass: HarmonicArray) -> None:
        """Begin with some masses.

        Parameters
        ----------
        speed : v of the nodes in U, falling, shape (n_nodes,)
        arrival_shares : share of the bounces of a node that arrive k nodes below, (n_shares,)
        mass : at the nodes, shape (n_nodes,)
        """
        self.mass = mass
        self.work = 0.0
        is_real = not np.iscomplexobj(mass)
        self.is_positive = bool(arrival_shares.min() >= 0.0 and is_real and mass.min() >= 0)
        self._speed = speed
        self._arrival_shares = arrival_shares
        self._total = float(np.abs(mass).sum())
        self._first = 0  # nodes above it are empty

    @property
    def takes_too_long(self) -> bool:
        """Whether the work is beyond its limit, so that the masses are not followed any further."""
        return self.work > MAX_WORK

    def advance(self, duration: float) -> None:
        """Let the masses collide for a duration in l/U, or until it takes too long."""
        remaining = duration
        while remaining > REMAINING_NEGLIGIBLE * duration and not self.takes_too_long:
            self._leave_out_empty_nodes()
            fastest = float(self._speed[self._first])
            step = min(remaining, COLLISIONS_PER_STEP / fastest)
            self._advance_by_poisson_average(step, fastest)
            remaining -= step

    def _leave_out_empty_nodes(self) -> None:
        """Move the fast end of the axis down to the first node that holds some mass."""
        occupied = np.nonzero(np.abs(self.mass) > EMPTY * self._total)[0]
        first = int(occupied[0]) if occupied.size else self._first
        # the nodes above hold next to nothing: it is added to the first node that is kept
        self.mass[first] += self.mass[self._first : first].sum()
        self.mass[self._first : first] = 0.0
        self._first = first

    def _advance_by_poisson_average(self, step: float, fastest: float) -> None:
        """Multiply the masses by exp(A step), a Poisson average of powers of 1 + A/fastest."""
        speed = self._speed[self._first :] / fastest
        current = self.mass[self._first :].copy()
        mean = fastest * step
        weight = math.exp(-mean)
        average = weight * current
        sum_of_weights = weight
        max_sweeps = mean + MORE_SWEEPS + MAX_POISSON_DEVIATIONS * math.sqrt(mean)
        n = 0
        while 1.0 - sum_of_weights > POISSON_TAIL and n < max_sweeps:
            colliding = speed * current
            current -= colliding
            arriving = self._arriving(colliding)
            current += arriving[: current.size]
            # the slowest node keeps what falls below
            current[-1] += arriving[current.size :].sum()
            n += 1
            weight *= mean / n
            sum_of_weights += weight
            average += weight * current
        # the truncated Poisson weights are made to sum to 1: mass is kept to rounding
        self.mass[self._first :] = average / sum_of_weights

    def _arriving(self, colliding: HarmonicArray) -> HarmonicArray:
        """Return where the colliding masses arrive, also past the slow end of the axis."""
        n_shares = self._arrival_shares.size
        self.work += WORK_PER_SWEEP + colliding.size * min(n_shares, TRANSFORM_FROM)
        if n_shares < TRANSFORM_FROM:
            # what np.convolve does, without its checks
            return np.correlate(colliding, self._arrival_shares[::-1], "full")
        from scipy.signal import fftconvolve

        arriving = np.asarray(fftconvolve(colliding, self._arrival_shares))
        size = np.abs(arriving)
        arriving[size < ROUNDING_OF_TRANSFORM * size.max()] = 0.0
        if self.is_positive:
            return np.maximum(arriving, 0.0)
        return arriving

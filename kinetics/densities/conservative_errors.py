"""What the conservative method makes of a density: its error estimate, from its own masses."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import logsumexp

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import (
    LEAST_MAXIMUM,
    LOWEST_SPEED,
    HarmonicProblem,
    Profile,
    memory_of,
)
from kinetics.densities.node_masses import NodeMasses, bounce_kernel
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

# A first guess of the error over the square of the spacing: 1.6 (in space 2.6), and near e = 1,
# where the shares of a bounce spread the ring of speeds, 0.2/(1-e)^2 at late times, as measured by
# tests/kinetics/measurements/densities.py. For any law 1 - e is the largest share of the speed that
# a bounce takes; where the mean of (ln s)^2 is much less than its square, 0.1 over it is more (at
# smooth disks it is 0.19/(1-e)^2 as e tends to 1).
_ERROR, _ERROR_NEAR_ONE, _ERROR_OF_RING = {2: 1.6, 3: 2.6}, 0.2, 0.1
# The estimate is a first order in the square of the spacing: true within a tenth; by up to 1.6 too
# small where s takes single values only, and what bounces change is lost again in other ways.
_SAFE, _SAFE_WITH_ATOMS = 1.1, 1.8
COARSEST = 0.1  # the widest spacing that the solver chooses by itself


def guessed_error(law: CollisionLaw, spacing: float, path: float, peaks: bool) -> float:
    """The error of f relative to its maximum, for a smooth start, as measured.

    path : of the fastest tracer at the start until that time, in l
    peaks : the start has delta peaks, of which the first bounces make densities that are as narrow
        as the range of s
    """
    q = law.quadrature
    narrow = _ERROR_NEAR_ONE / (1.0 - law.least_ratio) ** 2
    narrow = max(narrow, _ERROR_OF_RING / float(q.weight @ q.log_loss**2))
    if peaks:
        late = 1.0
        narrow = max(narrow, _ERROR_NEAR_ONE / (math.exp(-law.least_loss) - law.least_ratio) ** 2)
    else:
        late = 1.0 - (1.0 + law.mean_log_loss * path) ** -2.0
    return (_ERROR[law.dimension] + narrow * late) * spacing**2


def sharing_error(law: CollisionLaw, found: NodeMasses, paths: FloatArray, state: State) -> float:
    """What the shares of the bounces, and the straight lines between nodes, change in f.

    A bounce moves its tracers by the mean of its shares, not by ln s, and spreads them: the bias
    and the variance of ln v that come with one bounce, and with the start. Both are lost again as
    tracers slow down, as 1/(1 + N) and its square after N = kappa v t/l. A density g of ln v
    changes by bias g' and by variance g''/2; a straight line is off by h^2 g''/8. This is relative
    to the maximum of f = g/v, or to that of a density of order 1, at the speeds for which f is
    promised. The steps and kinks of a start that is not smooth have derivatives as large as the
    nodes let them be: there the guess for smooth ones bounds it, and next to them f is worse.
    """
    h, kappa = found.spacing, law.mean_log_loss
    bias, variance = _moved(law, h)
    bias, variance = bias / kappa, variance / (2.0 * kappa)
    first = h * h / 6.0  # both, of the shares of the start
    safe = _SAFE_WITH_ATOMS if law.has_atoms else _SAFE
    top, peaks, worst = float(found.x[-1]), state.profile(0) is None, 0.0
    for mass, path in zip(np.abs(found.mass), paths * math.exp(min(top, 300.0)), strict=True):
        if not mass.any():
            continue
        slowed = 1.0 / (1.0 + kappa * path)
        spread = variance * (1.0 - slowed**2) + first * slowed**2 + 0.25 * h * h
        change = np.zeros(mass.size)
        change[1:-1] = (bias * (1.0 - slowed) + first * slowed) / (2.0 * h) * np.abs(
            mass[2:] - mass[:-2]
        ) + 0.5 * spread / h**2 * np.abs(mass[2:] - 2.0 * mass[1:-1] + mass[:-2])
        typical = 0.5 * float(logsumexp(2.0 * found.x, b=mass) - math.log(mass.sum()))
        v = np.exp(np.minimum(found.x - typical, 700.0))  # in their root mean square
        there = v > LOWEST_SPEED
        most = max(float((mass / v)[there].max()), LEAST_MAXIMUM * h)
        error = safe * float((change / v)[there].max()) / most
        guess = guessed_error(law, h, float(path), peaks)
        if h > COARSEST:
            # too coarse for derivatives
            error = max(error, guess)
        elif not state.smooth:
            error = min(error, guess)
        worst = max(worst, error)
    return worst


def remembered_error(
    asked: HarmonicProblem, speeds: LogMeasure, spacing: float, paths: FloatArray
) -> float:
    """What the shares of all bounces so far change in the oscillations that a law leaves for long.

    Bounces by single shares of the speed keep the oscillations of the start in ln v
    (`kinetics.collision.memory`); with N bounces the nodes turn each by k N times the bias of one,
    and lower it by k^2 N/2 times the variance. ``speeds`` are those of the start.
    """
    law = asked.law
    bias, variance = _moved(law, spacing)
    tau = np.log1p(paths * math.exp(0.5 * speeds.log_second_moment()))
    bounces, worst = np.log1p(law.mean_log_loss * np.expm1(tau)) / law.mean_log_loss, 0.0
    for z, size in memory_of(law, asked.state, speeds):
        lost = bounces * (abs(z.imag) * bias + 0.5 * z.imag**2 * variance)
        # a wave and its complex conjugate
        change = 2.0 * size * np.minimum(lost, 1.0) * np.exp(z.real * tau)
        worst = max(worst, float(change.max(initial=0.0)))
    return worst


def _moved(law: CollisionLaw, spacing: float) -> tuple[float, float]:
    """By how much the mean and the mean square of -ln s are wrong in the shares of a bounce."""
    q, shares = law.quadrature, bounce_kernel(law, spacing, 0)
    moved = spacing * np.arange(shares.size)
    bias = abs(float(shares @ moved - q.weight @ q.log_loss))
    # returns to the scatterer before leave the mean as it is
    square = q.weight @ q.log_loss**2 + 2.0 * law.returns(0)[0] * law.mean_log_loss**2
    return bias, abs(float(shares @ moved**2 - square))


def moment_error(averages: Averages, profile: Profile) -> float:
    """Largest relative error of <v> and <v^2> of the masses of m = 0, by the backward equation."""
    found, worst = profile.density, 0.0
    assert isinstance(found, NodeMasses)
    if found.mass.shape[0] == 0:
        return 0.0
    for p in (1.0, 2.0):
        reference = averages.power(p)
        for i, log_v in enumerate(averages.log_reference):
            with np.errstate(under="ignore"):
                # speeds so far above the typical one that their powers overflow hold no mass
                moment = float(found.mass[i] @ np.exp(p * np.minimum(found.x - log_v, 170.0)))
                if profile.peak_speed is not None and profile.peak_weight is not None:
                    off = min(math.log(profile.peak_speed) - float(log_v), 170.0)
                    moment += float(profile.peak_weight[i].real) * math.exp(p * off)
            worst = max(worst, abs(moment / float(reference[i].real) - 1.0))
    return worst

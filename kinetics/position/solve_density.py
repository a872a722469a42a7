"""Solves for g(r, t), the tracers of each initial speed for themselves where these are few.

The equation is linear in the start: the density of a few speeds is the sum of theirs, and each of
them needs its own wave numbers (`kinetics.position.sweep`).
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.moments.displacement import root_mean_square as root_of
from kinetics.moments.velocity import Averages
from kinetics.numerics import FloatArray
from kinetics.numerics.threads import one_blas_thread
from kinetics.position.ballistic_front import fastest_speed, fronts, uncollided_density
from kinetics.position.density import Displacement
from kinetics.position.intermediate_scattering import Scattering
from kinetics.position.once_collided import once_collided
from kinetics.position.sweep import FEW, Sweep
from kinetics.states.isotropic import SpeedSamples
from kinetics.states.state import State

_MOST_SPEEDS = 4  # that are solved for one by one: each costs as much as one
_ALIKE = 3.0  # of the widths of early times that share their wave numbers
_FAR = 50.0  # R beyond which G is below e^-100: it falls as exp(-2 R) or faster
# Tracers of a slow speed have a narrow density, which is high in units of all. It is solved for
# with up to so much more accuracy; beyond, the error is larger than asked for, and says so.
_NARROWEST = 100.0


@one_blas_thread
def solve_displacement(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    times: FloatArray,
    root_mean_square: FloatArray,
    rtol: float,
) -> Displacement:
    """g(r, t) at the times, such that G(R) is right to about rtol, absolute.

    times : in d/U, shape (n_times,); root_mean_square : sqrt(<r^2>) in d, shape (n_times,)
    """
    whole = _without_waves(law, mean_free_path, state, times, root_mean_square, rtol)
    speeds, shares = (np.zeros(0), np.zeros(0)) if state.peaks is None else _distinct(*state.peaks)
    if not 1 < speeds.size <= _MOST_SPEEDS:
        return _solved(whole, law, state, rtol)[0]
    parts, error = [], np.zeros(times.size)
    for speed, share in zip(speeds, shares, strict=True):
        one = SpeedSamples([float(speed)])
        root = root_of(Averages(law, mean_free_path, one, times, 1e-3))
        # an error of its G(R) is so much of that of all
        counts = share * root_mean_square / np.where(root > 0.0, root, 1.0)
        counts = np.where(root > 0.0, counts, share)
        allowed = rtol / np.clip(speeds.size * float(counts.max()), 1.0, _NARROWEST)
        part = _without_waves(law, mean_free_path, one, times, root, rtol)
        part, missed = _solved(part, law, one, float(allowed))
        parts.append((float(share), part))
        error += counts * missed
    systems: Counter[int] = Counter()
    for _, part in parts:
        systems.update(part.systems)
    return replace(
        whole, parts=tuple(parts), error_estimate=float(error.max()), systems=dict(systems)
    )


def _distinct(speed: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Each speed once, with the share of all tracers that have it."""
    distinct, place = np.unique(speed, return_inverse=True)
    return distinct, np.bincount(place, weights=share).astype(float)


def _without_waves(
    law: CollisionLaw,
    mean_free_path: float,
    state: State,
    times: FloatArray,
    root_mean_square: FloatArray,
    rtol: float,
) -> Displacement:
    """The tracers that have not collided, and no others."""
    radius, weight = fronts(state, mean_free_path, times)
    fastest = fastest_speed(state, 0.1 * rtol)
    with np.errstate(over="ignore"):
        # no tracer outruns its initial speed
        reach = np.minimum(times * fastest, _FAR * root_mean_square)
    return Displacement(
        mean_free_path=mean_free_path,
        times=times,
        root_mean_square=root_mean_square,
        panels=(),
        tails=(None,) * times.size,
        cut=np.full(times.size, np.inf),
        uncollided=uncollided_density(state, mean_free_path, times, fastest),
        front_radius=radius,
        front_weight=weight,
        reach=reach,
        error_estimate=0.0,
        systems={},
        dimension=law.dimension,
    )


def _solved(
    found: Displacement, law: CollisionLaw, state: State, rtol: float
) -> tuple[Displacement, FloatArray]:
    """With those that have collided, and what is missed of G(R) at each time, (n_times,)."""
    times, path = found.times, found.mean_free_path
    system = Scattering(law, path, state, times)
    once = once_collided(law, state, path, times, FEW * rtol)
    width = found.root_mean_square / path
    # times with fronts each have their own wave numbers; others share them, as far as they need the
    # same, late ones apart from those at which tracers of a sharp speed still fly freely
    alone = [i for i in range(times.size) if once.has_front(i, FEW * rtol)]
    early = [i for i in range(times.size) if i not in alone and system.flying(i) > FEW * rtol]
    late = [i for i in range(times.size) if i not in alone + early]
    groups = [[i] for i in alone] + [early, *_alike(late, width)]
    sweeps = [Sweep(system, once, width, which, rtol) for which in groups if which]
    for sweep in sweeps:
        sweep.run()
    missed = np.max([sweep.missed for sweep in sweeps], axis=0)
    solved = replace(
        found,
        panels=tuple(panel for sweep in sweeps for panel in sweep.panels),
        tails=tuple(
            next((s.tails[i] for s in sweeps if s.tails[i] is not None), None)
            for i in range(times.size)
        ),
        cut=np.minimum.reduce([sweep.cut() for sweep in sweeps]),
        once=once,
        error_estimate=float(missed.max()),
        systems=dict(system.systems),
    )
    return solved, missed


def _alike(which: list[int], width: FloatArray) -> list[list[int]]:
    """The times in groups that need about the same wave numbers, up to the reciprocal of the width.

    width : sqrt(<r^2>)/l, shape (n_times,); from 1 on all need the same, and one group is quicker
    """
    groups: dict[int, list[int]] = {}
    for i in which:
        level = math.ceil(max(0.0, -math.log(max(float(width[i]), 1e-300)) / math.log(_ALIKE)))
        groups.setdefault(level, []).append(i)
    return list(groups.values())

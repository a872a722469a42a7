"""Velocities that are differences of positions: they know no more than these, and less well.

A camera gives positions. The difference quotient of two frames is the mean velocity between them,
which is slower than the tracer if it collides meanwhile, and has the error of two places.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.arrays import lengths_of
from kinetics.crosscheck.data.options import Units
from kinetics.crosscheck.data.rounding import resolution_of
from kinetics.crosscheck.data.tracks import Tracks

Array = NDArray[np.float64]

#: Rows that are needed where a tracer turns between the frame before and the one after. On a
#: straight flight the difference is the velocity, and on a parabola in a field the central one is.
MIN_TURNS = 20
#: Frames with turns that are needed if velocities are in another unit than positions and times: at
#: one frame, tracers that fall from rest all have twice the quotient before.
MIN_FRAMES = 5
#: A tracer turns where the quotients before and after have a cosine below this, 26 degrees.
COSINE_OF_TURN = 0.9
#: Velocities are a quotient where so many of the turns have it. Of true velocities at close frames
#: some half are the quotient before, and half the one after.
MIN_SHARE_OF_TURNS = 0.9
#: A velocity is a quotient if they differ by less than this fraction, beside the rounding.
SAME_AS_QUOTIENT = 1e-3
#: Lower bound of a squared speed that is divided by: a tracer at rest has no direction.
TINY = 1e-200


def quotient_of_velocities(
    tracks: Tracks, units: Units, units_belong_together: bool = False
) -> str | None:
    """Return which difference quotient the velocities are: "forward", ...; None for measured ones.

    Parameters
    ----------
    tracks : places in d and velocities in U, at all frames
    units : of the data; that of time need not belong to the velocities
    units_belong_together : whether it does: in a field a tracer that has not collided has, from
        rest, twice its mean velocity, which is no quotient
    """
    velocity = tracks.velocity
    if velocity is None or tracks.times.size < 3:
        return None
    place = tracks.place
    durations = np.diff(tracks.times)[:, None, None]
    quotients = np.diff(place, axis=0) / durations
    before = quotients[:-1]
    after = quotients[1:]
    weight = durations[1:] / (durations[:-1] + durations[1:])
    candidates = {
        "forward": after,
        "backward": before,
        "central": weight * after + (1.0 - weight) * before,
        "second-order": (1.0 - weight) * after + weight * before,  # as numpy.gradient has it
    }
    measured = velocity[1:-1]
    place_resolution = resolution_of(place * units.length) / units.length
    speed_resolution = resolution_of(velocity * units.speed) / units.speed
    shortest = np.minimum(durations[:-1], durations[1:])[:, :, 0]
    rounding = 2.0 * place_resolution / shortest
    cosine = np.sum(before * after, axis=2) / np.maximum(
        lengths_of(before) * lengths_of(after), TINY
    )
    is_turn = (cosine < COSINE_OF_TURN) & (lengths_of(after - before) > 4.0 * rounding)
    if np.count_nonzero(is_turn) < MIN_TURNS:
        return None
    n_frames = np.count_nonzero(np.any(is_turn, axis=1))
    for name, quotient in candidates.items():
        unit = _unit_of(measured[is_turn], quotient[is_turn])
        has_other_unit = abs(unit - 1.0) > SAME_AS_QUOTIENT
        if unit <= 0 or (has_other_unit and n_frames < MIN_FRAMES):
            continue
        difference = lengths_of(measured - unit * quotient)
        allowed = SAME_AS_QUOTIENT * lengths_of(measured) + unit * rounding + speed_resolution
        is_quotient = difference <= allowed
        if np.mean(is_quotient[is_turn]) >= MIN_SHARE_OF_TURNS:
            return name
    return None


def _unit_of(velocity: Array, quotient: Array) -> float:
    """Return the median ratio of velocities to quotients along them, of vectors (n, d)."""
    along = np.sum(velocity * quotient, axis=1)
    square = np.sum(quotient**2, axis=1)
    is_moving = square > 0
    if not np.any(is_moving):
        return 1.0
    return float(np.median(along[is_moving] / square[is_moving]))

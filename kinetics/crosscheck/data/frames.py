"""Frames of a trajectory, and their box: positions are unwrapped where that is certain.

Where it is not, they are refused. One rule holds for all formats. Positions with image flags are
unwrapped by these. Others, in a box that is periodic along an axis that is used, are taken as they
are if some are further apart than its side: a program wrapped none. Else they are unwrapped by the
nearest image where no tracer can go half a box between two frames. Velocities tell it, or the steps
to the nearest images: if none is longer than a third of the side, a longer step must have been
longer than two thirds, and then others would lie between. What a frame does not state is as in the
others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from kinetics.crosscheck.data.arrays import Column, Floats, floats_of
from kinetics.crosscheck.data.columns import AXES, SPEEDS, present
from kinetics.crosscheck.data.options import refuse_data

#: Positions further apart than a side by more than this fraction of it are not rounding.
OUTSIDE = 1e-4
#: Steps to the nearest image that are all shorter than this fraction of a side are the true ones.
SURELY_SHORT = 1.0 / 3.0
#: So many steps are needed to tell: of evenly spread ones (2/3)^100 are all that short.
MIN_STEPS = 100
#: A step of this fraction of a side, or more, cannot be told from one around the other way.
HALF_BOX = 0.5


@dataclass(frozen=True)
class Frame:
    """The particles at one time; a quantity that a frame does not state is missing.

    Parameters
    ----------
    time : in the data's unit
    columns : by our names, shape (n,) each
    """

    time: float
    columns: dict[str, Column] = field(default_factory=dict)

    @property
    def n_rows(self) -> int:
        """The number of particles."""
        return max((values.size for values in self.columns.values()), default=0)

    def numbers(self, name: str) -> Floats:
        """Return places or velocities along an axis, shape (n,)."""
        return floats_of(self.columns, name)


@dataclass(frozen=True)
class Box:
    """A rectangular box; where it begins does not matter, as programs differ in that.

    Parameters
    ----------
    sides : by axis; axes that are not in it have no bounds
    periodic : the axes along which it is periodic
    """

    sides: dict[str, float]
    periodic: frozenset[str]

    def may_hold(self, axis: str, places: Floats) -> bool:
        """Return whether places along an axis are no further apart than a side of the box."""
        extent = np.nanmax(places) - np.nanmin(places)
        return bool(extent <= (1.0 + OUTSIDE) * self.sides[axis])


def common_box(where: str, boxes: Sequence[Box | None]) -> Box | None:
    """Return the box of all frames, those that state none too; InputError if it changes."""
    stated = [box for box in boxes if box is not None]
    if not stated:
        return None
    if any(box != stated[0] for box in stated):
        refuse_data(f"{where}: box", "one that changes", "one that is always the same")
    return stated[0]


def unwrap_frames(
    where: str, frames: Sequence[Frame], box: Box | None, axes: Sequence[str]
) -> list[Frame]:
    """Return frames with positions that do not jump; InputError where that is not certain.

    Parameters
    ----------
    where : names the source in messages
    frames : of the same tracers, by the column `tracer`, where they are unwrapped
    box : None where there is none
    axes : those that are used
    """
    if box is None:
        return list(frames)
    unwrapped = list(frames)
    for axis in axes:
        if axis not in box.periodic or not box.sides.get(axis, 0.0) > 0.0:
            continue
        if not any(axis in frame.columns for frame in frames):
            continue
        places = np.concatenate([frame.numbers(axis) for frame in frames])
        if box.may_hold(axis, places):
            unwrapped = _unwrap_axis(where, unwrapped, axis, box.sides[axis])
    return unwrapped


def _unwrap_axis(where: str, frames: list[Frame], axis: str, side: float) -> list[Frame]:
    """Return frames unwrapped along one axis by the nearest image."""
    speed_name = SPEEDS[AXES.index(axis)]
    result = [frames[0]]
    longest_allowed = 0.0
    longest_seen = 0.0
    n_steps = 0
    for previous, frame in pairwise(frames):
        before = _aligned(where, result[-1], frame, axis)
        step = frame.numbers(axis) - before
        step = step - side * np.round(step / side)
        result.append(replace(frame, columns=frame.columns | {axis: before + step}))
        longest_allowed = max(longest_allowed, _longest_step(previous, frame, speed_name))
        longest_seen = max(longest_seen, float(np.max(np.abs(step), initial=0.0)))
        n_steps += step.size
    is_surely_short = longest_seen < SURELY_SHORT * side and n_steps >= MIN_STEPS
    if not (longest_allowed < HALF_BOX * side or is_surely_short):
        got = "those in a periodic box"
        allowed = "unwrapped, or with image flags, or frames that are closer in time"
        refuse_data(f"{where}: positions", got, allowed)
    return result


def _longest_step(previous: Frame, frame: Frame, speed_name: str) -> float:
    """Return how far a tracer may go between two frames; infinite where there are no velocities."""
    if speed_name not in previous.columns:
        return float("inf")
    components = [previous.numbers(name) for name in present(SPEEDS, previous.columns)]
    fastest = float(np.sqrt(np.nanmax(np.sum(np.square(components), axis=0))))
    return fastest * (frame.time - previous.time)


def _aligned(where: str, previous: Frame, frame: Frame, axis: str) -> Floats:
    """Return the places of the tracers of a frame in the frame before."""
    tracers = frame.columns["tracer"]
    order = np.argsort(previous.columns["tracer"], kind="stable")
    sorted_tracers = previous.columns["tracer"][order]
    index = np.searchsorted(sorted_tracers, tracers)
    index = np.minimum(index, sorted_tracers.size - 1)
    if not np.array_equal(sorted_tracers[index], tracers):
        refuse_data(f"{where}: positions", "those in a periodic box of other tracers", "unwrapped")
    return previous.numbers(axis)[order[index]]

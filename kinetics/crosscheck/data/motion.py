"""What no tracer can do where nothing drives it: rows that show exchanged or wrapped tracers.

Without a field, a bath or heating no tracer gets faster, and none goes further than its speed
allows; both hold for each tracer, exactly:

    v(t) <= v(s),   |r(t) - r(s)| <= v(s) (t - s),   s < t

Of positions alone, three successive places on a line, passed at one speed, are a straight flight;
the tracer is never faster later. Begin with `impossible_motion`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.arrays import label_text, lengths_of
from kinetics.crosscheck.data.options import Units, refuse_data
from kinetics.crosscheck.data.rounding import resolution_of
from kinetics.crosscheck.data.tracks import Tracks

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Speeds that rise, and steps that are longer, by less than this fraction are no alarm: averages
#: over an exposure and velocities of three digits differ by as much. At 1e-4 as many switches of
#: 75 were seen.
ALLOWED_EXCESS = 0.02
#: If more than this share of steps is impossible, the fault is in all data, and no switch.
MAX_SHARE_OF_SWITCHES = 0.2
#: A rise of the speed, or an excess of a step, below this fraction of the root mean square of all
#: is an error of measurement and no switch. Chosen: noise of a tenth of the signal.
SMALL_EXCESS = 0.1
#: Steps that are faster, over those that are only longer, below which a unit is wrong.
FASTER_IF_UNIT_IS_WRONG = 0.1
#: Jumps along an axis that differ by less than this fraction are by one length: the side of a box.
SAME_JUMP = 0.1
#: Jumps by one length that show a box. Chosen: two exchanged tracers make two jumps of one length.
MIN_JUMPS = 5
#: Their length over the extent of all places, at least: wrapped places fill the box.
JUMP_OVER_EXTENT = 0.8
#: Impossible steps that are named.
MAX_STEPS_NAMED = 3
#: Share of steps of positions alone that is no alarm: of hard disks with errors of 0.3 d 1 in 7,200
#: was called impossible.
MIN_SHARE_OF_PLACES = 3e-4
#: Errors of a place beyond which a step is longer for sure: of 1e6 Gaussian errors 0.6 are larger.
SURE_ERRORS = 5.0
#: Errors of a place within which two steps have one velocity.
ALIKE_ERRORS = 3.0
#: Velocity of a straight flight over the change that is within the errors: a tracer that bounces
#: between two scatterers close by moves as little, and is fast all the same.
FLIGHT_OVER_ERROR = 2.0
#: Share of the smallest changes of velocity that the error of a place is told from.
QUIET_SHARE = 0.1


@dataclass(frozen=True)
class ImpossibleSteps:
    """Steps between successive frames that no tracer can make.

    Parameters
    ----------
    is_faster, is_further : which steps end with a higher speed, and which are longer than the speed
        before allows, shape (n_times - 1, n)
    is_large : those that are no error of measurement
    n_steps : steps that were looked at
    """

    is_faster: Flags
    is_further: Flags
    is_large: Flags
    n_steps: int

    @property
    def is_impossible(self) -> Flags:
        """Which steps are impossible."""
        return self.is_faster | self.is_further


def impossible_motion(tracks: Tracks, where: str, units: Units) -> list[str]:
    """Return what is to be said of steps that no tracer can make, with the likely reason.

    InputError for positions that jump by the side of a box.

    Parameters
    ----------
    tracks : places in d, absolute or not; velocities in U, or none
    where : names the source in messages
    units : of the data, in which their times are named
    """
    if tracks.times.size < 2:
        return []
    if tracks.velocity is None:
        steps = steps_beyond_straight_flight(tracks, units)
        law = "the tracer goes further than its own straight flight before allows"
    else:
        steps = steps_beyond_speed(tracks, tracks.velocity, units)
        law = "the tracer gets faster, or goes further than its speed allows"
    n_impossible = int(np.count_nonzero(steps.is_impossible))
    share = n_impossible / steps.n_steps
    smallest_share = MIN_SHARE_OF_PLACES if tracks.velocity is None else 0.0
    if share <= smallest_share:
        return []
    is_everywhere = share > MAX_SHARE_OF_SWITCHES
    examples = _named(tracks, units, steps, is_everywhere)
    side = _common_jump(tracks, steps.is_further & steps.is_large)
    if side is not None:
        jumps = f"{n_impossible} steps that jump by about {side * units.length:.4g} ({examples})"
        refuse_data(f"{where}: positions", jumps, "unwrapped: a box of this side wraps them")
    reason = _reason(tracks, steps, is_everywhere)
    return [
        f"{n_impossible} steps ({share:.2g} of all) are impossible without a drive: {law} "
        f"({examples}). {reason}"
    ]


def steps_beyond_speed(tracks: Tracks, velocity: Array, units: Units) -> ImpossibleSteps:
    """Return the steps at whose end a tracer is faster, or further, than its speed allows.

    A tracer that is missing at some frames is compared with where it was seen before.
    """
    place = tracks.place
    n_times = tracks.times.size
    place_resolution = 2.0 * resolution_of(place * units.length) / units.length
    speed_resolution = 2.0 * resolution_of(velocity * units.speed) / units.speed
    speed = lengths_of(velocity)
    rms_speed = np.sqrt(np.nanmean(speed**2))
    is_faster = np.zeros((n_times - 1, tracks.n_tracers), bool)
    is_further = np.zeros_like(is_faster)
    is_large = np.zeros_like(is_faster)
    time_before = np.full(tracks.n_tracers, tracks.times[0])
    place_before = place[0].copy()
    speed_before = speed[0].copy()
    n_steps = 0
    for index in range(1, n_times):
        time = tracks.times[index]
        duration = time - time_before
        step = lengths_of(place[index] - place_before)
        longest = speed_before * duration
        rise = speed[index] - speed_before
        excess = step - longest
        allowed_rise = ALLOWED_EXCESS * speed_before + speed_resolution
        allowed_step = ALLOWED_EXCESS * longest + place_resolution + speed_resolution * duration
        is_faster[index - 1] = rise > allowed_rise
        is_further[index - 1] = excess > allowed_step
        is_seen = np.isfinite(step)
        n_steps += int(np.count_nonzero(is_seen))
        rms_step = np.sqrt(np.mean(step[is_seen] ** 2)) if np.any(is_seen) else 0.0
        is_large[index - 1] = (rise > SMALL_EXCESS * rms_speed) | (excess > SMALL_EXCESS * rms_step)
        is_there = np.isfinite(speed[index])
        place_before[is_there] = place[index, is_there]
        speed_before[is_there] = speed[index, is_there]
        time_before[is_there] = time
    return ImpossibleSteps(is_faster, is_further, is_large, max(n_steps, 1))


# -- positions alone -------------------------------------------------------------------------------


def steps_beyond_straight_flight(tracks: Tracks, units: Units) -> ImpossibleSteps:
    """Return the steps that are longer than the speed of a straight flight before allows."""
    place = tracks.place
    durations = np.diff(tracks.times)[:, None]
    steps = np.diff(place, axis=0)
    lengths = lengths_of(steps)
    velocities = steps / durations[:, :, None]
    turns = lengths_of(np.diff(velocities, axis=0))
    # of the difference of two velocities, for a place with an error of 1
    turn_errors = np.sqrt(
        2.0 / durations[1:] ** 2
        + 2.0 / durations[:-1] ** 2
        + 2.0 / (durations[1:] * durations[:-1])
    )
    resolution = resolution_of(place * units.length) / units.length
    place_error = max(_quiet_error(turns / turn_errors), resolution)
    length_error = SURE_ERRORS * np.sqrt(2.0) * place_error
    largest_turn = ALIKE_ERRORS * place_error * turn_errors
    mean_velocity = lengths_of(velocities[1:] + velocities[:-1]) / 2.0
    is_straight = (turns <= largest_turn) & (mean_velocity > FLIGHT_OVER_ERROR * largest_turn)
    is_further = np.zeros(lengths.shape, bool)
    is_large = np.zeros(lengths.shape, bool)
    top_speed = np.full(tracks.n_tracers, np.inf)
    for index in range(len(lengths)):
        length = lengths[index]
        longest = top_speed * durations[index]
        excess = length - longest
        is_further[index] = excess > ALLOWED_EXCESS * longest + length_error
        is_seen = np.isfinite(length)
        rms_length = np.sqrt(np.mean(length[is_seen] ** 2)) if np.any(is_seen) else 0.0
        is_large[index] = excess > SMALL_EXCESS * rms_length
        if index > 0:
            flown = lengths_of(place[index + 1] - place[index - 1])
            duration = tracks.times[index + 1] - tracks.times[index - 1]
            seen_speed = (flown + length_error) / duration
            has_flown = is_straight[index - 1] & ~is_further[index]
            top_speed[has_flown] = np.minimum(top_speed, seen_speed)[has_flown]
    n_steps = int(np.count_nonzero(np.isfinite(lengths)))
    return ImpossibleSteps(np.zeros_like(is_further), is_further, is_large, max(n_steps, 1))


def _quiet_error(scaled_turns: Array) -> float:
    """Return an upper bound of the error of a component of a place.

    Without collisions a change of velocity, over that of an error of 1, is the length of a Gaussian
    vector in the plane. The smallest of changes are those of straight flights: the error that
    their quantile has is too large where few fly straight, and then less is called impossible.
    """
    errors = []
    for turns in scaled_turns:
        is_seen = np.isfinite(turns)
        if np.any(is_seen):
            errors.append(np.quantile(turns[is_seen], QUIET_SHARE))
    quantile_of_unit = np.sqrt(-2.0 * np.log(1.0 - QUIET_SHARE))
    return float(min(errors, default=0.0) / quantile_of_unit)


# -- words -----------------------------------------------------------------------------------------


def _named(tracks: Tracks, units: Units, steps: ImpossibleSteps, is_everywhere: bool) -> str:
    """Return some of the impossible steps: tracers, and times in the unit of the data."""
    shown = steps.is_impossible
    if not is_everywhere and np.any(shown & steps.is_large):
        shown = shown & steps.is_large
    names = []
    for index, tracer in np.argwhere(shown)[:MAX_STEPS_NAMED].tolist():
        label = tracer if tracks.tracer is None else label_text(tracks.tracer[tracer])
        names.append(f"tracer {label} at time {tracks.times[index + 1] * units.time:.6g}")
    return ", ".join(names)


def _reason(tracks: Tracks, steps: ImpossibleSteps, is_everywhere: bool) -> str:
    """Return the likely reason of impossible steps."""
    n_faster = np.count_nonzero(steps.is_faster)
    n_further = np.count_nonzero(steps.is_further)
    if is_everywhere:
        if n_faster <= FASTER_IF_UNIT_IS_WRONG * n_further and tracks.velocity is not None:
            return (
                "So many are so that the units of length, speed and time may not belong together "
                "(--speed-unit, --length-unit, --time-unit), or places have large errors."
            )
        return "So many are so that places or velocities have large errors, or something drives."
    if not np.any(steps.is_impossible & steps.is_large):
        return "They are so by little: places or velocities have errors."
    return "Two tracers may have been exchanged, or positions wrapped in a box."


def _common_jump(tracks: Tracks, is_jump: Flags) -> float | None:
    """Return the length by which most jumps go along an axis, that of a box; None for others."""
    jumps = np.abs(np.diff(tracks.place, axis=0))[is_jump]
    jumps = jumps[np.isfinite(jumps).all(axis=1)]
    if len(jumps) < MIN_JUMPS:
        return None
    longest = jumps.max(axis=1)
    side = float(np.median(longest))
    extent = np.nanmax(tracks.place, axis=(0, 1)) - np.nanmin(tracks.place, axis=(0, 1))
    is_alike = np.abs(longest - side) < SAME_JUMP * side
    is_box = np.mean(is_alike) > 0.5 and side > JUMP_OVER_EXTENT * extent.min()
    return side if is_box else None

"""Tracks that end early: whether those that end were faster than the others.

A tracer that leaves the picture of a camera, or that a cap on collisions stops, is not missing at
random: the fast ones end first, or those that went far, and what remains cools and spreads too
little. Begin with `without_biased_ends`.

d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.arrays import is_there_or_later, lengths_of
from kinetics.crosscheck.data.tracks import Tracks
from kinetics.crosscheck.words import numeral

Array = NDArray[np.float64]

#: Tracks that end, and as many that do not, from which they are compared. Chosen: with fewer than
#: eight of each the ranks of Mann and Whitney's test are not near a Gaussian.
MIN_TRACKS = 10
#: Standard errors of Mann and Whitney's test from which the two are different. Chosen: by chance 1
#: in 2,000 data sets are; of 180 simulated sets whose tracks end at random none was.
DIFFERENT_SIGMAS = 3.5
#: Share of the tracks that may have ended, at most. Chosen: of a Gaussian in the plane the fastest
#: percent has 5.6 % of <v^2>.
MAX_ENDED = 0.01
#: Margins of the picture that are tried, over its smaller side: tracks that start further inside
#: leave later. At 0.5 nothing is left. Chosen: a few, as each only needs a count.
MARGINS = np.linspace(0.0, 0.45, 10)
#: Tracks that must remain. Chosen: of a Gaussian in the plane <v^2> of fewer has an error above
#: 14 %.
MIN_REMAINING_TRACKS = 50
#: Times that must remain. Chosen: the start, and two more to tell a trend.
MIN_REMAINING_TIMES = 3


def without_biased_ends(tracks: Tracks) -> Tracks:
    """Return tracks up to the time when some end, if fast tracers end early; and say so.

    Of the tracks that begin inside a margin of the picture, fewer leave it early. Where a track
    begins does not depend on its speed: these are chosen without looking at what it does. The
    margin with which most rows remain is taken.

    Parameters
    ----------
    tracks : places in d. The picture is the region of all places: where these are displacements
        from each track's start, its border is where those are that went far
    """
    is_there = np.isfinite(tracks.place[:, :, 0])
    has_ended = ~is_there[-1]
    if np.count_nonzero(has_ended) < MIN_TRACKS:
        return tracks
    n_others = int(np.count_nonzero(~has_ended))
    if n_others < MIN_TRACKS:
        remark = (
            f"Only {n_others} of {tracks.n_tracers} tracks last until the last frame: whether the "
            "others end because they are fast cannot be tested."
        )
        return replace(tracks, remarks=(*tracks.remarks, remark))
    sigmas_faster = _sigmas_above(_early_motion(tracks), has_ended)
    sigmas_inside = _sigmas_above(_last_distance(tracks.place, is_there), has_ended)
    fact = f"{np.count_nonzero(has_ended)} of {tracks.n_tracers} tracks end early, and they are"
    if abs(sigmas_faster) > DIFFERENT_SIGMAS:
        word = "faster" if sigmas_faster > 0 else "slower"
        fact += f" {word} at first than the others ({numeral(abs(sigmas_faster), '.1f')} sigma)"
    elif sigmas_inside < -DIFFERENT_SIGMAS:
        fact += f" near the border of the picture then ({numeral(-sigmas_inside, '.1f')} sigma)"
    else:
        return tracks
    fact += ": those that remain are no fair sample."
    is_chosen, n_times = _fair_tracks(tracks.place, is_there)
    if n_times < MIN_REMAINING_TIMES:
        remark = (
            f"{fact} No margin and time leave enough tracks of which few have ended: the results "
            "are biased."
        )
        return replace(tracks, remarks=(*tracks.remarks, remark))
    end = numeral(tracks.times[n_times - 1], ".4g")
    start = int(np.count_nonzero(is_chosen))
    remark = (
        f"{fact} Only times up to t = {end} d/U and the {start} tracks are used that begin in the "
        "first frame so far inside that few end before."
    )
    fair = tracks.select_tracers(is_chosen)
    return replace(
        fair,
        times=fair.times[:n_times],
        place=fair.place[:n_times],
        velocity=None if fair.velocity is None else fair.velocity[:n_times],
        remarks=(*fair.remarks, remark),
    )


def _early_motion(tracks: Tracks) -> Array:
    """Return the speed, or the length of the step, at the first frame; NaN if unknown. (n,)."""
    if tracks.velocity is not None:
        return lengths_of(tracks.velocity[0])
    if tracks.times.size < 2:
        return np.full(tracks.n_tracers, np.nan)
    return lengths_of(tracks.place[1] - tracks.place[0])


def _last_distance(place: Array, is_there: NDArray[np.bool_]) -> Array:
    """Return how far inside the region of all places each track was seen last, shape (n,)."""
    n_times = len(place)
    last = n_times - 1 - np.argmax(is_there[::-1], axis=0)
    last_place = place[last, np.arange(place.shape[1])]
    low, high = _picture(place)
    return _distance_inside(last_place, low, high)


def _picture(place: Array) -> tuple[Array, Array]:
    """Return the lowest and the highest place along each axis, shape (d,) each."""
    return np.nanmin(place, axis=(0, 1)), np.nanmax(place, axis=(0, 1))


def _distance_inside(place: Array, low: Array, high: Array) -> Array:
    """Return how far places (n, d) are from the nearest border of a picture, shape (n,)."""
    return np.asarray(np.minimum(place - low, high - place).min(axis=1))


def _sigmas_above(values: Array, has_ended: NDArray[np.bool_]) -> float:
    """Return by how many standard errors values are larger of tracks that end than of the others.

    It is the test of Mann and Whitney, on ranks.
    """
    from scipy.stats import rankdata

    is_known = np.isfinite(values)
    n_ended = int(np.count_nonzero(is_known & has_ended))
    n_others = int(np.count_nonzero(is_known & ~has_ended))
    if min(n_ended, n_others) < MIN_TRACKS:
        return 0.0
    ranks = rankdata(values[is_known])
    mean_rank = ranks[has_ended[is_known]].mean()
    n = n_ended + n_others
    spread = np.sqrt((n + 1) * n_others / (12.0 * n_ended))
    return float((mean_rank - (n + 1) / 2.0) / spread)


def _fair_tracks(place: Array, is_there: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], int]:
    """Return which tracks are used, and up to how many times; 0 times if there is no choice."""
    low, high = _picture(place)
    side = float((high - low).min())
    distance = _distance_inside(place[0], low, high)
    is_seen_later = is_there_or_later(is_there)
    choice = np.zeros(is_there.shape[1], bool)
    n_times = 0
    for margin in MARGINS:
        with np.errstate(invalid="ignore"):
            is_inside = is_there[0] & (distance >= margin * side)
        n_tracks = int(np.count_nonzero(is_inside))
        if n_tracks < MIN_REMAINING_TRACKS:
            continue
        ended = np.mean(~is_seen_later[:, is_inside], axis=1)
        n_fair = int(np.count_nonzero(ended <= MAX_ENDED))
        if n_tracks * n_fair > np.count_nonzero(choice) * n_times:
            choice = is_inside
            n_times = n_fair
    return choice, n_times

"""Mean square displacements between pairs of frames: what positions alone know.

    M(s, t) = <|r(t) - r(s)|^2>, over the tracers that are there at both times

T frames have T (T - 1)/2 pairs, more than few tracks can bear: `choose_pairs` takes some 26 that
have nearly all that the data know. Begin with `sum_over_pairs`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Frames between which all pairs are taken: the first, and others even in the logarithm of the
#: time. Chosen: 7 anchors have 26 or 27 pairs, whose fit was unbiased for 300 and 1,000 tracks.
N_ANCHORS = 7
#: Least share of tracers at a frame, or at both of a pair, of those at the frame or the pair with
#: most. Chosen: a mean over a tenth of them has three times the error.
MIN_SHARE_THERE = 0.1
#: Tracers at both frames of a pair: one has no spread.
MIN_TRACERS = 2
#: Sums of a pair: tracers, and the second and the fourth power of their displacement.
N_SUMS = 3


@dataclass(frozen=True, eq=False)
class FramePairs:
    """Sums over groups of tracers of their displacements between two frames, in d.

    Parameters
    ----------
    earlier, later : indices of the frames s < t in the times of the sample, shape (n_pairs,)
    sums : of 1, |dr|^2 and |dr|^4 over the tracers that are there at both frames, in the order of
        the groups of the sample, shape (n_groups, n_pairs, 3)
    """

    earlier: Indices
    later: Indices
    sums: Array

    @property
    def has_tracers(self) -> NDArray[np.bool_]:
        """Which groups have tracers in some pair, shape (n_groups,)."""
        return np.asarray(self.sums[..., 0].sum(axis=1) > 0)

    def of_groups(self, is_chosen: NDArray[np.bool_]) -> FramePairs:
        """Return the sums of some of the groups."""
        return replace(self, sums=self.sums[is_chosen])


def choose_pairs(times: Array) -> tuple[Indices, Indices]:
    """Return the earlier and the later frames of pairs, shape (n_pairs,) each.

    All pairs of the anchors are taken, each anchor with its next frame, and the last frame with the
    one before: close frames tell the speed and the error of a position, distant ones the cooling.

    Parameters
    ----------
    times : from 0 on, rising, shape (n_times,)
    """
    last = times.size - 1
    if last < 1:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    wanted = np.append(times[0], np.geomspace(times[1], times[last], N_ANCHORS - 1))
    distances = np.abs(times - wanted[:, None])
    anchors = np.unique(np.argmin(distances, axis=1))
    first_of_pair, second_of_pair = np.triu_indices(anchors.size, 1)
    pairs = np.stack([anchors[first_of_pair], anchors[second_of_pair]], axis=1)
    with_next = np.stack([anchors[:-1], anchors[:-1] + 1], axis=1)
    at_the_end = [[last - 1, last]]
    pairs = np.unique(np.concatenate([pairs, with_next, at_the_end]), axis=0)
    return pairs[:, 0], pairs[:, 1]


def sum_over_pairs(times: Array, place: Array, group: Indices, n_groups: int) -> FramePairs:
    """Return the sums of tracers over pairs of frames.

    Parameters
    ----------
    times : from 0 on, rising, shape (n_times,)
    place : NaN where a tracer is not there, shape (n_times, n, d)
    group : of each tracer, shape (n,)
    n_groups : how many groups there are
    """
    earlier, later = _pairs_with_tracers(times, np.isfinite(place[:, :, 0]))
    sums = np.zeros((n_groups, earlier.size, N_SUMS))
    for index in range(earlier.size):
        displacement = place[later[index]] - place[earlier[index]]
        square = np.sum(displacement**2, axis=1)
        is_there = np.isfinite(square)
        for power in range(N_SUMS):
            weights = square[is_there] ** power
            sums[:, index, power] = np.bincount(group[is_there], weights, n_groups)
    return FramePairs(earlier, later, sums)


def _pairs_with_tracers(times: Array, is_there: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Return pairs of frames that enough tracers share; is_there : (n_times, n)."""
    n_there = np.count_nonzero(is_there, axis=1)
    frames = np.flatnonzero(n_there >= MIN_SHARE_THERE * n_there.max())
    first, second = choose_pairs(times[frames])
    earlier = frames[first]
    later = frames[second]
    n_shared = np.array(
        [np.count_nonzero(is_there[s] & is_there[t]) for s, t in zip(earlier, later, strict=True)],
        dtype=np.int64,
    )
    fewest = max(MIN_TRACERS, MIN_SHARE_THERE * int(n_shared.max(initial=0)))
    is_used = n_shared >= fewest
    return earlier[is_used], later[is_used]

"""Which times a fit and its test look at: few, so that their errors are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.compare.measured import Measured
from kinetics.crosscheck.compare.observables import BETWEEN_FRAMES
from kinetics.crosscheck.data.sample import Sample

Indices = NDArray[np.int64]

#: Times of a fit, even in the logarithm. Of closer frames only the increments say something new,
#: and each of these is a count of few collisions. Chosen: unbiased for 100 tracks and more.
N_TIMES = 7
#: Times at which fourth moments are tested: the last, and two that are even in the logarithm.
N_TIMES_OF_FOURTH = 3
#: Times that are shown at most, beside the frames of pairs.
MAX_ROW_TIMES = 64
#: Tracers that have collided by the first time of a fit: the mean of fewer is not Gaussian.
MIN_COLLIDED = 20
#: Of tracers at the time t, t/l U times this have collided, while few have.
COLLIDED_PER_PATH = 1.25


def fit_times(sample: Sample, path: float, only_complete: bool) -> Indices:
    """Return the indices of the times that a fit looks at, with time 0 where it is there.

    Parameters
    ----------
    path : mean free path in d, roughly
    only_complete : whether only times at which no tracer has ended
    """
    times = sample.times
    is_allowed = (times > 0.0) & (sample.samples > 0)
    if only_complete:
        is_allowed &= sample.is_complete
    if not np.any(is_allowed):
        return np.arange(times.size)
    most = int(sample.samples.max())
    earliest = min(MIN_COLLIDED * path / (COLLIDED_PER_PATH * max(most, 1)), times[-1] / 2.0)
    late = np.flatnonzero(is_allowed & (times >= earliest))
    if late.size < 2:
        late = np.flatnonzero(is_allowed)
    wanted = np.geomspace(times[late[0]], times[late[-1]], N_TIMES)
    distance = np.abs(np.log(times[late] / wanted[:, None]))
    chosen = late[np.argmin(distance, axis=1)]
    at_start = np.flatnonzero(times == 0.0)
    of_pairs = np.empty(0, np.int64)
    if sample.pairs is not None:
        of_pairs = np.concatenate([sample.pairs.earlier, sample.pairs.later])
    return np.unique(np.concatenate([at_start, chosen, of_pairs]))


def row_times(sample: Sample) -> Indices:
    """Return the indices of the times that are shown: of many, some even in the logarithm.

    The first and the last are among them, and every frame of a pair.
    """
    times = sample.times
    if times.size <= MAX_ROW_TIMES:
        return np.arange(times.size)
    first = int(np.argmax(times > 0.0))
    wanted = np.geomspace(times[first], times[-1], MAX_ROW_TIMES - 1)
    chosen = np.searchsorted(times, wanted).clip(0, times.size - 1)
    frames = np.empty(0, np.int64)
    if sample.pairs is not None:
        frames = np.concatenate([sample.pairs.earlier, sample.pairs.later])
    return np.unique(np.concatenate([[0], chosen, frames, [times.size - 1]]))


def tested_components(measured: Measured) -> Indices:
    """Return the components of the one test of all averages.

    Second moments, and means along x, at the times of the fit; fourth moments at three of them. Of
    positions alone, all pairs of frames and the kurtosis of the displacement. Not time 0: what has
    changed since then hangs on the few tracers that have collided by the first of the times.
    """
    layout = measured.layout
    chosen = layout.time > 0.0
    for name in ("a2", "kurtosis"):
        indices = layout.indices_of(name)
        indices = indices[layout.time[indices] > 0.0]
        chosen[indices] = False
        if indices.size:
            chosen[indices[even_in_logarithm(layout.time[indices])]] = True
    if layout.pairs is not None:
        chosen &= ~layout.is_of("msd")
        assert np.any(layout.is_of(BETWEEN_FRAMES))
    return np.flatnonzero(chosen)


def even_in_logarithm(times: NDArray[np.float64]) -> Indices:
    """Return the indices of a few of rising times, with the last."""
    wanted = np.geomspace(times[0], times[-1], N_TIMES_OF_FOURTH + 1)[1:]
    return np.unique(np.argmin(np.abs(np.log(times / wanted[:, None])), axis=1))

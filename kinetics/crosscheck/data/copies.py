"""Copies of tracers under other labels: they are not independent, and errors are too small."""

from __future__ import annotations

import numpy as np

from kinetics.crosscheck.data.tracks import Tracks

#: Share of the tracers that must be copies to be named. The origin of the number is not recorded.
MIN_SHARE = 0.01
#: Copies that there must be to be named. The origin of the number is not recorded.
MIN_COPIES = 3
#: Tracers that are at one place at the last time, over copies, above which numbers are so coarse
#: that different tracers have the same ones.
MAX_AT_ONE_PLACE = 2.0


def warnings_of_copies(tracks: Tracks) -> list[str]:
    """Return what is to be said if tracers move exactly as others do, at all times; or nothing.

    Of one label it is refused elsewhere. Tracers that never move are not counted.
    """
    has_moved = np.any(np.nan_to_num(tracks.place) != 0.0, axis=(0, 2))
    moving = tracks.select_tracers(has_moved)
    if moving.times.size < 2 or moving.n_tracers == 0:
        return []
    tracers = moving.place
    if moving.velocity is not None:
        tracers = np.concatenate([tracers, moving.velocity], axis=2)
    n_copies = _count_copies(tracers)
    is_many = n_copies >= max(MIN_COPIES, MIN_SHARE * moving.n_tracers)
    if not is_many or _count_copies(moving.place[-1:]) > MAX_AT_ONE_PLACE * n_copies:
        return []
    return [
        f"{n_copies} of {tracks.n_tracers} tracers are copies: they move exactly as another does, "
        "under another label. They are not independent: errors are larger than these. Leave them "
        "out."
    ]


def _count_copies(tracers: np.ndarray) -> int:
    """Return how many tracers (n_times, n, n_numbers) have the numbers of one before them."""
    rows = np.ascontiguousarray(np.moveaxis(tracers, 1, 0).reshape(tracers.shape[1], -1)) + 0.0
    keys = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    return len(rows) - np.unique(keys).size

"""Tracks that end early because fast tracers leave the picture do not bias what is read."""

import numpy as np
import pytest
from camera_data import FRAME_TIMES, Tracks, mean_squares, sample_of, table_of, true_mean_squares

from kinetics.crosscheck.data.sample import R2, N


def seen_in_picture(tracks: Tracks, side: float) -> np.ndarray:
    """Places in a square picture, NaN after a tracer has left it; it starts anywhere in it."""
    start = np.random.default_rng(3).uniform(0.0, side, (tracks[0].shape[1], 2))
    place = tracks[0] - tracks[0][0] + start
    is_inside = np.all((place > 0.0) & (place < side), axis=2)
    has_stayed = np.logical_and.accumulate(is_inside, axis=0)
    return np.where(has_stayed[..., None], place, np.nan)


@pytest.mark.parametrize("with_velocities", [True, False])
@pytest.mark.parametrize("side", [60.0, 300.0])
def test_tracks_that_leave_the_picture_are_cut_before(
    tracks: Tracks, side: float, with_velocities: bool
) -> None:
    place = seen_in_picture(tracks, side)
    frame = table_of(place, tracks[1] if with_velocities else None).dropna()
    sample = sample_of(frame)
    assert any("no fair sample" in text for text in sample.warnings)
    assert sample.times[-1] < FRAME_TIMES[-1]
    assert sample.samples[-1] > 0.98 * sample.samples[0]
    sums = sample.sums.sum(axis=0)
    msd = sums[-1, R2] / sums[-1, N]
    last = int(sample.times[-1])
    square = np.sum((tracks[0][last] - tracks[0][0]) ** 2, axis=1)
    error = square.std() / np.sqrt(sample.samples[-1])
    assert abs(msd - square.mean()) < 3.0 * error


def test_the_mean_square_of_the_tracks_that_stay_is_biased(tracks: Tracks) -> None:
    """What the cut is for: uncut, the last value would be ten errors off."""
    place = seen_in_picture(tracks, 60.0)
    square = np.sum((tracks[0][-1] - tracks[0][0]) ** 2, axis=1)
    of_those_that_stay = np.nanmean(np.sum((place[-1] - place[0]) ** 2, axis=1))
    assert of_those_that_stay < square.mean() - 10.0 * square.std() / np.sqrt(600)


def test_tracks_that_are_lost_at_random_are_used_to_their_ends(tracks: Tracks) -> None:
    lengths = np.random.default_rng(5).integers(2, 200, 600)
    is_there = np.arange(61)[:, None] < lengths
    place = np.where(is_there[..., None], tracks[0], np.nan)
    sample = sample_of(table_of(place).dropna())
    assert sample.times[-1] == FRAME_TIMES[-1]
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, place))
    assert not any("no fair sample" in text for text in sample.warnings)


def test_that_nearly_all_tracks_end_is_said(tracks: Tracks) -> None:
    """Fewer than ten last to the end: there is nothing to compare those that end with."""
    is_there = np.ones((61, 600), bool)
    is_there[40:, 5:] = False
    place = np.where(is_there[..., None], tracks[0], np.nan)
    sample = sample_of(table_of(place).dropna())
    assert any("Only 5 of 600 tracks last" in text for text in sample.warnings)


def test_tracks_of_a_picture_are_not_taken_for_wrapped(tracks: Tracks) -> None:
    sample = sample_of(table_of(seen_in_picture(tracks, 60.0)).dropna())
    assert sample.samples[0] > 100

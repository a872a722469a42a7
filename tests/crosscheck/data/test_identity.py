"""Rows without the label of a tracer: errors must not be those of independent times."""

from pathlib import Path

import numpy as np
import pytest
from camera_data import FRAME_TIMES, Tracks, sample_of, table_of

from kinetics.crosscheck.data.identity import share_in_order
from kinetics.crosscheck.data.reading import read_sample
from kinetics.crosscheck.data.tracks import Tracks as DataTracks
from kinetics.errors import InputError


def without_labels(tracks: Tracks) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and velocities in the same order at all times."""
    return tracks[0] - tracks[0][0], tracks[1]


def test_rows_in_another_order_at_each_time_are_refused(tracks: Tracks) -> None:
    frame = table_of(*without_labels(tracks)).drop(columns="tracer")
    shuffled = frame.sample(frac=1.0, random_state=1).sort_values("time", kind="stable")
    with pytest.raises(InputError, match=r"no column tracer.*another order"):
        sample_of(shuffled, positions="displacement")


def test_rows_in_one_order_are_tracers(tracks: Tracks) -> None:
    frame = table_of(*without_labels(tracks))
    labelled = sample_of(frame)
    sample = sample_of(frame.drop(columns="tracer"))
    np.testing.assert_allclose(sample.sums, labelled.sums)


def test_rows_of_configurations_need_no_order(tracks: Tracks) -> None:
    frame = table_of(*without_labels(tracks))
    frame["medium"] = frame["tracer"] // 20
    labelled = sample_of(frame)
    shuffled = frame.drop(columns="tracer").sample(frac=1.0, random_state=1)
    sample = sample_of(shuffled, positions="displacement")
    np.testing.assert_allclose(sample.sums, labelled.sums)
    assert not any("impossible" in text for text in sample.warnings)


def test_a_label_for_each_row_is_refused(tracks: Tracks) -> None:
    frame = table_of(*tracks)
    frame["tracer"] = np.arange(len(frame))
    with pytest.raises(InputError, match="another label in every row"):
        sample_of(frame)


@pytest.mark.parametrize("has_labels", [True, False])
def test_files_of_one_time_each_are_joined_by_labels_alone(
    tmp_path: Path, tracks: Tracks, has_labels: bool
) -> None:
    frame = table_of(*without_labels(tracks))
    whole = sample_of(frame[frame["time"] % 20 == 0])
    files = []
    for time in FRAME_TIMES[::20]:
        rows = frame[frame["time"] == time].sample(frac=1.0, random_state=1)
        files.append(tmp_path / f"{time:g}.csv")
        rows.drop(columns=[] if has_labels else ["tracer"]).to_csv(files[-1], index=False)
    if not has_labels:
        with pytest.raises(InputError, match=r"one time each.*column tracer"):
            read_sample(files)
        return
    np.testing.assert_allclose(read_sample(files).sums, whole.sums)


def test_a_dozen_walks_in_the_plane_tell_their_order() -> None:
    """The standard error of the share is below 0.25: 12 rows, half of <r^2> from the step before.

    Three of them are too few.
    """
    generator = np.random.default_rng(2)
    times = np.arange(4.0)
    for n, is_known in ((12, True), (3, False)):
        walks = np.cumsum(generator.normal(size=(4, n, 2)), axis=0)
        share = share_in_order(DataTracks(times, walks - walks[0], None))
        assert (share is not None) == is_known

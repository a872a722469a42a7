"""Positions without velocities: what is summed, over which tracers, from which formats."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from camera_data import (
    FRAME_TIMES,
    Tracks,
    mean_squares,
    pairs_of,
    sample_of,
    simulated_tracks,
    table_of,
    true_mean_squares,
)

from kinetics.crosscheck.data.reading import read_sample
from kinetics.crosscheck.data.sample import R2, R4, V2, V4, N
from kinetics.errors import InputError
from particles import BoltzmannGrad, simulate


def test_pairs_of_frames_have_the_mean_squares_of_the_tracks(tracks: Tracks) -> None:
    sample = sample_of(table_of(tracks[0]))
    pairs = pairs_of(sample)
    assert not sample.has_velocities
    assert pairs.sums.shape == (sample.groups, pairs.earlier.size, 3)
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, tracks[0]))
    assert np.all(pairs.earlier < pairs.later)
    assert pairs.earlier.size >= 20


def test_data_with_velocities_have_no_pairs(tracks: Tracks) -> None:
    sample = sample_of(table_of(*tracks))
    assert sample.has_velocities
    assert sample.pairs is None


def test_averages_of_the_speed_are_not_numbers(tracks: Tracks) -> None:
    sample = sample_of(table_of(tracks[0]))
    sums = sample.sums.sum(axis=0)
    displacement = tracks[0] - tracks[0][0]
    square = np.sum(displacement**2, axis=2)
    assert np.all(np.isnan(sums[:, [V2, V4]]))
    np.testing.assert_allclose(sums[:, R2], square.sum(axis=1))
    np.testing.assert_allclose(sums[:, R4], (square**2).sum(axis=1))
    assert sample.speeds is None
    assert sample.start is None


@pytest.mark.parametrize("name", ["a.csv", "trackpy", "a.npz", "a.h5", "a.dump", "a.xyz", "a.gsd"])
def test_every_format_may_come_without_velocities(
    tmp_path: Path, tracks: Tracks, name: str
) -> None:
    place = tracks[0][::6, :200]
    times = FRAME_TIMES[::6]
    source: Any = tmp_path / name
    WRITERS[name](source, place, times)
    if name == "trackpy":
        frame = table_of(place, times=np.arange(len(times)))
        frame = frame.rename(columns={"time": "frame", "tracer": "particle"})
        source = {column: frame[column] for column in frame}
    sample = read_sample([source], frame_interval=6.0)
    np.testing.assert_allclose(sample.times, times)
    expected = true_mean_squares(sample, place)
    np.testing.assert_allclose(mean_squares(sample), expected, rtol=1e-5)


def write_h5md(path: Path, place: np.ndarray, times: np.ndarray) -> None:
    with h5py.File(path, "w") as file:
        file.create_group("h5md").attrs["version"] = [1, 1]
        group = file.create_group("particles/all")
        group.create_group("box").attrs["boundary"] = np.array(["none"] * 2, "S8")
        group["position/value"] = place
        group["position/time"] = times


def write_dump(path: Path, place: np.ndarray, times: np.ndarray) -> None:
    lines = []
    for step, r in enumerate(place):
        lines += ["ITEM: TIMESTEP", str(step), "ITEM: NUMBER OF ATOMS", str(len(r))]
        lines += ["ITEM: BOX BOUNDS ff ff pp", "0 50", "0 50", "0 1", "ITEM: ATOMS id xu yu"]
        lines += [f"{k} {x!r} {y!r}" for k, (x, y) in enumerate(r.tolist())]
    path.write_text("\n".join(lines) + "\n")


def write_xyz(path: Path, place: np.ndarray, times: np.ndarray) -> None:
    lines = []
    for time, r in zip(times, place, strict=True):
        lines += [str(len(r)), f"Properties=id:I:1:pos:R:2 Time={time:g}"]
        lines += [f"{k} {x!r} {y!r}" for k, (x, y) in enumerate(r.tolist())]
    path.write_text("\n".join(lines) + "\n")


def write_gsd(path: Path, place: np.ndarray, times: np.ndarray) -> None:
    hoomd = pytest.importorskip("gsd.hoomd")
    with hoomd.open(str(path), "w") as file:
        for step, r in enumerate(place):
            frame = hoomd.Frame()
            frame.configuration.step = step
            frame.configuration.dimensions = 2
            frame.configuration.box = [1e3, 1e3, 0, 0, 0, 0]
            frame.particles.N = len(r)
            frame.particles.position = np.column_stack([r, np.zeros(len(r))])
            file.append(frame)


WRITERS: dict[str, Any] = {
    "a.csv": lambda path, place, times: table_of(place, times=times).to_csv(path, index=False),
    "trackpy": lambda path, place, times: None,
    "a.npz": lambda path, place, times: np.savez(path, times=times, positions=place),
    "a.h5": write_h5md,
    "a.dump": write_dump,
    "a.xyz": write_xyz,
    "a.gsd": write_gsd,
}


def test_a_tracer_counts_in_the_pairs_where_it_is_there_at_both(tracks: Tracks) -> None:
    place = tracks[0].copy()
    is_missing = np.random.default_rng(5).random(place.shape[:2]) < 0.1
    place[is_missing] = np.nan
    sample = sample_of(table_of(place).dropna())
    pairs = pairs_of(sample)
    is_there = ~is_missing
    expected = np.count_nonzero(is_there[pairs.earlier] & is_there[pairs.later], axis=1)
    np.testing.assert_array_equal(pairs.sums[..., N].sum(axis=0), expected)
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, place))


def test_tracks_that_begin_late_share_the_clock_of_the_others(tracks: Tracks) -> None:
    place = tracks[0].copy()
    place[:20, :300] = np.nan
    sample = sample_of(table_of(place).dropna())
    assert sample.samples[0] == 300
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, place))
    assert any("300 tracks begin after" in text for text in sample.warnings)


@pytest.mark.parametrize("with_velocities", [True, False])
def test_tracks_that_all_begin_at_different_times_have_clocks_of_their_own(
    tracks: Tracks, with_velocities: bool
) -> None:
    velocity = tracks[1] if with_velocities else None
    frame = table_of(tracks[0], velocity)
    whole = sample_of(frame)
    release = np.random.default_rng(5).permutation(600)
    frame["time"] += 3.0 * release[frame["tracer"]]
    sample = sample_of(frame)
    np.testing.assert_allclose(sample.times, FRAME_TIMES)
    np.testing.assert_allclose(sample.sums, whole.sums)
    assert any("own clock" in text for text in sample.warnings)


def test_of_many_frames_close_ones_are_kept_together() -> None:
    times = np.arange(901.0)
    place, _ = simulated_tracks(BoltzmannGrad(0.04), 0.7, times, 50, seed=1)
    sample = sample_of(table_of(place, times=times))
    pairs = pairs_of(sample)
    assert sample.times.size <= 400
    assert sample.times[-1] == 900.0
    durations = sample.times[pairs.later] - sample.times[pairs.earlier]
    assert np.count_nonzero(durations == 1.0) >= 6
    used = place[sample.times.astype(int)]
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, used))


def test_displacements_without_a_first_frame_begin_at_time_0(tracks: Tracks) -> None:
    displacement = tracks[0] - tracks[0][0]
    frame = table_of(displacement)
    sample = sample_of(frame[frame["time"] > 0], positions="displacement")
    np.testing.assert_allclose(sample.times, FRAME_TIMES)
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, displacement))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda frame: frame.drop(columns="tracer"), "no column tracer"),
        (lambda frame: frame[frame["time"] == 0], "one frame"),
    ],
    ids=["no labels", "one frame"],
)
def test_what_cannot_be_used_is_refused(tracks: Tracks, change: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        sample_of(change(table_of(tracks[0])))


# -- velocities that are no measurement ------------------------------------------------------------


def differences(frame: Any, kind: str, axis: str) -> Any:
    of_tracer = frame.groupby("tracer")[axis]
    before = of_tracer.shift(1)
    after = of_tracer.shift(-1)
    if kind == "forward":
        return after - frame[axis]
    if kind == "backward":
        return frame[axis] - before
    return (after - before) / 2.0


@pytest.mark.parametrize("decimals", [2, 15])
@pytest.mark.parametrize("kind", ["forward", "backward", "central"])
def test_velocities_that_are_differences_of_positions_are_not_used(
    tracks: Tracks, kind: str, decimals: int
) -> None:
    frame = table_of(tracks[0])
    for axis in ("x", "y"):
        frame[f"v{axis}"] = differences(frame, kind, axis)
    sample = sample_of(frame.round(decimals))
    assert not sample.has_velocities
    assert sample.times.size == 61
    assert any(f"{kind} differences" in text for text in sample.warnings)


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_measured_velocities_at_close_frames_are_used(tracks: Tracks, noise: float) -> None:
    error = np.random.default_rng(5).normal(0.0, noise, tracks[0].shape)
    sample = sample_of(table_of(tracks[0] + error, tracks[1]))
    assert sample.has_velocities


def test_velocities_at_one_time_alone_are_not_used(tracks: Tracks) -> None:
    velocity = tracks[1].copy()
    velocity[1:] = np.nan
    sample = sample_of(table_of(tracks[0], velocity))
    assert not sample.has_velocities
    assert sample.times.size == 61
    assert any("1 of 61 times" in text for text in sample.warnings)


@pytest.mark.parametrize("initial", ["rest", "gaussian"])
@pytest.mark.parametrize("times", [[0.0, 5.0, 30.0], np.arange(0.0, 30.0)], ids=["few", "many"])
def test_velocities_in_a_field_are_measured(initial: str, times: Any) -> None:
    """On a parabola the central difference of even frames is the velocity."""
    run = simulate(
        BoltzmannGrad(0.04),
        0.7,
        initial=initial,
        field=0.1,
        times=times,
        media=20,
        tracers=50,
        seed=2,
        workers=1,
        observables=("positions", "velocities"),
    )
    arrays = {"times": run.times, "positions": run.positions, "velocities": run.velocities}
    assert read_sample([arrays], check_motion=False).has_velocities


def test_units_in_the_names_of_columns_are_kept(tracks: Tracks) -> None:
    frame = table_of(tracks[0]).rename(columns={"time": "t [s]", "x": "x (mm)", "y": "y (mm)"})
    assert sample_of(frame).unit_names == {"length": "mm", "time": "s"}
    assert sample_of(table_of(tracks[0])).unit_names == {}


def test_frames_with_few_tracers_are_in_no_pair(tracks: Tracks) -> None:
    """Time 0 is the first frame all the same."""
    place = tracks[0].copy()
    place[:3, 1:] = np.nan
    sample = sample_of(table_of(place).dropna())
    assert sample.times[0] == 0.0
    assert pairs_of(sample).earlier.min() == 3
    np.testing.assert_allclose(mean_squares(sample), true_mean_squares(sample, place))


def test_of_short_tracks_close_frames_are_paired(tracks: Tracks) -> None:
    place = np.full_like(tracks[0], np.nan)
    first = np.random.default_rng(5).integers(0, 57, 600)
    for tracer in range(600):
        frames = slice(first[tracer], first[tracer] + 4)
        place[frames, tracer] = tracks[0][frames, tracer]
    pairs = pairs_of(sample_of(table_of(place).dropna()))
    assert pairs.earlier.size >= 5
    assert np.max(pairs.later - pairs.earlier) <= 3
    assert np.all(pairs.sums[..., N].sum(axis=0) >= 2)


def test_files_of_one_track_each(tmp_path: Path, tracks: Tracks) -> None:
    frame = table_of(tracks[0][::6, :40], times=FRAME_TIMES[::6])
    whole = sample_of(frame)
    files = []
    for tracer, rows in frame.groupby("tracer"):
        files.append(tmp_path / f"{tracer:02}.csv")
        rows.drop(columns="tracer").to_csv(files[-1], index=False)
    np.testing.assert_allclose(mean_squares(read_sample(files)), mean_squares(whole))


def test_gaps_are_kept_by_tracer(tracks: Tracks) -> None:
    """Means with gaps are less correlated: who judges them needs to know when tracers are there."""
    place = tracks[0].copy()
    is_missing = np.random.default_rng(5).random(place.shape[:2]) < 0.1
    place[is_missing] = np.nan
    sample = sample_of(table_of(place).dropna())
    np.testing.assert_array_equal(sample.presence, ~is_missing.T)
    assert sample_of(table_of(tracks[0])).presence is None

"""A film of tracers: its frames, its clock, and its file."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot
from PIL import Image

from particles import BoltzmannGrad, Ensemble, HardDisks, simulate
from particles.animation import frame_times, moment_of

FRAMES = 4


@pytest.fixture(scope="module")
def run() -> Ensemble:
    return simulate(HardDisks(0.04, count=400), 0.7, times=[300.0], media=2, tracers=3)


@pytest.fixture(autouse=True)
def closed_figures() -> None:
    yield
    pyplot.close("all")


@pytest.mark.parametrize("clock", ["log time", "collisions"])
def test_a_film_is_saved_as_a_gif_with_all_frames(
    run: Ensemble, tmp_path: Path, clock: str
) -> None:
    path = tmp_path / "film.gif"
    run.animate(path, tracers=2, frames=FRAMES, clock=clock)
    with Image.open(path) as film:
        assert film.format == "GIF"
        assert film.n_frames == FRAMES


def test_frames_are_at_equal_ratios_of_the_time(run: Ensemble) -> None:
    times = frame_times(run.trajectories(tracers=3), 6, "log time")
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(300.0)
    ratios = times[2:] / times[1:-1]
    np.testing.assert_allclose(ratios, ratios[0])


def test_frames_are_at_equal_numbers_of_collisions(run: Ensemble) -> None:
    paths = run.trajectories(tracers=3)
    times = frame_times(paths, 6, "collisions")
    collisions = [moment_of(paths, time).collisions for time in times[:-1]]
    np.testing.assert_allclose(np.diff(collisions), np.diff(collisions).mean(), atol=0.7)
    assert times[-1] == pytest.approx(300.0)


def test_tracers_are_where_the_run_recorded_them() -> None:
    times = [10.0, 100.0, 300.0]
    medium = HardDisks(0.04, count=400)
    run = simulate(
        medium, 0.7, times=times, media=1, tracers=3, observables=["positions", "velocities"]
    )
    paths = run.trajectories(tracers=3)
    for k, time in enumerate(times[:-1]):
        moment = moment_of(paths, time)
        starts = np.array([path.places[0] for path in paths])
        np.testing.assert_allclose(moment.places - starts, run.positions[k], atol=1e-9)
        speeds = np.linalg.norm(run.velocities[k], axis=1)
        np.testing.assert_allclose(moment.speeds, speeds, rtol=1e-12)


def test_a_film_in_a_field_needs_no_collisions(tmp_path: Path) -> None:
    run = simulate(BoltzmannGrad(0.04), 0.7, times=[30.0], media=1, tracers=2, field=0.1)
    run.animate(tmp_path / "film.gif", tracers=2, frames=2)
    with pytest.raises(ValueError, match="clock"):
        run.animate(tmp_path / "film.gif", clock="collisions")


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"path": "film.avi"}, "path"),
        ({"path": "no such folder/film.gif"}, "path"),
        ({"frames": 1}, "frames"),
        ({"clock": "time"}, "clock"),
        ({"per_second": 0.0}, "per_second"),
        ({"tracers": 4}, "tracers"),
    ],
)
def test_what_makes_no_film_is_refused(
    run: Ensemble, arguments: dict[str, object], name: str
) -> None:
    with pytest.raises(ValueError, match=f"^{name}: got "):
        run.animate(**{"tracers": 2, "frames": 2, **arguments})


def test_mp4_without_ffmpeg_is_refused(run: Ensemble, monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib.animation import FFMpegWriter

    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ValueError, match="ffmpeg"):
        run.animate("film.mp4")

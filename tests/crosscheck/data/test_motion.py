"""Rows that no tracer can have where nothing drives it are seen, and clean data raise no alarm."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from camera_data import FRAME_TIMES, Tracks, sample_of, simulated_tracks, table_of

from kinetics.crosscheck.data.motion import (
    steps_beyond_speed,
    steps_beyond_straight_flight,
)
from kinetics.crosscheck.data.options import Units
from kinetics.crosscheck.data.tracks import Tracks as DataTracks
from kinetics.errors import InputError
from particles import BoltzmannGrad, HardDisks, Poisson

MEDIA = {
    "dilute": BoltzmannGrad(0.02),
    "hard disks": HardDisks(0.02, count=2000),
    "dense hard disks": HardDisks(0.1, count=2000),
    "overlapping": Poisson(0.04, count=2000),
}
CLEAN_TIMES = np.arange(0.0, 61.0, 5.0)


def alarms(frame: Any, **arguments: Any) -> list[str]:
    warnings = sample_of(frame, **arguments).warnings
    return [text for text in warnings if "impossible" in text]


@cache
def clean_tracks(medium: str, restitution: float) -> Tracks:
    """Displacements and velocities of 400 tracers, to a frame in each 5 d/U."""
    return simulated_tracks(MEDIA[medium], restitution, CLEAN_TIMES, 400, seed=3)


@pytest.mark.parametrize("with_velocities", [True, False])
@pytest.mark.parametrize("decimals", [15, 3])
@pytest.mark.parametrize("restitution", [0.4, 1.0])
@pytest.mark.parametrize("medium", list(MEDIA))
def test_clean_data_raise_no_alarm(
    medium: str, restitution: float, decimals: int, with_velocities: bool
) -> None:
    place, velocity = clean_tracks(medium, restitution)
    start = np.random.default_rng(3).uniform(0.0, 100.0, (400, 2))
    measured = velocity if with_velocities else None
    assert alarms(table_of(place + start, measured, CLEAN_TIMES).round(decimals)) == []


def exchanged(array: np.ndarray, first: int, second: int, index: int) -> np.ndarray:
    """Tracks of which two are exchanged from a frame on."""
    result = array.copy()
    result[index:, [first, second]] = array[index:, [second, first]]
    return result


def switches(seed: int = 5) -> list[tuple[int, int, int]]:
    """75 exchanges of two tracers, of 600 in 13 frames."""
    generator = np.random.default_rng(seed)
    pairs = [generator.choice(600, 2, replace=False) for _ in range(75)]
    return [(*pair.tolist(), int(generator.integers(1, 12))) for pair in pairs]


def test_exchanges_of_two_tracers_are_seen(tracks: Tracks) -> None:
    place = tracks[0][::5]
    velocity = tracks[1][::5]
    n_seen = 0
    for switch in switches():
        seen_velocity = exchanged(velocity, *switch)
        data = DataTracks(FRAME_TIMES[::5], exchanged(place, *switch), seen_velocity)
        steps = steps_beyond_speed(data, seen_velocity, Units())
        n_seen += bool(np.any(steps.is_impossible))
    assert n_seen >= 74


def test_exchanges_are_seen_in_positions_alone(tracks: Tracks) -> None:
    """45 of 75 at least; errors of 0.3 d hide some more."""
    place = tracks[0][::5]
    noise = np.random.default_rng(5).normal(0.0, 0.3, place.shape)
    for least, measured in ((45, place), (30, place + noise)):
        n_seen = 0
        for switch in switches():
            data = DataTracks(FRAME_TIMES[::5], exchanged(measured, *switch), None)
            n_seen += bool(np.any(steps_beyond_straight_flight(data, Units()).is_impossible))
        assert n_seen >= least


@pytest.mark.parametrize("with_velocities", [True, False])
def test_three_percent_of_exchanged_tracers_are_named(
    tracks: Tracks, with_velocities: bool
) -> None:
    place = tracks[0]
    velocity = tracks[1]
    for first, second, index in switches()[:9]:
        place = exchanged(place, first, second, 5 * index)
        velocity = exchanged(velocity, first, second, 5 * index)
    (text,) = alarms(table_of(place, velocity if with_velocities else None))
    assert "exchanged" in text
    named = [int(word) for word in text.replace(",", "").split() if word.isdigit()]
    assert {number for switch in switches()[:9] for number in switch[:2]} & set(named)


def test_a_tracer_is_compared_with_where_it_was_before_a_gap(tracks: Tracks) -> None:
    place = exchanged(tracks[0], 3, 4, 30)
    velocity = exchanged(tracks[1], 3, 4, 30)
    place[28:32, 3:5] = np.nan
    (text,) = alarms(table_of(place, velocity).dropna())
    assert "at time 32" in text


@pytest.mark.parametrize("with_velocities", [True, False])
@pytest.mark.parametrize("side", [40.0, 100.0])
def test_positions_that_jump_by_the_side_of_a_box_are_refused(
    tracks: Tracks, side: float, with_velocities: bool
) -> None:
    """Tracers start in a patch in its middle, so that they do not fill the box."""
    start = np.random.default_rng(3).uniform(-10.0, 10.0, (600, 2))
    place = tracks[0] - tracks[0][0] + start
    wrapped = place - side * np.floor(place / side + 0.5)
    with pytest.raises(InputError, match="wrap"):
        sample_of(table_of(wrapped, tracks[1] if with_velocities else None))


def test_a_wrong_unit_of_speed_is_said(tracks: Tracks) -> None:
    (text,) = alarms(table_of(*tracks), speed_unit=2.0, time_unit=1.0)
    assert "--speed-unit" in text


def test_errors_of_velocities_are_no_exchange(tracks: Tracks) -> None:
    noise = np.random.default_rng(5).normal(0.0, 0.05, tracks[1].shape)
    (text,) = alarms(table_of(tracks[0], tracks[1] + noise))
    assert "errors" in text
    assert "exchanged" not in text


def test_what_a_field_drives_may_get_faster(tracks: Tracks) -> None:
    place = exchanged(tracks[0], 3, 4, 30)
    velocity = exchanged(tracks[1], 3, 4, 30)
    assert alarms(table_of(place, velocity), check_motion=False) == []


def test_a_straight_flight_that_is_measured_with_errors_may_go_on_for_long() -> None:
    """The speed that two short steps show is known as well as the errors of the places allow."""
    times = np.array([0.0, 1.0, 2.0, 60.0])
    generator = np.random.default_rng(8)
    velocity = generator.normal(0.0, 0.6, (600, 2))
    place = velocity * times[:, None, None] + generator.normal(0.0, 0.03, (4, 600, 2))
    steps = steps_beyond_straight_flight(DataTracks(times, place, None), Units())
    assert not steps.is_further.any()


@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_what_is_impossible_does_not_hang_on_the_unit_of_length(
    tracks: Tracks, scale: float
) -> None:
    place = tracks[0]
    velocity = tracks[1] + np.random.default_rng(5).normal(0.0, 0.05, tracks[1].shape)
    for switch in switches()[:9]:
        place = exchanged(place, *switch)
        velocity = exchanged(velocity, *switch)
    for measured in (velocity, None):
        flags = []
        for unit in (1.0, scale):
            if measured is None:
                data = DataTracks(FRAME_TIMES, unit * place, None)
                steps = steps_beyond_straight_flight(data, Units())
            else:
                data = DataTracks(FRAME_TIMES, unit * place, unit * measured)
                steps = steps_beyond_speed(data, unit * measured, Units())
            flags.append((steps.is_faster, steps.is_further, steps.is_large))
        assert np.any(flags[0][1] & flags[0][2])
        np.testing.assert_array_equal(flags[0], flags[1])


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_measured_velocities_are_no_differences_in_any_unit(tracks: Tracks, unit: float) -> None:
    """Speeds of millimetres a second, in a table in metres."""
    place = unit * tracks[0]
    velocity = unit * tracks[1]
    sample = sample_of(table_of(place, velocity), diameter=unit, speed_unit=unit)
    assert sample.has_velocities

"""Positions in a periodic box without image flags, and times that jitter."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.comparison.data.columns import Rows, Table
from kinetics.crosscheck.comparison.data.read import read_sample
from kinetics.crosscheck.comparison.data.unwrapping import TooLong, Unwrapping
from kinetics.crosscheck.comparison.reduction import Reduction
from kinetics.errors import InputError

SIDE, TRACERS = 10.0, 60
TIMES = np.linspace(0.0, 20.0, 41)


@pytest.fixture(scope="module")
def paths() -> tuple[np.ndarray, np.ndarray]:
    """Positions that leave the box and velocities, (n_times, n, 3) each: |v| dt < 4."""
    rng = np.random.default_rng(2)
    velocity = rng.normal(size=(1, TRACERS, 3))
    start = rng.uniform(0, SIDE, (1, TRACERS, 3))
    return start + velocity * TIMES[:, None, None], np.repeat(velocity, TIMES.size, axis=0)


def write_dump(
    path: Path, paths: tuple[np.ndarray, np.ndarray], every: int = 1, flags: str = "pp pp pp"
) -> None:
    rng, lines = np.random.default_rng(1), []
    for k in range(0, TIMES.size, every):
        lines += ["ITEM: TIMESTEP", str(k), "ITEM: NUMBER OF ATOMS", str(TRACERS)]
        lines += [f"ITEM: BOX BOUNDS {flags}", *[f"0 {SIDE}"] * 3]
        lines += ["ITEM: ATOMS id x y z vx vy vz"]
        for n in rng.permutation(TRACERS):  # the order of atoms changes from frame to frame
            row = [*(paths[0][k, n] % SIDE).tolist(), *paths[1][k, n].tolist()]
            lines.append(" ".join([str(n), *map(repr, row)]))
    path.write_text("\n".join(lines) + "\n")


def test_short_steps_are_unwrapped(tmp_path: Path, paths: Any, moments: Any) -> None:
    path = tmp_path / "run.dump"
    write_dump(path, paths)
    sample = read_sample([path], timestep=0.5, dimension=3)
    r2 = np.sum((paths[0] - paths[0][0]) ** 2, axis=2)
    np.testing.assert_allclose(moments(sample)[..., 2].sum(axis=0), r2.sum(axis=1), rtol=1e-9)
    assert any("have been unwrapped" in warning for warning in sample.warnings)
    wide = (paths[0], paths[1] * 0.0 + 1e-3)  # so slow that no step is in doubt
    write_dump(path, (wide[0] * 0 + wide[0][0], wide[1]))
    still = read_sample([path], timestep=0.5, dimension=3)
    assert not any("have been unwrapped" in warning for warning in still.warnings)


@pytest.mark.parametrize(("every", "flags"), [(10, "pp pp pp"), (1, "ff ff ff")])
def test_long_steps_or_no_periodic_box_are_refused(
    tmp_path: Path, paths: Any, every: int, flags: str
) -> None:
    path = tmp_path / "run.dump"
    write_dump(path, paths, every, flags)
    with pytest.raises(InputError, match="positions look wrapped at the edges of a box"):
        read_sample([path], timestep=0.5, dimension=3)


def rows_at(time: float, x: float, vx: float, tracers: Any = (7,)) -> Rows:
    ones = np.ones(len(tracers))
    return Rows(
        ones * time, ones * x, ones * 0, ones * vx, ones * 0, np.array(tracers), box=(10.0, 10.0)
    )


def test_a_tracer_is_followed_through_both_edges() -> None:
    unwrapping = Unwrapping()
    for time, x, found in ((0.0, 9.0, 9.0), (1.0, 1.0, 11.0), (2.0, 3.0, 13.0), (3.0, 9.5, 9.5)):
        rows = unwrapping.of(rows_at(time, x, 4.9), 0)
        np.testing.assert_allclose(rows.x, found)
    assert unwrapping.crossed
    np.testing.assert_allclose(unwrapping.of(rows_at(3.0, 1.0, 4.9, (3,)), 0).x, 1.0)  # a new one
    np.testing.assert_allclose(unwrapping.of(rows_at(4.0, 0.5, 4.9), 0).x, 10.5)
    np.testing.assert_allclose(unwrapping.of(rows_at(5.0, 1.0, 4.9), 1).x, 1.0)  # another file
    with pytest.raises(TooLong):
        unwrapping.of(rows_at(7.0, 2.0, 4.9), 1)  # 4.9 times 2 is more than 5


def test_times_that_jitter_are_binned_when_asked(made_up: Any, moments: Any) -> None:
    data = made_up(tracers=400, times=(0.0, 1.0, 10.0))
    rng = np.random.default_rng(4)
    jitter = data | {"time": data["time"] * (1 + 0.004 * rng.uniform(-1, 1, data["time"].size))}
    plain = read_sample([Table(data)])
    with pytest.raises(InputError, match="more than 400 different times"):
        read_sample([Table(jitter)])
    sample = read_sample([Table(jitter)], bin_times=0.01)
    np.testing.assert_array_equal(sample.samples, [400, 400, 400])
    expected = jitter["time"].reshape(3, 400).mean(axis=1)
    np.testing.assert_allclose(sample.times, expected, rtol=1e-12)
    np.testing.assert_allclose(moments(sample), moments(plain), rtol=1e-9, atol=1e-12)
    assert "Times within 0.01 of each other are one time" in sample.warnings[0]
    assert "3 times" in sample.warnings[0]
    for wrong in (-0.1, 0.5, "a"):
        with pytest.raises(InputError, match="bin_times"):
            read_sample([Table(data)], bin_times=wrong)


def test_straight_flights_are_found_in_binned_times() -> None:
    rng = np.random.default_rng(5)
    time, speed = 2.0 * (1 + 0.01 * rng.uniform(-1, 1, 500)), rng.exponential(size=500)
    run, zeros = Reduction("row", 0.05), np.zeros(500)
    run.add(Rows(time, 1.1 * speed * time, zeros, speed, zeros))
    flights = run.sample(("x",)).flights
    assert flights is not None
    assert (flights.ratio, flights.share) == (pytest.approx(1.1), 1.0)

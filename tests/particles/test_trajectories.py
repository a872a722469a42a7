"""The paths that a picture shows: the run's own, to the bit, and among its own disks."""

from typing import Any

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

from particles import BoltzmannGrad, HardDisks, HardSpheres, Poisson, Positions, simulate
from particles.paths import disks_within

SQUARE = Positions(np.array([(x, y) for x in (1.5, 4.5) for y in (1.5, 4.5)]), 6.0)
LOW, HIGH = np.array([-25.0, -20.0]), np.array([30.0, 20.0])


def run(medium: Any, **arguments: Any) -> Any:
    kept = {"times": [300.0], "media": 2, "tracers": 8, "observables": ["finals"], **arguments}
    return simulate(medium, 0.7, **kept)


DISKS = [HardDisks(0.16, 400, diameter=0.5), Poisson(0.1, 4000), SQUARE]
OTHERS = [HardDisks(0.04, 400), BoltzmannGrad(0.04), HardSpheres(0.1, count=400)]


@pytest.mark.parametrize("medium", [*DISKS, *OTHERS], ids=lambda medium: type(medium).__name__)
def test_a_path_ends_where_and_when_the_run_says(medium: Any) -> None:
    ensemble = run(medium)
    paths = ensemble.trajectories(5, configuration=1)
    assert len(paths) == 5
    d = medium.dimension
    for path, end in zip(paths, ensemble.finals[8:], strict=False):
        assert path.places[-1].tolist() == end[[2, 3, 5][:d]].tolist()
        np.testing.assert_allclose(path.times[-1], np.exp(end[1]), rtol=1e-14)
        np.testing.assert_allclose(path.speeds[-1], np.exp(end[0]), rtol=1e-14)
        assert len(path.times) == end[4] + 2 == len(path.speeds) + 1
        flown = np.linalg.norm(np.diff(path.places, axis=0), axis=1)
        np.testing.assert_allclose(flown, path.speeds * np.diff(path.times), rtol=1e-8, atol=1e-12)
        assert np.all(np.diff(path.speeds) <= 0.0)


@pytest.mark.parametrize("medium", DISKS, ids=lambda medium: type(medium).__name__)
def test_tracers_turn_on_the_disks_that_are_drawn_and_enter_none(medium: Any) -> None:
    ensemble = run(medium)
    disks = disks_within(ensemble.plan, 0, LOW, HIGH)
    assert disks is not None
    expected = medium.number_density * np.prod(HIGH - LOW)
    assert abs(len(disks) - expected) < 4.0 * np.sqrt(expected)
    assert len(np.unique(disks.round(9), axis=0)) == len(disks)
    collisions = 0
    for path in ensemble.trajectories(8):
        inside = np.all((path.places > LOW + 1.0) & (path.places < HIGH - 1.0), axis=1)
        near = np.linalg.norm(path.places[inside, None] - disks, axis=2).min(axis=1)
        assert np.all(near > medium.diameter * (1.0 - 1e-12))
        turned = inside.copy()
        turned[[0, -1]] = False
        collisions += turned.sum()
        np.testing.assert_allclose(near[turned[inside]], medium.diameter, rtol=1e-12)
    assert collisions > 10


def test_a_path_in_a_field_is_a_parabola_until_its_first_collision() -> None:
    ensemble = run(BoltzmannGrad(0.001), initial="rest", field=0.5, times=[10.0])
    for path in ensemble.trajectories(3):
        np.testing.assert_allclose(path.places[1, 0], 0.25 * path.times[1] ** 2)
        flown = np.linalg.norm(np.diff(path.places, axis=0), axis=1)
        assert np.median(abs(flown / np.diff(path.times) / path.speeds - 1.0)) < 1e-3


@pytest.mark.parametrize("medium", [HardDisks(0.04, 400), HardSpheres(0.1, count=400)])
def test_the_picture_has_every_path_the_disks_and_units(medium: Any) -> None:
    axes = Figure().subplots()
    assert run(medium).plot_trajectories(3, ax=axes) is axes
    paths = [item for item in axes.collections if isinstance(item, LineCollection)]
    assert len(paths) == 3
    circles = [item for item in axes.collections if isinstance(item, EllipseCollection)]
    assert len(circles) == (2 if medium.dimension == 2 else 0)
    for label, unit in ((axes.get_xlabel(), "d"), (axes.get_ylabel(), "d")):
        assert f"[${unit}$]" in label
    assert "[$U$]" in axes.figure.axes[1].get_ylabel()
    assert "e = 0.7" in axes.get_title()
    axes.figure.canvas.draw()

"""Results are values: they cannot be changed, are compared by content, pickled, saved, shown."""

import copy
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import particles
from particles import Ensemble, Estimate, HardDisks, Positions, simulate

OLD = Path(__file__).with_name("saved_by_version_0_1.h5")


def run(seed: int = 1, **changes: Any) -> Ensemble:
    arguments: dict[str, Any] = dict(
        restitution=0.5, times=np.geomspace(1, 1e3, 30), media=3, tracers=8, seed=seed, workers=1,
        observables=["positions", "velocities", "finals", "speed_histogram"],
    )  # fmt: skip
    return simulate(HardDisks(0.04, 400), **(arguments | changes))


@pytest.fixture(scope="module")
def ensemble() -> Ensemble:
    return run()


def arrays_of(ensemble: Ensemble) -> list[np.ndarray]:
    histogram = ensemble.speed_histogram
    estimates = [getattr(ensemble, name) for name in particles.OBSERVABLES[:7]]
    statuses = ensemble.statuses
    return [
        *ensemble.arrays.values(), ensemble.times, ensemble.samples, ensemble.missing,
        ensemble.trapped, ensemble.positions, ensemble.velocities, ensemble.finals,
        histogram.edges, histogram.probability.value, histogram.below, histogram.density.error,
        statuses.trap_times, statuses.trap_places, statuses.trap_tracers,
        *(e.value for e in estimates), *(e.error for e in estimates),
    ]  # fmt: skip


@pytest.mark.parametrize("through", [copy.copy, copy.deepcopy, lambda e: e, "pickle"])
def test_no_array_can_be_written(ensemble: Ensemble, through: Any) -> None:
    if through == "pickle":
        ensemble = pickle.loads(pickle.dumps(ensemble))
    else:
        ensemble = through(ensemble)
    assert not any(array.flags.writeable for array in arrays_of(ensemble))
    with pytest.raises(TypeError):
        ensemble.arrays["moments"] = np.zeros(3)  # type: ignore[index]


def test_equal_runs_are_equal_and_others_are_not(ensemble: Ensemble, tmp_path: Path) -> None:
    again = run()
    assert again is not ensemble
    for one, other in (
        (ensemble, again), (ensemble.msd, again.msd), (ensemble.statuses, again.statuses),
        (ensemble.speed_histogram, again.speed_histogram), (ensemble.plan, again.plan),
    ):  # fmt: skip
        assert one == other
        assert hash(one) == hash(other)
        assert pickle.loads(pickle.dumps(one)) == one
    assert len({ensemble, again}) == 1
    assert ensemble != run(seed=2)
    assert ensemble != run(restitution=0.6)
    assert ensemble.msd != ensemble.a2
    assert ensemble.msd != 3
    ensemble.save(tmp_path / "run.h5")
    assert particles.load(tmp_path / "run.h5") == ensemble


def test_media_are_values_too() -> None:
    disks = np.array([[1.0, 1.0], [2.0, 8.0]])
    one = Positions(disks, 10.0)
    disks[0] = 3.0
    assert one == Positions([[1, 1], [2, 8]], 10.0)  # type: ignore[arg-type]
    assert hash(one) == hash(pickle.loads(pickle.dumps(one)))
    assert one != Positions(disks, 10.0)
    assert HardDisks(0.1) == HardDisks(0.1)
    assert HardDisks(0.1) != particles.Poisson(0.1)
    assert "\n" not in repr(Positions(np.random.default_rng(1).uniform(0, 3, (9000, 2)), 90.0))


def test_names_are_shown(ensemble: Ensemble) -> None:
    assert {*particles.__all__, "__version__", "load", "simulate"} <= {*dir(particles)}
    assert all(hasattr(particles, name) for name in dir(particles))
    assert {"msd", "a2", "positions", "speed_histogram", "save"} <= {*dir(ensemble)}
    assert "displacement_histogram" not in dir(ensemble)
    assert all(hasattr(ensemble, name) for name in (*dir(ensemble), *ensemble.outputs))
    assert isinstance(particles.__version__, str)


def test_repr_is_short_and_says_what_was_run(ensemble: Ensemble) -> None:
    for value in (ensemble, ensemble.msd, ensemble.mean_free_path, ensemble.statuses):
        assert len(repr(value).splitlines()) <= 10
    assert "HardDisks(number_density=0.04" in repr(ensemble)
    assert "30 output times from 1 to 1000 d/U" in repr(ensemble)
    assert repr(Estimate(np.array([1.5]), np.array([0.25]))) == "Estimate(1.5 +- 0.25)"
    page = ensemble._repr_html_()
    assert "<table>" in page
    assert "thermal_speed" in page
    assert "no output times" in run(times=None, max_collisions=5)._repr_html_()


def test_a_status_says_what_to_change() -> None:
    note = run(max_collisions=12).statuses.note
    assert "raise max_collisions or end `times` earlier" in note
    lattice = np.array([[0.0, 0.0], [0.0, 5.0], [5.0, 0.0], [5.0, 5.0]])
    flight = simulate(
        Positions(lattice, 10.0, start=(2.5, 2.5)), 0.5, np.array([[1.0, 0.0]]),
        times=[1.0, 1e9], media=1, tracers=1,
    )  # fmt: skip
    assert "straight corridors" in flight.statuses.note
    assert run().statuses.note == ""


def test_a_file_of_the_first_version_is_read() -> None:
    # Written by the first version of the format, before results were values; kept as it was.
    loaded = particles.load(OLD)
    fresh = simulate(
        HardDisks(0.04, 300), 0.7, times=[0.0, 10.0], media=2, tracers=4, seed=5, workers=1,
        observables=["speed_histogram", "finals"],
    )  # fmt: skip
    assert loaded.plan == fresh.plan
    assert loaded.arrays.keys() == fresh.arrays.keys()
    for name, array in fresh.arrays.items():
        # Equal to the bit on one machine; on another, log and cos may round in another way.
        np.testing.assert_allclose(loaded.arrays[name], array, rtol=1e-12, atol=1e-12)


def test_importing_particles_loads_neither_numpy_nor_numba() -> None:
    code = "import sys, particles; print({'numpy', 'numba'} & {*sys.modules})"
    command = [sys.executable, "-c", code]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "set()\n"

"""Files of version 0.2, which knew smooth disks in the plane alone, and of laws it did not know."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from particles import (
    OBSERVABLES,
    BoltzmannGrad,
    Ensemble,
    HardSpheres,
    Medium,
    Poisson,
    PoissonSpheres,
    simulate,
)

# Made by version 0.2, stopped after the first of two configurations:
OLD = Path(__file__).with_name("half_a_run_of_0_2.h5")
MEDIUM = Poisson(0.1, 100)
ARGUMENTS = dict(restitution=0.5, times=[1.0, 9.0], media=2, tracers=3, observables=["finals"])


def version_of(path: Path) -> int:
    with h5py.File(path) as file:
        return int(file.attrs["version"])


def test_a_run_that_version_0_2_began_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    shutil.copy(OLD, path)
    resumed = simulate(MEDIUM, **ARGUMENTS, output=path, resume=True)
    assert resumed == simulate(MEDIUM, **ARGUMENTS) == Ensemble.load(path)
    assert resumed.tangential_restitution == 1.0
    # Version 0.2 can read it in its turn: nothing that it does not know is in it.
    assert version_of(OLD) == version_of(path) == 1


def test_a_run_of_another_law_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    shutil.copy(OLD, path)
    with pytest.raises(
        ValueError, match=r"another run, with tangential_restitution = 1.0, not 0.8"
    ):
        simulate(MEDIUM, **ARGUMENTS, output=path, resume=True, tangential_restitution=0.8)
    simulate(MEDIUM, **ARGUMENTS, tangential_restitution=0.8).save(path)
    with pytest.raises(ValueError, match=r"another run, with tangential_restitution = 0.8, not 1"):
        simulate(MEDIUM, **ARGUMENTS, output=path, resume=True)


SPHERES = BoltzmannGrad(0.1, diameter=2.0, dimension=3)


@pytest.mark.parametrize("medium", [MEDIUM, BoltzmannGrad(0.1, diameter=2.0), SPHERES])
def test_tangential_restitution_is_saved_and_printed(
    medium: Poisson | BoltzmannGrad, tmp_path: Path
) -> None:
    path = tmp_path / "run.h5"
    run = simulate(medium, **ARGUMENTS, tangential_restitution=0.8)
    run.save(path)
    again = Ensemble.load(path)
    assert again == run
    assert again.tangential_restitution == 0.8
    assert "restitution 0.5, tangential restitution 0.8, 3 tracers" in repr(again)
    assert version_of(path) == 2
    smooth = simulate(medium, **ARGUMENTS)
    assert "tangential" not in repr(smooth)
    assert not np.array_equal(run.finals, smooth.finals)


@pytest.mark.parametrize(
    ("spheres", "initial", "version"),
    [
        (SPHERES, "gaussian", 2),
        (SPHERES, np.ones((3, 3)), 2),
        (HardSpheres(0.05, 2.0, count=50, equilibrate=1), "gaussian", 3),
        (PoissonSpheres(0.1, 2.0, count=None), np.ones((3, 3)), 3),
    ],
)
def test_three_dimensions_are_saved_and_gone_on_with(
    spheres: Medium, initial: str | np.ndarray, version: int, tmp_path: Path
) -> None:
    path = tmp_path / "run.h5"
    arguments = ARGUMENTS | dict(initial=initial, observables=OBSERVABLES, media=6)

    class Stopped(Exception):
        pass

    def stop(done: int, total: int) -> None:
        if done == 2:
            raise Stopped

    with pytest.raises(Stopped):
        simulate(spheres, **arguments, output=path, progress=stop)
    in_plane = arguments | dict(medium=BoltzmannGrad(0.1, diameter=2.0), initial="gaussian")
    with pytest.raises(ValueError, match="holds another run, with medium = "):
        simulate(**in_plane, output=path, resume=True)
    resumed = simulate(spheres, **arguments, output=path, resume=True)
    assert resumed == simulate(spheres, **arguments) == Ensemble.load(path)
    assert resumed.medium.dimension == 3
    assert version_of(path) == version


def test_traps_among_spheres_are_saved(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    run = simulate(PoissonSpheres(0.5, count=500), 0.1, media=3, tracers=30, max_collisions=300)
    statuses = run.statuses
    assert statuses.trapped > 10
    assert statuses.trap_places.shape == (statuses.trapped, 3)
    assert np.all(np.ptp(statuses.trap_places, axis=0) > 1.0)
    run.save(path)
    assert Ensemble.load(path) == run

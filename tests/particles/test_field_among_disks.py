"""A field among disks: energy, nothing inside, the weak field, traps, files and threads."""

import numpy as np
import pytest
from scattered import Around
from scipy.spatial import cKDTree

from particles import HardDisks, Poisson, Positions, simulate

STRESS = [
    (HardDisks(0.04, 4000), 0.9, 0.08), (HardDisks(0.5, 4000), 0.7, 1.0),
    (Poisson(0.3, 4000), 0.9, -0.5), (Poisson(0.1, 4000), 0.0, 0.2),
    (Poisson(0.2, 4000), 0.98, 5.0), (HardDisks(0.3, 4000), 1.0, 0.3),
]  # fmt: skip


@pytest.mark.parametrize(("medium", "e", "g"), STRESS)
def test_no_tracer_is_inside_a_disk_and_none_gains_energy(
    medium: HardDisks | Poisson, e: float, g: float
) -> None:
    run = simulate(
        medium, e, times=np.linspace(0.05, 60.0, 200), media=1, tracers=100, seed=11, field=g,
        observables=["positions", "velocities"],
    )  # fmt: skip
    # Rounding of coordinates as large as these.
    rounding = 1e-15 * (10 + abs(run.positions).max())
    distance, _ = Around(medium, 11).nearest(run.positions.reshape(-1, 2))
    assert distance.min() - 1 > -rounding
    energy = (run.velocities**2).sum(axis=2) / 2 - g * run.positions[:, :, 0]
    gain = np.diff(energy, axis=0)
    assert gain.max() < 1e-9
    if e == 1.0:
        assert abs(gain).max() < 1e-9


@pytest.mark.parametrize("medium", [HardDisks(0.1, 400), Poisson(0.2, 400)])
def test_a_weak_field_gives_the_run_without_field(medium: HardDisks | Poisson) -> None:
    arguments = dict(
        restitution=0.8, times=[1.0, 4.0, 9.0], media=2, tracers=50,
        observables=["positions", "velocities", "free_path_histogram"],
    )  # fmt: skip
    without, weak = (simulate(medium, **arguments, field=g) for g in (0.0, 1e-13))
    assert without.collisions.value[-1] > 1.5
    assert np.array_equal(without.moments[:, :, 5], weak.moments[:, :, 5])
    np.testing.assert_allclose(weak.positions, without.positions, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(weak.velocities, without.velocities, rtol=1e-7, atol=1e-7)
    assert weak.mean_free_path.value == pytest.approx(without.mean_free_path.value, rel=1e-9)
    counts = "histograms/free_path_histogram/sums"
    assert np.array_equal(without.arrays[counts], weak.arrays[counts])


def corners_of(positions: np.ndarray, box: float, field: float) -> np.ndarray:
    """Return the places (n, 2) at rest between two disks, outside all others."""
    tree = cKDTree(positions, boxsize=box)
    pairs = tree.query_pairs(2.0, output_type="ndarray")
    one = positions[pairs[:, 0]]
    apart = (positions[pairs[:, 1]] - one + box / 2) % box - box / 2
    length = np.hypot(*apart.T)
    across = np.stack((-apart[:, 1], apart[:, 0]), axis=1) * np.sqrt(1 / length**2 - 0.25)[:, None]
    found = []
    for sign in (1, -1):
        a = apart / 2 + sign * across
        b = a - apart
        turn = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        held = (-field * b[:, 1] * turn > 0) & (field * a[:, 1] * turn > 0)
        found.append((one + a)[held] % box)
    every = np.concatenate(found)
    return every[tree.query(every)[0] > 1 - 1e-9]


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_tracers_are_trapped_in_corners_that_hold_them_and_nowhere_else(restitution: float) -> None:
    n, box = 0.3, 60.0
    rng = np.random.default_rng(3)
    positions = rng.uniform(0, box, (int(n * box * box), 2))
    positions = positions[np.hypot(*(positions - box / 2).T) > 1]
    run = simulate(
        Positions(positions, box), restitution, times=np.array([1.0, 5.0, 15.0, 2000.0]), media=4,
        tracers=100, field=1.0,
    )  # fmt: skip
    assert run.statuses.trapped == 400
    tree = cKDTree(corners_of(positions, box, 1.0), boxsize=box)
    apart, which = tree.query((run.statuses.trap_places + box / 2) % box)
    assert apart.max() < 1e-8
    assert len(set(which)) > 3
    fraction = run.trapped_fraction
    assert np.all(np.diff(fraction.value) >= 0)
    assert 0.0 < fraction.value[2] < fraction.value[3] == 1.0
    assert fraction.error[2] > 0
    np.testing.assert_allclose(
        run.drift_of_moving.value[:3] * (1 - fraction.value[:3]), run.drift.value[:3], rtol=1e-12
    )


@pytest.mark.parametrize("field", [1e-98, 1e-12, 1e12, 1e98])
def test_any_size_of_the_field_and_of_the_start(field: float) -> None:
    scale = np.sqrt(field)
    starts = ["gaussian", "rest", *(s * scale * np.ones((20, 2)) for s in (1e-6, 1e6))]
    for start in starts:
        run = simulate(
            HardDisks(0.04, 400), 0.6, start, media=1, tracers=20, field=field, max_collisions=100
        )
        assert run.statuses.collision_cap + run.statuses.trapped == 20
        assert np.isfinite(run.mean_free_path.value)

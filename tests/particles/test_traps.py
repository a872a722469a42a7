"""The trap rule: who is caught, where, when, and who is not."""

import numpy as np
import pytest
import reference_simulator as reference
from scattered import Around

from particles import Poisson, Positions, simulate


def corner(angle: float) -> np.ndarray:
    """Return two disks whose circles of radius 1 leave a corner of this angle at (0, 0)."""
    half, depth = np.cos(angle / 2), np.sin(angle / 2)
    return np.array([[half, -depth], [-half, -depth]])


def launch(
    angle: float, restitution: float, distance: float, n: int, tangential: float = 1.0,
    wide: float = 0.9,
) -> tuple:  # fmt: skip
    """Send n tracers from `distance` above the corner down into it."""
    rng = np.random.default_rng(4)
    directions = -np.pi / 2 + wide * rng.uniform(-1, 1, n) * angle / 2
    velocities = np.stack([np.cos(directions), np.sin(directions)], axis=1)
    disks = corner(angle) - [0.0, distance]
    medium = Positions(disks, 30.0, start=(0.0, 0.0))
    ensemble = simulate(
        medium, restitution, velocities, times=[10 * distance, 5.0], media=1, tracers=n,
        observables=["positions", "velocities"], tangential_restitution=tangential,
    )  # fmt: skip
    return ensemble, disks, velocities


@pytest.mark.parametrize("tangential", [1.0, 0.6])
@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.5, 0.9])
def test_a_corner_catches_below_the_critical_angle_and_not_above(
    ratio: float, tangential: float
) -> None:
    # A straight wedge collapses if sin(angle) <= (1 - r)/(1 + r), r = e/et. At 1e-4 d from the
    # corner the circles are straight to 1e-4, so 3 % to either side of the critical angle is
    # decided.
    critical = np.arcsin((1 - ratio) / (1 + ratio))
    below, *_ = launch(0.97 * critical, ratio * tangential, 1e-4, 200, tangential)
    assert below.statuses.trapped > 20
    if ratio > 0:  # at e = 0 every corner below a right angle catches
        above, *_ = launch(1.03 * critical, ratio * tangential, 1e-4, 200, tangential)
        assert above.statuses.trapped == 0
        assert above.statuses.finished == 200


def test_who_is_trapped_where_and_when_is_what_the_reference_says() -> None:
    law, distance, n = (0.3, 1.0), 1e-3, 60
    ensemble, disks, velocities = launch(0.4, law[0], distance, n, wide=7.0)
    statuses, place = ensemble.statuses, np.array([0.0, -distance])
    trapped = statuses.trap_tracers[:, 1]
    for k, velocity in enumerate(velocities):
        # 60 collisions in 120 digits: the sum of a geometric series, far beyond its last digit.
        path = reference.follow(disks, None, velocity, law, 60, 120)
        assert (k in trapped) == (len(path) == 60)
        if k in trapped:
            # Short of the end by some 1e-9 d at a speed that has fallen a thousandfold and more.
            time = statuses.trap_times[trapped == k]
            assert time == pytest.approx(float(path[-1][0]), rel=1e-5)
            np.testing.assert_allclose(np.array(path[-1][1:3], float), place, atol=1e-12)
    assert 0.1 * n < statuses.trapped < 0.9 * n
    assert not statuses.trap_tracers[:, 0].any()
    # In the estimates they stay, at rest.
    for there in (statuses.trap_places, ensemble.positions[1, trapped]):
        np.testing.assert_allclose(there - place, 0.0, atol=1e-8)
    assert not ensemble.velocities[1, trapped].any()
    assert ensemble.trapped[1] == statuses.trapped == ensemble.samples[1] - statuses.finished
    assert ensemble.samples[1] == n


def test_only_corners_that_can_catch_have_caught() -> None:
    # Every trap of a large run: the disks it touches must leave an angle that collapses. This is
    # the test that the rule takes nobody who would have got away.
    medium, restitution, seed = Poisson(0.1, 4000), 0.5, 6
    ensemble = simulate(medium, restitution, media=1, tracers=20_000, max_collisions=200, seed=seed)
    statuses = ensemble.statuses
    assert statuses.trapped > 500
    around = Around(medium, seed)
    distance, touched = around.nearest(statuses.trap_places, 2)
    assert np.all(distance < 1 + 1e-8)
    one, other = (around.offset(statuses.trap_places, touched[:, k]) for k in (0, 1))
    apart = np.hypot(*(one - other).T)
    angle = 2 * np.arccos(apart / 2)
    # The corner is sharp, or blunt from outside: sin decides only below a right angle.
    assert np.all(angle < np.pi / 2)
    assert np.all(np.sin(angle) <= (1 - restitution) / (1 + restitution) * (1 + 1e-6))


def test_how_often_corners_catch() -> None:
    # Measured before, by another program, for Poisson scatterers at rho0 d^2 = 0.02: none in
    # 1.6e7 collisions at e = 0.9, 6e-5 a collision at 0.5, 9e-4 at 0.2 (one digit, so half a unit
    # of it and 4 sigma of the counts here, some 60 and 1200).
    for restitution, low, high in ((0.9, 0, 1e-6), (0.5, 2.4e-5, 9.6e-5), (0.2, 7.4e-4, 1.07e-3)):
        ensemble = simulate(
            Poisson(0.02, 4000), restitution, media=100, tracers=12, max_collisions=1000, seed=9
        )
        rate = ensemble.statuses.trapped / ensemble.collision_total
        assert low <= rate <= high, restitution

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
    angle: float, restitution: float, distance: float, n: int, tangential: float = 1.0
) -> tuple:
    """Send n tracers from `distance` above the corner down into it."""
    rng = np.random.default_rng(4)
    directions = -np.pi / 2 + rng.uniform(-0.9, 0.9, n) * angle / 2
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


def test_a_trapped_tracer_stays_where_and_ends_when_the_reference_says() -> None:
    restitution, distance = 0.3, 1e-3
    ensemble, disks, velocities = launch(0.4, restitution, distance, 20)
    statuses = ensemble.statuses
    assert statuses.trapped >= 10
    np.testing.assert_allclose(
        statuses.trap_places, [[0.0, -distance]] * statuses.trapped, atol=1e-8
    )
    assert np.array_equal(statuses.trap_tracers[:, 0], [0] * statuses.trapped)
    for k in range(4):
        tracer = statuses.trap_tracers[k, 1]
        # 60 collisions in 120 digits: the sum of a geometric series, far beyond its last digit.
        end = reference.follow(disks, None, velocities[tracer], (restitution, 1.0), 60, 120)[-1]
        # Short of the end by some 1e-9 d at a speed that has fallen a thousandfold and more.
        assert statuses.trap_times[k] == pytest.approx(float(end[0]), rel=1e-5)
        assert abs(float(end[2]) + distance) < 1e-12
    # In the estimates it stays, at rest.
    for tracer in statuses.trap_tracers[:, 1]:
        np.testing.assert_allclose(ensemble.positions[1, tracer], [0.0, -distance], atol=1e-8)
        assert np.array_equal(ensemble.velocities[1, tracer], [0.0, 0.0])
    assert ensemble.trapped[1] == statuses.trapped
    assert ensemble.samples[1] == 20
    assert statuses.finished + statuses.trapped == 20


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

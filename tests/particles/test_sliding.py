"""Sliding along a disk, leaving it, corners, traps: closed forms and an independent reference."""

import numpy as np
import pytest
import reference_in_field as reference
from scipy.integrate import quad

from particles import Ensemble, Positions, simulate


def fall_on(
    disks: np.ndarray, restitution: float, times: np.ndarray, velocity: tuple = (0.0, 0.0), **more
) -> Ensemble:
    """Follow one tracer from the origin among these disks alone, in a field of 1 along x."""
    medium = Positions(np.atleast_2d(disks), 200.0, start=(0.0, 0.0))
    arguments = dict(media=1, tracers=1, field=1.0, observables=["positions", "velocities"])
    return simulate(medium, restitution, np.array([velocity]), times, **(arguments | more))


def test_a_slide_takes_its_time_and_ends_at_two_thirds_of_its_height() -> None:
    # It falls by 0.5 on a disk, its normal velocity is lost, and it slides from theta_0 on.
    start, fall = 0.3, 0.5
    centre = np.array([np.cos(start) + fall, -np.sin(start)])
    along = np.sqrt(2 * fall) * np.sin(start)
    k = np.cos(start) + along**2 / 2
    end = np.arccos(2 * k / 3)
    duration = quad(lambda a: 1 / np.sqrt(2 * (k - np.cos(a))), start, end, epsabs=1e-13)[0]
    lands = np.sqrt(2 * fall)
    times = lands + duration * np.array([0.2, 0.5, 0.8, 1.0 - 1e-9, 1.0 + 1e-3, 1.2])
    run = fall_on(centre, 0.0, times)
    place, velocity = run.positions[:, 0] - centre, run.velocities[:, 0]
    theta = np.arctan2(place[:, 1], -place[:, 0])
    np.testing.assert_allclose(np.hypot(*place[:4].T), 1.0, rtol=1e-13)
    assert np.hypot(*place[4]) > 1 + 1e-10
    assert theta[3] == pytest.approx(end, abs=1e-8)
    for angle, elapsed in zip(theta[:3], times[:3] - lands, strict=True):
        passed = quad(lambda a: 1 / np.sqrt(2 * (k - np.cos(a))), start, angle, epsabs=1e-13)[0]
        assert passed == pytest.approx(elapsed, abs=1e-11)
    for angle, time in zip(theta[:3], times[:3], strict=True):  # the slide is part of the path
        travelled = fall_on(centre, 0.0, np.array([time])).arrays["path_sums"][0, 0]
        assert travelled == pytest.approx(fall + angle - start, abs=1e-11)
    # Without friction the energy stays, also after leaving.
    np.testing.assert_allclose((velocity**2).sum(axis=1) / 2 - place[:, 0], k, rtol=1e-12)
    assert run.statuses.finished == 1
    assert run.collision_total == 1


def test_many_bounces_end_in_a_slide() -> None:
    # e = 0.5: about twenty bounces until v_n^2/(2 a_n) < 1e-12, and no more than that.
    run = fall_on(np.array([1.5, -0.001]), 0.5, np.array([4.0, 9.0]))
    assert 15 < run.collision_total < 30
    assert run.statuses.finished == 1


def test_it_passes_over_the_top_if_it_is_fast_enough() -> None:
    # Thrown up at the side of a disk, 0.3 rad from the top, along the disk: k = 1 divides the two.
    theta = 0.3
    centre = np.array([np.cos(theta), np.sin(theta)])
    for k, side in ((1.05, 1.0), (0.99, -1.0)):
        speed = np.sqrt(2 * (k - np.cos(theta)))
        # A little towards the disk, so that it touches it at once and slides (e = 0).
        velocity = speed * np.array([-np.sin(theta), np.cos(theta)]) + 1e-6 * centre
        run = fall_on(centre * (1 + 1e-9), 0.0, np.array([0.01, 4.0]), tuple(velocity))
        assert np.sign(run.positions[1, 0, 1] - centre[1]) == side
        assert np.hypot(*(run.positions[0, 0] - centre)) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("field", [1.0, -1.0])
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7, 0.9])
def test_a_corner_that_opens_against_the_field_is_a_trap(restitution: float, field: float) -> None:
    # It starts lower than the tops of the disks, so it cannot get out.
    disks = np.array([[0.8, 0.8], [0.8, -0.7]]) * [field, 1.0]
    run = fall_on(disks, restitution, np.array([0.3, 500.0]), (0.0, 0.1), field=field)
    assert run.statuses.trapped == 1
    # The upper one of the points that are 1 away from both.
    corner = [0.8 - np.sqrt(1 - 0.75**2), 0.05]
    np.testing.assert_allclose(run.statuses.trap_places[0] * [field, 1.0], corner, atol=1e-9)
    np.testing.assert_array_equal(run.velocities[1, 0], 0.0)
    assert list(run.trapped) == [0, 1]
    assert list(run.trapped_fraction.value) == [0.0, 1.0]
    assert run.drift.value[1] == 0.0
    assert np.isnan(run.drift_of_moving.value[1])


# contact with the second disk, that disk: behind walls of the field's direction, and across it
NEXT = [
    ((-0.7, 0.7141428428542850), (0.9, 0.43588989435406733)),
    ((-0.85, 0.5267826876426369), (0.5, 0.8660254037844386)),
]


@pytest.mark.parametrize(("contact", "beyond"), NEXT)
@pytest.mark.parametrize("field", [1.0, -1.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_slide_over_cell_walls_ends_at_the_disk_behind_them(
    contact: tuple, beyond: tuple, field: float, side: float
) -> None:
    # The disks far away make the cells small, and the fall decides where on the disk their walls
    # are; some cells do not list the second disk, which is met where both are 1 away.
    far = np.stack(np.meshgrid(*2 * [np.arange(-20.0, 20.0, 1.25)]), axis=-1).reshape(-1, 2)
    far, way = far[np.hypot(*far.T) > 8], np.array([field, side])
    for fall in np.linspace(0.3, 1.8, 16):
        first = np.array([fall + 1.0, -0.05])
        disks = np.stack([first, first + contact + beyond]) * way
        medium = Positions(np.concatenate([far, disks]), 40.0, start=(0.0, 0.0))
        run = simulate(
            medium, 0.0, np.zeros((1, 2)), [*np.linspace(0.1, 8.0, 500), 99.0], media=1, tracers=1,
            field=field, observables=["positions"],
        )  # fmt: skip
        apart = np.linalg.norm(run.positions - disks, axis=2)
        assert apart.min() > 1 - 1e-12
        np.testing.assert_allclose(
            run.statuses.trap_places, [(first + contact) * way], rtol=0, atol=1e-9
        )


def test_a_corner_that_the_field_lets_it_out_of_is_left() -> None:
    # From the corner the way down along the lower disk is free: -g is not between the normals.
    disks = np.array([[0.9, -0.6], [1.9, 0.6]])
    for restitution in (0.0, 0.2, 0.6):
        run = fall_on(disks, restitution, np.array([3.0, 60.0]), (0.3, 0.2))
        assert run.statuses.finished == 1
        assert run.positions[-1, 0, 0] > 100.0


@pytest.mark.parametrize("restitution", [0.0, 0.1])
def test_out_of_a_corner_that_opens_along_the_field_it_falls(restitution: float) -> None:
    # Thrown up into the corner it comes to rest there, after infinitely many bounces, and falls.
    corner = -1.2 + np.sqrt(1 - 0.81)
    disks = np.array([[-1.2, 0.9], [-1.2, -0.9]])
    run = fall_on(disks, restitution, np.array([15.0]), (-2.0, 0.1))
    assert run.statuses.finished == 1
    # Nothing is left of the velocity that it was thrown with; at e > 0 the field turns it back
    # some 1e-6 before the corner.
    fallen = run.positions[0, 0, 0] - corner
    assert (run.velocities[0, 0] ** 2).sum() / 2 == pytest.approx(fallen, abs=1e-5)


def test_with_tangential_friction_it_rests_where_it_would_slide() -> None:
    run = fall_on(np.array([1.5, -0.2]), 0.0, np.array([5.0]), tangential_restitution=0.5)
    assert run.statuses.trapped == 1
    place = run.statuses.trap_places[0] - [1.5, -0.2]
    assert np.hypot(*place) == pytest.approx(1.0, rel=1e-14)
    assert place[1] == pytest.approx(0.2, abs=1e-14)


def test_a_tracer_balances_on_the_very_top_only() -> None:
    run = fall_on(np.array([1.5, 0.0]), 0.4, np.array([50.0]))
    assert run.statuses.trapped == 1
    run = fall_on(np.array([1.5, 1e-9]), 0.4, np.array([50.0]))
    assert run.statuses.finished == 1


MANY = [(0.5, 0.5, 1), (0.0, 0.5, 2), (0.2, -1.0, 3), (0.8, 2.0, 4), (1.0, 0.3, 5), (0.0, 1.0, 6)]


@pytest.mark.parametrize(
    ("restitution", "field", "seed", "tracers"),
    [
        *((*MANY[k], 2) for k in (0, 5)),
        *(pytest.param(*case, 12, marks=pytest.mark.slow) for case in MANY),
    ],
)
def test_the_paths_are_those_of_the_reference(
    restitution: float, field: float, seed: int, tracers: int
) -> None:
    rng = np.random.default_rng(seed)
    box = 12.0
    disks = rng.uniform(-box / 2, box / 2, (40, 2))
    disks = disks[np.hypot(*disks.T) > 1.02]
    times = np.linspace(0.2, 4 / np.sqrt(abs(field)) + 2, 16)
    given = rng.normal(size=(tracers, 2))
    run = simulate(
        Positions(disks, box, start=(0.0, 0.0)), restitution, given, times, media=1,
        tracers=tracers, field=field, observables=["positions"],
    )  # fmt: skip
    assert run.collisions.value[-1] > 2.0
    for tracer in range(tracers):
        places = reference.follow(disks, box, given[tracer], (restitution, field), times)
        found = run.positions[: len(places), tracer]
        assert len(places) > 2
        np.testing.assert_allclose(found, places, rtol=0, atol=1e-8)

"""One event: contact and the collision rule, against 50-digit arithmetic."""

import mpmath as mp
import numpy as np
import pytest

from particles.events import NEVER, contact, scatter, touch

RESTITUTIONS = [0.0, 1e-8, 0.2, 0.4, 0.7, 0.9, 1.0 - 1e-12, 1.0]
TANGENTIAL = [1.0, 0.8, 0.2, 1e-8, 0.0]
LAWS = [(e, et) for et in TANGENTIAL for e in RESTITUTIONS if e + et > 0]


def draws(n: int) -> list[tuple[float, float, float]]:
    rng = np.random.default_rng(20)
    angles = rng.uniform(0, 2 * np.pi, n)
    impacts = rng.uniform(-1, 1, n)
    impacts[:8] = [0.0, 1e-12, -1e-9, 1 - 1e-12, -1 + 1e-15, 0.5, -0.5, 1e-5]
    return [(np.cos(a), np.sin(a), b) for a, b in zip(angles, impacts, strict=True)]


@pytest.mark.parametrize(("restitution", "tangential"), LAWS)
def test_each_component_of_the_velocity_is_multiplied_by_its_factor(
    restitution: float, tangential: float
) -> None:
    # 4 ulp of the outgoing speed; the contact normal is taken in 50 digits from the direction.
    for ux, uy, impact in draws(500 if tangential == 1.0 else 100):
        if restitution == 0.0 and impact == 0.0:
            continue
        vx, vy, ratio = scatter(ux, uy, impact, restitution, tangential)
        with mp.workdps(50):
            norm = mp.sqrt(mp.mpf(ux) ** 2 + mp.mpf(uy) ** 2)
            x, y, b = mp.mpf(ux) / norm, mp.mpf(uy) / norm, mp.mpf(impact)
            depth = mp.sqrt(1 - b * b)
            nx, ny = -(depth * x + b * y), -(depth * y - b * x)
            before_n, before_t = x * nx + y * ny, -x * ny + y * nx
            after_n, after_t = ratio * (vx * nx + vy * ny), ratio * (-vx * ny + vy * nx)
            # Both are relative to the ratio, or a slow tracer would lose its digits.
            exact = mp.sqrt((mp.mpf(restitution) * depth) ** 2 + (mp.mpf(tangential) * b) ** 2)
            assert abs(after_t - tangential * before_t) <= 4 * 2.0**-52 * exact
            assert abs(after_n + restitution * before_n) <= 4 * 2.0**-52 * exact
            assert abs(ratio / exact - 1) <= 4 * 2.0**-52
            assert abs(mp.sqrt(mp.mpf(vx) ** 2 + mp.mpf(vy) ** 2) - 1) <= 4 * 2.0**-52


def test_a_head_on_collision_without_restitution_stops_the_tracer() -> None:
    assert scatter(0.6, 0.8, 0.0, 0.0, 1.0) == (0.6, 0.8, 0.0)
    assert scatter(0.6, 0.8, 0.0, 0.0, 0.5) == (0.6, 0.8, 0.0)


def test_elastic_collisions_keep_the_speed_to_the_last_bit() -> None:
    assert all(scatter(ux, uy, b, 1.0, 1.0)[2] == 1.0 for ux, uy, b in draws(500))


def test_contact_is_where_the_circle_is_met() -> None:
    rng = np.random.default_rng(21)
    met = 0
    for _ in range(1000):
        dx, dy = rng.uniform(-5, 5, 2)
        angle = rng.uniform(0, 2 * np.pi)
        ux, uy = np.cos(angle), np.sin(angle)
        if dx * dx + dy * dy < 1:
            continue
        path, impact = contact(dx, dy, ux, uy)
        # Distance of the ray from the centre, by the nearest of many points on it.
        s = np.linspace(0, 10, 20001)
        distance = np.hypot(s * ux - dx, s * uy - dy)
        if path == NEVER:
            assert distance.min() > 1 - 1e-6
            continue
        met += 1
        assert abs(s[np.argmax(distance < 1)] - path) < 2e-3 or distance.min() > 1 - 1e-6
        x, y = touch(dx, dy, ux, uy, impact)
        assert abs(np.hypot(x - dx, y - dy) - 1) < 2e-15  # rounding of coordinates of 5 d
        assert abs(np.hypot(x - path * ux, y - path * uy)) < 1e-13
    assert met > 100


def test_a_tracer_does_not_meet_again_the_scatterer_that_it_leaves() -> None:
    for restitution, tangential in LAWS:
        for ux, uy, impact in draws(300 if tangential == 1.0 else 60):
            if restitution == 0.0 and impact == 0.0:
                continue
            x, y = touch(0.3, -0.2, ux, uy, impact)
            vx, vy, _ = scatter(ux, uy, impact, restitution, tangential)
            assert contact(0.3 - x, -0.2 - y, vx, vy)[0] == NEVER

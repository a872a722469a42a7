"""One event: contact and the collision rule, against 50-digit arithmetic."""

import mpmath as mp
import numpy as np
import pytest

from particles.events import (
    NEVER,
    bounce_in_space,
    contact,
    contact_in_space,
    scatter,
    scatter_in_space,
    touch,
)

RESTITUTIONS = [0.0, 1e-8, 0.4, 0.9, 1.0]
TANGENTIAL = [1.0, 0.8, 1e-8, 0.0]
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


@pytest.mark.parametrize(("restitution", "tangential"), LAWS)
def test_each_component_is_multiplied_by_its_factor_in_space(
    restitution: float, tangential: float
) -> None:
    # The velocity after is (-e + (e + et) y^2) u - (e + et) q (a p + b r) for some fixed pair of
    # unit vectors p, r across u. So its component along u is known, and the parts across u of two
    # collisions with the same u have a known product. 8 ulp of the outgoing speeds, 50 digits.
    rng = np.random.default_rng(22)
    e, et = mp.mpf(restitution), mp.mpf(tangential)
    for sign in (1.0, -1.0):
        for k in range(20):
            u = rng.normal(size=3) if k else np.array([0.0, 0.0, 1.0])
            u = sign * u / np.linalg.norm(u)
            found = []
            for radius in (rng.uniform(), rng.choice([1e-7, 0.5, 1 - 1e-9])):
                angle = rng.uniform(0, 2 * np.pi)
                impact = radius * np.cos(angle), radius * np.sin(angle)
                new, ratio = scatter_in_space(tuple(u), impact, restitution, tangential)
                with mp.workdps(50):
                    y2 = mp.mpf(impact[0]) ** 2 + mp.mpf(impact[1]) ** 2
                    exact = mp.sqrt(e**2 * (1 - y2) + et**2 * y2)
                    velocity = [ratio * mp.mpf(v) for v in new]
                    along = mp.fdot(velocity, map(mp.mpf, u)) / mp.fdot(u, u)
                    across = [v - along * mp.mpf(n) for v, n in zip(velocity, u, strict=True)]
                    # 1 - y^2 is rounded to 1e-16 in all, which near y = 1 is not to 1e-16 of it.
                    assert abs(ratio / exact - 1) < 1e-15 / (1 - y2)
                    assert abs(along + e - (e + et) * y2) < 2e-15 * exact / (1 - y2)
                    assert abs(mp.fdot(new, new) - 1) < 1e-15
                found.append((impact, y2, exact, across))
            (a, y2, one, first), (b, z2, two, second) = found
            with mp.workdps(50):
                expected = (e + et) ** 2 * mp.sqrt((1 - y2) * (1 - z2)) * mp.fdot(a, b)
                error = abs(mp.fdot(first, second) - expected)
            assert error < 4e-15 * one * two / ((1 - y2) * (1 - z2))


def test_a_head_on_collision_without_restitution_stops_the_tracer() -> None:
    assert scatter(0.6, 0.8, 0.0, 0.0, 1.0) == (0.6, 0.8, 0.0)
    assert scatter(0.6, 0.8, 0.0, 0.0, 0.5) == (0.6, 0.8, 0.0)
    u = 0.6, 0.0, 0.8
    assert scatter_in_space(u, (0.0, 0.0), 0.0, 0.5) == (u, 0.0)


def test_elastic_collisions_keep_the_speed_to_the_last_bit() -> None:
    assert all(scatter(ux, uy, b, 1.0, 1.0)[2] == 1.0 for ux, uy, b in draws(500))
    u = 0.6, 0.0, 0.8
    assert all(scatter_in_space(u, (b / 2, b / 3), 1.0, 1.0)[1] == 1.0 for *_, b in draws(500))


def test_a_tracer_does_not_meet_again_the_scatterer_that_it_leaves() -> None:
    for restitution, tangential in LAWS:
        for ux, uy, impact in draws(300 if tangential == 1.0 else 60):
            if restitution == 0.0 and impact == 0.0:
                continue
            x, y = touch(0.3, -0.2, ux, uy, impact)
            vx, vy, _ = scatter(ux, uy, impact, restitution, tangential)
            assert contact(0.3 - x, -0.2 - y, vx, vy)[0] == NEVER


@pytest.mark.parametrize("law", [(0.7, 1.0), (0.0, 1.0), (1.0, 1.0), (0.3, 0.8), (0.5, 0.0)])
def test_contacts_in_space_against_50_digits(law: tuple[float, float]) -> None:
    # The line of flight meets the sphere by the quadratic equation, and v' = et v - (et + e)(v.s) s
    # with the normal s. The impact parameter y is exact to the rounding of the offset, some 1e-15;
    # what follows from sqrt(1 - y^2) and the new direction lose by it.
    rng = np.random.default_rng(5)
    for impact in (1e-9, 1e-3, 0.2, 0.5, 0.8, 0.99, 1 - 1e-6, 1 - 1e-10):
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        side = np.cross(u, rng.normal(size=3))
        offset = rng.uniform(1.1, 8.0) * u + impact * side / np.linalg.norm(side)
        with mp.workdps(50):
            d, v = mp.matrix(offset), mp.matrix(u)
            v /= mp.norm(v)
            along = mp.fdot(d, v)
            path = along - mp.sqrt(along**2 - mp.fdot(d, d) + 1)
            s = path * v - d
            after = law[1] * v - (law[0] + law[1]) * mp.fdot(v, s) * s
            size = mp.norm(after)
            exact = [np.array(list(x), float) for x in (s, after / size)]
        depth = -exact[0] @ u
        error = 1e-15 * np.linalg.norm(offset)
        assert abs(contact_in_space(*offset, *u) - float(path)) < 3 * error / depth
        normal, new, ratio = bounce_in_space(tuple(offset), tuple(u), *law)
        np.testing.assert_allclose(normal, exact[0], rtol=0, atol=2 * error / depth)
        assert abs(np.linalg.norm(normal) - 1) < error
        assert abs(ratio - float(size)) < 3 * error / depth
        np.testing.assert_allclose(new, exact[1], rtol=0, atol=3 * error / float(size) / depth)
        assert abs(np.linalg.norm(new) - 1) < 4e-16
        # It does not meet again the sphere that it leaves; at e = 0 it leaves along the sphere,
        # in a direction that is as good as the offset over the impact parameter.
        if law[0] > 0.0 or impact > 1e-3:
            assert contact_in_space(*(-np.array(normal)), *new) == NEVER

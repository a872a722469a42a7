"""The first contact of a parabola with a disk, against all roots of the quartic in 40 digits."""

import mpmath as mp
import numpy as np
import pytest

from particles.events import NEVER
from particles.kernel.disk_contact import APART, STRUCK, TANGENT, contact_in_field

ENDLESS = 1e9


def cases(n: int, seed: int) -> np.ndarray:
    """Return (x, y, vx, vy, field) of n cases, half of them tangent to 1e-15 up to 1e-2."""
    rng = np.random.default_rng(seed)
    found = np.empty((0, 5))
    while len(found) < n:
        m = 2 * n
        field = 10 ** rng.uniform(-3, 1, m) * rng.choice([-1, 1], m)
        angle, turn = rng.uniform(0, 2 * np.pi, (2, m))
        normal = np.stack((np.cos(angle), np.sin(angle)), axis=1)
        speed = 10 ** rng.uniform(-3, 1, m)[:, None]
        # Anywhere, in any direction.
        gap = rng.exponential(size=m) * 10 ** rng.uniform(-6, 0.7, m)
        place = normal * (1 + gap[:, None])
        velocity = speed * np.stack((np.cos(turn), np.sin(turn)), axis=1)
        # Back in time from where the velocity is along the disk, at nearly its radius.
        size = 1 + rng.choice([-1, 1], m) * 10 ** rng.uniform(-15, -2, m)
        before = 10 ** rng.uniform(-3, 1, m)
        along = speed * normal[:, ::-1] * [-1, 1] * rng.choice([-1, 1], m)[:, None]
        tangent = normal * size[:, None] - along * before[:, None]
        tangent[:, 0] += field * before**2 / 2
        along[:, 0] -= field * before
        half = np.arange(m) % 2 == 0
        place[half], velocity[half] = tangent[half], along[half]
        rows = np.column_stack((place, velocity, field))
        found = np.concatenate((found, rows[np.hypot(*place.T) > 1]))
    return found[:n]


def roots(x: float, y: float, vx: float, vy: float, field: float, after: str = "") -> list:
    """Return the positive real roots of |r|^2 = 1, ascending; after a contact, besides that."""
    x, y, vx, vy, g = map(mp.mpf, (x, y, vx, vy, field))
    terms = [g * g / 4, g * vx, vx * vx + vy * vy + g * x, 2 * (x * vx + y * vy), x * x + y * y - 1]
    terms = terms[: {"": 5, "struck": 4, "tangent": 3}[after]]
    found = mp.polyroots(terms, maxsteps=500, extraprec=400)
    return sorted(r.real for r in found if abs(r.imag) < mp.mpf(10) ** -18 and r.real > 0)


def place(row: np.ndarray, t: float) -> tuple[mp.mpf, mp.mpf]:
    """Return the distance from the disk's centre at t, and the size of what it is a sum of."""
    x, y, vx, vy, g = map(mp.mpf, row)
    distance = mp.hypot(x + (vx + g * t / 2) * t, y + vy * t)
    return distance, 1 + abs(x) + abs(y) + abs(vx * t) + abs(g) * t**2 / 2


def test_no_contact_is_missed_and_none_invented() -> None:
    """No root before the contact that is found, and the contact is one.

    Where a parabola comes as near to the disk, or goes as little into it, as rounding, either
    answer is right.
    """
    hits = 0
    for row in cases(60, 1):
        t = contact_in_field((row[0], row[1]), (row[2], row[3]), row[4], ENDLESS, APART)
        with mp.workdps(40):
            exact = roots(*row)
            if exact and (t == NEVER or exact[0] < mp.mpf(t) * (1 - mp.mpf(10) ** -9)):
                # missed: the deepest place before the time found
                distance, scale = place(row, min(sum(exact[:2]) / 2, mp.mpf(t)))
                assert 1 - distance < 3e-15 * scale
            if t < NEVER:
                hits += 1
                distance, scale = place(row, mp.mpf(t))
                assert abs(distance - 1) < 3e-15 * scale
    assert hits > 18


def test_the_second_contact_after_a_bounce_of_any_height() -> None:
    rng = np.random.default_rng(3)
    for _ in range(60):
        angle, g = rng.uniform(0, 2 * np.pi), 10 ** rng.uniform(-2, 1)
        n = np.array([np.cos(angle), np.sin(angle)])
        v = rng.normal(size=2) * 0.5
        v += n * (10 ** rng.uniform(-10, 0) - v @ n)
        t = contact_in_field((n[0], n[1]), (v[0], v[1]), g, ENDLESS, STRUCK)
        with mp.workdps(40):
            exact = roots(*n, *v, g, after="struck")
        if not exact:
            assert t == NEVER
            continue
        # n and v are rounded, so their product, with which the tracer leaves, is known to 1e-16.
        assert t == pytest.approx(float(exact[0]), rel=1e-14 + 1e-15 / (v @ n))


def test_a_flight_that_begins_along_the_disk() -> None:
    # With the field it leaves for good; against it the disk may be met later.
    for angle, speed, g in ((2.0, 1.5, 1.0), (2.0, -1.5, 1.0), (2.9, 1.01, 1.0), (-1.0, 2.0, -3.0)):
        n = np.array([np.cos(angle), np.sin(angle)])
        v = speed * np.array([-n[1], n[0]])
        assert v @ v + g * n[0] > 0
        t = contact_in_field((n[0], n[1]), (v[0], v[1]), g, ENDLESS, TANGENT)
        with mp.workdps(40):
            exact = roots(*n, *v, g, after="tangent")
        assert t == (pytest.approx(float(exact[0]), rel=1e-13) if exact else NEVER)


def test_inside_by_rounding_it_collides_at_once_if_it_moves_inwards() -> None:
    inside = 1 - 2e-16
    assert contact_in_field((-inside, 0.0), (1.0, 0.5), 0.3, ENDLESS, APART) == 0.0
    t = contact_in_field((-inside, 0.0), (-1.0, 0.0), 0.5, ENDLESS, APART)
    assert t == pytest.approx(4.0, rel=1e-14)
    assert contact_in_field((-inside, 0.0), (-1.0, 0.0), 0.5, 3.9, APART) == NEVER

"""The length of a parabola and the time that a length takes, against 50 digits."""

from math import cos, pi, sqrt

import mpmath as mp
import numpy as np

from particles.kernel.parabola import (
    ACROSS2,
    ALONG,
    DURATION,
    LENGTH,
    QUALITY,
    ROWS,
    SPEED2,
    length_of,
    time_of_length,
    times_of_lengths,
)

ANGLES = [0.0, 1.0, 2.0, 3.0, pi - 1e-3, pi - 1e-6, pi - 1e-9, pi]
# field * path / speed^2. At 1/2 a tracer that flies straight against the field stops at the end.
FIELDS = [1e-30, 1e-12, 1e-3, 0.3, 0.5 - 1e-9, 0.5, 0.5 + 1e-12, 0.6, 1.0, 4.0, 1e3, 1e12, 1e60]


def exact_length(lasts: float, along: float, across2: float, field: float) -> mp.mpf:
    with mp.workdps(200):
        u0, w2, g = mp.mpf(along), mp.mpf(across2), mp.mpf(field)
        u1 = u0 + g * mp.mpf(lasts)

        def integral(u: mp.mpf) -> mp.mpf:
            s = mp.sqrt(u * u + w2)
            return (u * s + (w2 * mp.asinh(u / mp.sqrt(w2)) if w2 else 0)) / 2

        return (integral(u1) - integral(u0)) / g


def cases() -> list[tuple[float, float, float, float]]:
    """(path, velocity along the field, square of the one across, field)."""
    rng = np.random.default_rng(3)
    found = [(1.0, cos(a), 1 - cos(a) ** 2, g) for a in ANGLES for g in FIELDS]
    for _ in range(500):
        angle, path = rng.uniform(0, pi), rng.exponential() * 10 ** rng.uniform(-3, 3)
        speed, field = 10 ** rng.uniform(-5, 5), 10 ** rng.uniform(-8, 8)
        found.append((path, speed * cos(angle), (speed * np.sin(angle)) ** 2, field))
    return [*found, (2.0, 0.0, 0.0, 3.0)]  # from rest


def test_a_flight_lasts_as_long_as_its_length_takes() -> None:
    for path, along, across2, field in cases():
        speed = sqrt(along * along + across2)
        lasts = time_of_length(path, speed, along, across2, field)
        exact = exact_length(lasts, along, across2, field)
        assert abs(exact / path - 1) < 2e-15, (path, along, across2, field)
        length, u, s = length_of(lasts, speed, along, across2, field)
        assert abs(length / path - 1) < 2e-15
        assert u == along + field * lasts
        assert s == sqrt(u * u + across2)
    assert abs(time_of_length(2.0, 0.0, 0.0, 0.0, 3.0) - sqrt(4 / 3)) < 1e-15


def test_many_at_once_are_the_same_to_rounding() -> None:
    rng = np.random.default_rng(4)
    # As in a steady state; of the other cases many are singular, and left to `time_of_length`.
    usual = [(p, u, w * w, 1.0) for p, u, w in zip(*rng.normal(size=(3, 400)), strict=True)]
    usual = [(p * p / 2, u + 0.5, w2, g) for p, u, w2, g in usual]
    by_field: dict[float, list] = {}
    for case in cases() + usual:
        by_field.setdefault(case[3], []).append(case)
    for field, those in by_field.items():
        work = np.full((ROWS, len(those)), np.nan)
        for a, (path, along, across2, _) in enumerate(those):
            work[LENGTH, a], work[ALONG, a], work[ACROSS2, a] = path, along, across2
            work[SPEED2, a] = along * along + across2
        times_of_lengths(work, len(those), field)
        for a, (path, along, across2, _) in enumerate(those):
            if work[QUALITY, a] >= 0.0:
                exact = exact_length(work[DURATION, a], along, across2, field)
                assert abs(exact / path - 1) < 4e-15, (path, along, across2, field)
        if field == 1.0:
            assert np.sum(work[QUALITY] >= 0.0) > 0.95 * len(usual)

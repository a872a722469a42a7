"""Scatterers that are met again: the derived formulas by other routes, in numbers."""

import math

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

from derivations import symbols as sy
from derivations import verify
from derivations.derived import finite_density
from kinetics import CollisionLaw
from kinetics.collision import law_in_medium

RANDOM = np.random.default_rng(17)
RESTITUTIONS = [0.3, 0.7, 1.0]


@pytest.mark.parametrize("e", RESTITUTIONS)
def test_the_density_straight_back_meets_a_histogram_of_bounces(e: float) -> None:
    y = RANDOM.uniform(-1.0, 1.0, 2_000_000)
    cosine = (-e + (1 + e) * y**2) / np.sqrt(e * e + (1 - e * e) * y**2)
    width = 0.05
    share = np.mean(cosine < -math.cos(width)) / (2 * width)
    assert share == pytest.approx(float(finite_density.straight_back().subs(sy.e, e)), rel=0.02)


@pytest.mark.parametrize("e", RESTITUTIONS)
def test_the_operator_of_the_solver_is_the_derived_one(e: float) -> None:
    n, length = 0.05, sp.Symbol("length", positive=True)
    law = law_in_medium(CollisionLaw(e), "overlapping", n, 1.0, "leading")
    # the derived chance counts from d to l; the solver's logarithm is ln(1/n)
    chance = sp.integrate(finite_density.return_chance(), (sy.dist, 1, length))
    eps = float(chance.subs({sy.e: e, sy.d: 1, sy.rho0: n, length: 1 / n}))
    _, summed = finite_density.return_symbols()
    for m, p in [(0, 1.0), (1, 0.0), (1, 2.5), (2, 3.0)]:
        rate = CollisionLaw(e).harmonic_decay_rate(p, m)
        values = {sy.harm: m, sy.p: p, sy.e: e, sy.lamm: rate, sy.ret: eps}
        assert law.harmonic_decay_rate(p, m) == pytest.approx(
            float(summed.subs(values)), rel=1e-13, abs=1e-15
        )


def test_the_shared_area_meets_random_points() -> None:
    x, y = RANDOM.uniform(-1.0, 2.0, (2, 1_000_000))
    inside = (x**2 + y**2 < 1) & ((x - 1) ** 2 + y**2 < 1)
    assert 9 * inside.mean() == pytest.approx(
        float(finite_density.shared_area().subs(sy.d, 1)), rel=0.01
    )


def test_one_flight_meets_the_fourier_integral() -> None:
    (row,) = verify(["beyond:free-flight"])
    for order, wave in [(0, 0.7), (1, 3.0), (4, 2.0)]:
        exact = mp.quad(
            lambda a, order=order, wave=wave: (
                mp.cos(order * a) / (1 + 1j * wave * mp.cos(a)) / mp.pi
            ),
            [0, mp.pi / 2, mp.pi],
        )
        found = complex(row.derived.rhs.subs({sy.harm: order, sy.wave: wave}))
        assert found == pytest.approx(complex(exact), abs=1e-12)


def test_the_continued_fractions_meet_the_inverse_of_a_matrix() -> None:
    (row,) = verify(["beyond:loops"])
    step, propagator = row.derived
    wave, rates = 1.7, [0.0, 1.3, 0.9, 1.1, 1.0, 1.05]
    size = len(rates) - 1
    order = np.arange(-size, size + 1)
    stream = 0.5j * wave * (np.eye(2 * size + 1, k=1) + np.eye(2 * size + 1, k=-1))
    exact = np.linalg.inv(np.diag([rates[abs(j)] for j in order]) + stream)

    def value(rate: float, further: float) -> float:
        names = {sy.lamj(sy.k): rate, sy.tail(sy.k + 1): further, sy.wave: wave}
        return float(step.rhs.subs(names))

    for m in (0, 1, 2):
        up = down = 0.0
        for j in range(size, m, -1):
            up = value(rates[j], up)
        for j in range(-size, m):
            down = value(rates[abs(j)], down)
        names = {
            sy.lamm: rates[m], sy.wave: wave, sy.tail(sy.harm + 1): up, sy.tail(sy.harm - 1): down
        }  # fmt: skip
        found = float(propagator.rhs.subs(names))
        assert found == pytest.approx(exact[size + m, size + m].real, rel=1e-12)


def test_the_corridor_meets_a_sum_over_its_length() -> None:
    (row,) = verify(["beyond:corridor"])
    rate = row.derived[0].rhs.subs(sy.offset, 1.4)
    u = (np.arange(1000) + 0.5) / 1000
    # per path the strips of width 2 d sweep 2 d; both cover what lies within d of either
    fresh = np.mean(1.4 * u) / 2
    assert float(rate) == pytest.approx(1 + fresh, rel=1e-6)

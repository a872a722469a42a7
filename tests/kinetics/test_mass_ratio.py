"""Scatterers that a collision sets in motion: the law, the closed figures, late times, a field.

The references are two bodies in the frame of their centre of mass, and known figures: neutrons
(Fermi), ions and electrons in a strong field (Wannier 1953, Druyvesteyn).
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import eval_legendre

from kinetics import CollisionLaw, ScalingSolution, Scene, solve, solve_field, solve_scaled

MASSES = (0.2, 0.5, 1.0, 3.0)


def after(y: float, alpha: float, mass: float) -> np.ndarray:
    """The velocity after a collision, (1, 0) before it: both bodies about their centre of mass."""
    normal = np.array([-math.sqrt((1.0 - y) * (1.0 + y)), y])
    relative, centre = np.array([1.0, 0.0]), np.array([1.0, 0.0]) / (1.0 + mass)
    turned = relative - (1.0 + alpha) * (relative @ normal) * normal
    return np.asarray(centre + mass / (1.0 + mass) * turned)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("alpha", [1.0, 0.6])
@pytest.mark.parametrize("mass", MASSES)
def test_averages_are_those_of_two_bodies(mass: float, alpha: float, dimension: int) -> None:
    def average(of: Callable[[float, float], float]) -> float:
        def at(y: float) -> float:
            velocity = after(y, alpha, mass)
            speed = math.hypot(*velocity)
            share = 1.0 if dimension == 2 else 2.0 * y
            return share * of(speed, velocity[0] / speed)

        return float(quad(at, 0.0, 1.0, epsabs=1e-13, epsrel=1e-12, limit=200)[0])

    law = CollisionLaw(alpha, dimension=dimension, mass_ratio=mass)
    assert law.mean_log_loss == pytest.approx(average(lambda s, c: -math.log(s)), rel=1e-10)
    assert law.mean_cosine == pytest.approx(average(lambda s, c: c), rel=1e-10, abs=1e-12)
    for p, m in ((0.0, 1), (0.0, 2), (1.0, 0), (2.5, 3), (-0.5, 0), (7.0, 4)):
        harmonic = math.cos if dimension == 2 else eval_legendre

        def lost(s: float, c: float, p: float = p, m: int = m, harmonic: Any = harmonic) -> float:
            kept = harmonic(m * math.acos(min(c, 1.0))) if dimension == 2 else harmonic(m, c)
            return 1.0 - s**p * kept

        rate = law.harmonic_decay_rate(p, m)
        assert rate == pytest.approx(average(lost), rel=1e-9, abs=1e-11), (p, m)


def test_the_neutrons_of_the_text_books() -> None:
    """Mean log loss, mean cosine and displacement in space; mean cosine of light scatterers."""
    losses = (0.5, 0.362673463916, 0.078884494912, 0.004189935901)
    slopes = (12.0, 8.271903788, 26.844908637, 478.675097832)
    for mass, loss, slope in zip((1, 2, 12, 238), losses, slopes, strict=True):
        exact = ScalingSolution(1.0, dimension=3, mass_ratio=mass)
        assert exact.law.mean_log_loss == pytest.approx(loss, abs=6e-13)
        assert exact.law.mean_cosine == pytest.approx(2 / (3 * mass), abs=1e-13)
        assert exact.diffusion_slope == pytest.approx(slope, abs=6e-10)
    for mass in (0.9, 0.1, 1e-4):
        law = CollisionLaw(1.0, dimension=3, mass_ratio=mass)
        # 1 - cos(chi) keeps its digits where it is 1e-9
        assert law.harmonic_decay_rate(0.0, 1) == pytest.approx(mass**2 / 3, rel=2e-12, abs=0.0)


def test_the_effective_restitution() -> None:
    pairs = ((0.7, math.inf), (1.0, 1.0), (0.5, 2.0), (0.0, 0.5), (1.0, 0.2))
    found = [CollisionLaw(e, mass_ratio=mass).effective_restitution for e, mass in pairs]
    assert found[:3] == [0.7, 0.0, 0.0]  # bit for bit
    assert found[3:] == pytest.approx([-2 / 3, -2 / 3], abs=1e-15)
    assert CollisionLaw(1.0) == CollisionLaw(1.0, mass_ratio=math.inf)
    assert CollisionLaw(1.0, dimension=3, mass_ratio=1.0).uniform_power == 2.0
    assert not CollisionLaw(1.0, mass_ratio=5.0).has_atoms
    law = CollisionLaw(1.0, dimension=3, mass_ratio=2.0)  # it brings its own to a scene
    assert Scene(law, times=[1.0]).mass_ratio == 2.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_speeds_see_the_size_of_the_restitution_alone(dimension: int) -> None:
    light = ScalingSolution(1.0, dimension=dimension, mass_ratio=0.2)
    fixed = ScalingSolution(2 / 3, dimension=dimension)
    solved = solve_scaled(1.0, dimension=dimension, mass_ratio=0.2)
    c = np.array([0.1, 0.7, 1.0, 2.5])
    for one in (fixed, solved):
        assert light.cooling_rate == pytest.approx(one.cooling_rate, rel=1e-12)
        assert light.a2 == pytest.approx(one.a2, rel=1e-10)
        np.testing.assert_allclose(one.vdf(c), light.vdf(c), rtol=1e-9)
    # but directions last: in space 1 - <cos chi> is A^2/3, not 2 (1 - (1 - e)/(3 (1 + e)))
    assert light.diffusion_slope > 9.0 * fixed.diffusion_slope


@pytest.mark.parametrize(("mass", "dimension"), [(0.2, 2), (0.2, 3), (0.5, 2)])
def test_directions_that_last_are_followed_to_the_end(mass: float, dimension: int) -> None:
    """Late, d<r^2>/d ln t is off by t^z, z the zero of 1 - E[s^z cos(chi)]: -0.046 at worst."""
    times = [1e60, 1e90, 1e299]
    scene = Scene(
        1.0, number_density=1.0, dimension=dimension, mass_ratio=mass, times=times,
        outputs=("msd", "diffusion_coefficient"),
    )  # fmt: skip
    exact = ScalingSolution(1.0, dimension=dimension, mass_ratio=mass)
    off = solve(scene).msd_slope / (scene.mean_free_path**2 * exact.diffusion_slope) - 1.0
    assert abs(off[2]) < 1e-12
    if mass == 0.2:
        z = math.log(off[1] / off[0]) / math.log(times[1] / times[0])
        assert exact.law.harmonic_decay_rate(z, 1) == pytest.approx(0.0, abs=1e-7)


def test_a_field_of_known_limits() -> None:
    assert solve_field(0.0, mass_ratio=0.5).drift == pytest.approx(
        solve_field(1.0, mass_ratio=0.2).drift, rel=1e-11
    )
    assert solve_field(1.0, 3, mass_ratio=1.0).drift == pytest.approx(1.146740254, abs=6e-10)
    # Druyvesteyn: f_0 = exp(-(3/4) (m/M) v^4), and f_1 = -f_0'/v: the drift is 2 <1/v>/3
    first, second = (quad(lambda v, n=n: v**n * math.exp(-0.75 * v**4), 0, 5)[0] for n in (1, 2))
    limit = 2.0 / 3.0 * first / second
    for mass, near in ((1e4, 1e-4), (1e6, 1e-6)):
        drift = solve_field(1.0, 3, mass_ratio=mass).drift * mass**0.25
        assert drift == pytest.approx(limit, rel=near)
    assert limit == pytest.approx(0.897, abs=5e-4)

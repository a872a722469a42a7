"""F(k, t) and the density of the displacement in space, of rough scatterers, of laws of samples."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from example_values import gaussian_speeds
from marking import slow_but

from kinetics import AngularHarmonics, Beam, CollisionLaw, Scene, SolverStatus, solve
from kinetics.numerics.gauss import panels_between
from kinetics.position.directions import mean_phase

PATH = 12.5
DENSITY = {2: 1.0 / (2.0 * PATH), 3: 1.0 / (math.pi * PATH)}  # scatterers per d^2 or d^3
OUTPUTS = ("msd", "kurtosis", "position_density", "intermediate_scattering")

# F(k, t) of isotropic scattering in space, l = v = 1, by tests/references/one_speed.py: rows are
# times, columns wave numbers
IN_SPACE = partial(gaussian_speeds, dimension=3)
TIMES, WAVE_NUMBERS = (0.5, 2.0, 4.0, 10.0), (0.3, 1.0, 2.5, 8.0)
ONE_SPEED = np.array([
    (0.99680740299138336, 0.96489788710750154, 0.79353634423315582, -0.087902963940590419),
    (0.96638477155745434, 0.67274398274043397, 0.0032171606301799188, 0.0025841164449471678),
    (0.91292608244219119, 0.33833615380596938, 0.0019252455258241822, -3.9973412301538862e-5),
    (0.7620635909806319, 0.039405397760367072, -1.1348748558636662e-6, -3.9716504558551546e-7),
])  # fmt: skip

MIXTURE = CollisionLaw.from_samples(
    [0.3, 0.2, 0.5], [0.9, 0.45, 0.7], [0.2, -0.6, 0.1], dimension=3
)
LAWS = [
    CollisionLaw(0.4, dimension=3), CollisionLaw(1.0, dimension=3),
    CollisionLaw(0.9, 0.8, dimension=3), CollisionLaw(0.0, dimension=3), CollisionLaw(0.7, 0.8),
    CollisionLaw(0.6, 0.6), MIXTURE,
]  # fmt: skip


def scene(
    law: CollisionLaw, times: Any, initial: Any = "gaussian", outputs: Any = OUTPUTS
) -> Scene:
    """Times in l/U."""
    return Scene(**law.arguments, number_density=DENSITY[law.dimension], initial=initial,
                 times=PATH * np.atleast_1d(times), outputs=outputs)  # fmt: skip


def test_elastic_spheres_of_one_speed_against_the_transport_solution() -> None:
    law = CollisionLaw(1.0, dimension=3)
    found = solve(scene(law, TIMES, "monoenergetic", "intermediate_scattering"), rtol=1e-12)
    f = found.intermediate_scattering(np.array(WAVE_NUMBERS) / PATH)
    assert np.abs(f - ONE_SPEED).max() < 1e-12


DENSE = [
    {"restitution": e, "number_density": n, "scatterers": "hard disks"}
    for e, n in ((0.7, 0.04), (0.3, 0.1))
]


@pytest.mark.parametrize(
    "system", [*({"restitution": law, "number_density": DENSITY[law.dimension]} for law in LAWS),
               *DENSE], ids=repr,
)  # fmt: skip
@pytest.mark.parametrize("initial", ["gaussian", "monoenergetic"])
def test_small_wave_numbers(system: dict[str, Any], initial: str) -> None:
    """F = 1 - k^2 <r^2>/(2 d) + k^4 <r^4>/(8 d (d + 2)) - ..."""
    asked = ("msd", "kurtosis", "intermediate_scattering")
    scene = Scene(**system, initial=initial, times=PATH * np.array([0.5, 20.0, 1e4]), outputs=asked)
    found, d = solve(scene, 1e-9), scene.dimension
    for i, second in enumerate(found.msd):
        k2 = 1e-2 / second
        fourth = found.kurtosis[i] * second**2
        expected = 1.0 - k2 * second / (2 * d) + k2**2 * fourth / (8 * d * (d + 2))
        f = found.intermediate_scattering([math.sqrt(k2)])[i, 0]
        assert abs(f - expected) < 1e-7
        assert abs(f - expected) < 0.02 * abs(k2**2 * fourth / (8 * d * (d + 2)))


@pytest.mark.parametrize(
    ("initial", "dimension"),
    slow_but([(Beam(0.7), 2)], [(Beam(0.7), 2), (AngularHarmonics({0: IN_SPACE, 1: IN_SPACE}), 3)]),
)
def test_directed_starts(initial: Any, dimension: int) -> None:
    """Along k the slope of F is the mean displacement; over all k its mean is the isotropic F."""
    outputs = ("mean_displacement", "msd", "intermediate_scattering")
    found = solve(scene(CollisionLaw(0.5, 0.9, dimension), [0.2, 6.0], initial, outputs))
    way = found.mean_displacement
    if dimension == 3:
        assert np.abs(way[:, 1:]).max() < 1e-12
    k, waves = 1e-4, [0.03, 0.1]
    for angle in (0.0, 0.7, 2.0, math.pi):
        f = found.intermediate_scattering([k], direction=angle)[:, 0]
        along = way[:, :2] @ np.array([math.cos(angle), math.sin(angle)])
        assert np.abs(f.imag / k - along).max() < 1e-5 * np.abs(way).max()
    cosine, weight = np.polynomial.legendre.leggauss(24)
    angles, weight = (np.arccos(cosine), 0.5 * weight)
    if dimension == 2:
        angles, weight = 2.0 * math.pi * np.arange(24) / 24, np.full(24, 1.0 / 24)
    parts = [found.intermediate_scattering(waves, direction=a) for a in angles]
    mean = np.tensordot(weight, parts, axes=1)
    assert np.abs(mean - found.intermediate_scattering(waves)).max() < 1e-10


def test_a_density_that_is_not_resolved_says_so() -> None:
    """Each sample has a front of its own: early they cannot be told apart."""
    found = solve(scene(MIXTURE, 2.0, "monoenergetic"), rtol=1e-5)
    assert found.status is SolverStatus.TOLERANCE_NOT_REACHED
    assert found.error_estimate > 1e-3


@pytest.mark.slow
def test_bounces_that_all_but_stop_every_tracer() -> None:
    """et = e: no shift of a bounce ended on the panels, and the transform at 0 had no values."""
    found = solve(scene(CollisionLaw(1e-4, 1e-4), 8e-2), rtol=1e-3)
    assert abs(found.position_fraction([0.0, 1e3])[0, 0] - 1.0) < found.error_estimate < 0.1


def test_tracers_that_a_bounce_stops_for_good() -> None:
    """At e = et = 1e-7, T = v t/l: F = exp(-T) J_0(K T) + integral of exp(-x) J_0(K x) to x = T."""
    t, k = 4.0, np.array([0.3, 1.0, 2.5])
    node, w = panels_between(np.linspace(0.0, 1.0, 41), 20)
    expected = np.zeros(k.size)
    for v, weight in zip(*panels_between(np.linspace(0.0, 8.0, 9), 20), strict=True):
        x = v * t * np.append(node, 1.0)
        f = np.append(v * t * w, 1.0) @ (np.exp(-x)[:, None] * mean_phase(np.outer(x, k), 2))
        expected += weight * v * math.exp(-0.5 * v * v) * f
    found = solve(scene(CollisionLaw(1e-7, 1e-7), t, outputs="intermediate_scattering"), 1e-6)
    assert np.abs(found.intermediate_scattering(k / PATH)[0] - expected).max() < 2e-6


def test_samples_that_throw_tracers_straight_back_do_not_claim_too_much() -> None:
    """F falls as 1/K, in space too; G was below zero by 0.04 with an estimate of 0.002."""
    bounces = [0.2, 0.3, 0.2, 0.3], [0.9, 0.5, 1.0, 1.0], [-1.0, 0.0, 0.5, 1.0]
    law = CollisionLaw.from_samples(*bounces, dimension=3)
    found = solve(scene(law, 100.0, "gaussian"), rtol=1e-3)
    least = float(found.scaled_position_density(np.linspace(0.01, 6.0, 600)).min())
    assert -least < found.stats["position_density_error"]

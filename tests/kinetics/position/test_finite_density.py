"""F(k, t) and G(R) among scatterers that are met again, by other routes."""

import math
import warnings
from collections.abc import Callable

import numpy as np
import pytest
from scipy.special import exp1, j0

from kinetics import CollisionLaw, InputError, Scene, ToleranceWarning, solve
from particles import HardDisks, simulate


def chance_of_loops(n: float, eps: np.ndarray, z: complex) -> np.ndarray:
    """Laplace transform at z of the path of loops of elastic tracers, for each harmonic.

    int exp(-z y - q (y + a))/(y + a) dy = exp(z a) E1((z + q) a).
    """

    def parts(z: complex) -> tuple[complex, complex]:
        return n * np.exp(2 * n * z) * exp1(2 * n * (0.6 + z)), 1.0 / (0.5 + z) / (1.1 / 1.8 + z)

    (near, far), (all_near, all_far) = parts(z), parts(0.0)
    return near + (eps - all_near) * far / all_far


@pytest.mark.parametrize("n", [0.02, 0.1])
def test_elastic_tracers_of_one_speed_obey_a_matrix(n: float) -> None:
    """All harmonics of one speed: the Laplace transform of a is the inverse of a matrix."""
    scene = Scene(
        1.0, n, times=[0.1 / n, 1.0 / n, 4.0 / n], initial="monoenergetic",
        scatterers="overlapping", outputs="intermediate_scattering",
    )  # fmt: skip
    law, path, m = CollisionLaw(1.0), scene.mean_free_path, np.arange(60)
    sign, eps = (-1.0) ** m, np.array([scene.law.returns(int(k))[0] for k in m])
    alone = np.array([law.harmonic_decay_rate(0.0, int(k)) for k in m])
    couple = np.eye(60, k=-1) - np.eye(60, k=1)
    couple[0, 1] = -2.0
    wave_numbers = np.array([0.3, 1.0, 2.0])  # in 1/l
    found = solve(scene).intermediate_scattering(wave_numbers / path)

    def transform(z: complex, k: float) -> complex:
        again = sign * chance_of_loops(n, sign * eps, z)
        rates = z + alone / (1.0 + again * alone)
        return complex(np.linalg.solve(np.diag(rates) - 0.5 * k * couple, np.eye(60)[0])[0])

    for i, t in enumerate(np.asarray(scene.times) / path):
        for k, f in zip(wave_numbers, found[i], strict=True):
            exact = inverse_laplace(lambda z, k=k: transform(z, k), t)
            # at the first time a series has most of it, without the panels of later times
            assert f == pytest.approx(exact, abs=(1e-7 if i == 0 else 1e-5) * n)


@pytest.mark.slow
def test_the_waves_of_tracers_among_hard_disks() -> None:
    """To 0.1 n and 3.5 errors; with returns at once F was 0.4 n off."""
    e, n, paths, k = 0.7, 0.04, np.array([0.5, 1.0, 2.0, 4.0]), np.array([0.7, 1.5, 2.5, 4.0])
    times = paths / (2 * n)
    run = simulate(HardDisks(n, 10_000), e, times=times, media=2000, tracers=200, seed=60,
                   observables=["positions"])  # fmt: skip
    phase = j0(2 * n * k * np.hypot(*np.moveaxis(run.positions, 2, 0))[:, :, None])
    media = phase.reshape(times.size, 2000, 200, k.size).mean(axis=2)
    found, error = media.mean(axis=1), media.std(axis=1) / math.sqrt(2000)
    scene = Scene(e, n, times=times, scatterers="hard disks", outputs="intermediate_scattering")
    exact = solve(scene, 1e-6).intermediate_scattering(2 * n * k)
    assert np.all(np.abs(found - exact) < 0.1 * n + 3.5 * error)
    assert error.max() < 0.05 * n


def test_a_wave_number_has_its_value_whatever_else_is_asked() -> None:
    """Those of one group share their panels; too large ones are refused, not solved otherwise."""
    scene = Scene(0.9, 0.1, times=[5.0, 50.0], scatterers="hard disks",
                  outputs="intermediate_scattering")  # fmt: skip
    solution, path = solve(scene, rtol=1e-6), scene.mean_free_path
    alone = solution.intermediate_scattering([12.0 / path])
    both = solution.intermediate_scattering(np.array([12.0, 19.9]) / path)
    assert both[:, :1] == pytest.approx(alone, abs=2e-6)
    with pytest.raises(InputError, match="wave_numbers"):
        solution.intermediate_scattering(np.array([12.0, 20.5]) / path)


def inverse_laplace(function: Callable[[complex], complex], t: float, points: int = 28) -> float:
    """Along Talbot's contour (Weideman, SIAM J. Numer. Anal. 44 (2006) 2342)."""
    total, scale = 0.0, 2 * points / t
    for theta in (np.arange(points) + 0.5) * np.pi / points:
        cot = 1.0 / np.tan(0.6407 * theta)
        z = scale * (0.5017 * theta * cot - 0.6122 + 0.2645j * theta)
        slope = 0.5017 * cot - 0.5017 * 0.6407 * theta / np.sin(0.6407 * theta) ** 2 + 0.2645j
        total += (np.exp(z * t) * function(z) * slope * scale).imag / points
    return total


@pytest.mark.slow
def test_more_accuracy_asked_for_leaves_no_less_within_the_work() -> None:
    """Where it is not to be had, two steps of a ladder that all tolerances share."""
    scene = Scene(0.4, 0.04, times=[3e3], scatterers="hard disks", outputs="position_density")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        errors = [solve(scene, rtol).error_estimate for rtol in (1e-3, 1e-4, 1e-5, 1e-6)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 3e-3

"""F(k, t) among scatterers that are met again, by other routes."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import j0

from kinetics import Beam, CollisionLaw, Scene, solve
from tests.references.returning_flights import returning_flights


@pytest.mark.parametrize(("e", "n"), [(0.7, 0.04), (0.3, 0.1)])
def test_small_wave_numbers_give_the_moments_of_position(e: float, n: float) -> None:
    """F = 1 - k^2 <r^2>/4 + k^4 <r^4>/64 - ...: averages from other panels, in other steps."""
    scene = Scene(
        e, n, times=np.array([0.3, 2.0, 50.0, 1e5]) / n, scatterers="hard disks",
        outputs=("msd", "kurtosis", "intermediate_scattering"),
    )  # fmt: skip
    solution = solve(scene)
    q = 0.004 * np.arange(1.0, 7.0)  # k^2 <r^2>/4
    for i, square in enumerate(solution.msd):
        f = solution.intermediate_scattering(np.sqrt(4.0 * q / square))[i]
        series = np.linalg.solve(q[:, None] ** np.arange(6), (1.0 - f) / q)
        assert series[0] == pytest.approx(1.0, abs=1e-7)
        assert series[1] == pytest.approx(-0.25 * solution.kurtosis[i], rel=2e-5)


@pytest.mark.parametrize("n", [0.02, 0.1])
def test_elastic_tracers_of_one_speed_obey_a_matrix(n: float) -> None:
    """All harmonics of one speed: da/dT is a tridiagonal matrix times a."""
    scene = Scene(
        1.0, n, times=[1.0 / n, 5.0 / n], initial="monoenergetic", scatterers="overlapping",
        outputs="intermediate_scattering",
    )  # fmt: skip
    law, path, m = CollisionLaw(1.0), scene.mean_free_path, np.arange(60)
    eps = np.array([scene.law.returns(int(k))[0] for k in m])
    alone = np.array([law.harmonic_decay_rate(0.0, int(k)) for k in m])
    couple = np.eye(60, k=-1) - np.eye(60, k=1)
    couple[0, 1] = -2.0
    wave_numbers = np.array([0.3, 1.0, 4.0])  # in 1/l
    found = solve(scene).intermediate_scattering(wave_numbers / path)
    for i, t in enumerate(np.asarray(scene.times) / path):
        for k, f in zip(wave_numbers, found[i], strict=True):
            matrix = 0.5 * k * couple - np.diag(alone / (1.0 + eps * alone))
            assert f == pytest.approx(expm(matrix * t)[0, 0], abs=1e-9)


def test_random_flights_have_these_waves() -> None:
    e, n, time = 0.5, 0.04, 2.0
    eps = 2 * e / (1 + e) * n * math.log(1 / n)
    flights = returning_flights(e, eps, time, 300_000, 6)
    path = 1.0 / (2.0 * n)
    k = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
    medium = {"scatterers": "overlapping", "density_order": "leading"}
    pulls = []
    for arguments in (medium, {}):
        scene = Scene(e, n, times=[time * path], outputs="intermediate_scattering", **arguments)
        for wave, f in zip(k, solve(scene).intermediate_scattering(k / path)[0], strict=True):
            found, error = flights.mean(j0(wave * abs(flights.place)))
            pulls.append((found - f) / error)
    assert max(map(abs, pulls[:5])) < 3.5
    assert max(map(abs, pulls[5:])) > 6.0  # the dilute ones are others


def test_a_direction_of_the_wave_vector_and_a_low_density() -> None:
    n = 1e-6
    k = np.array([0.3, 2.0]) * n
    dilute, dense = (
        solve(
            Scene(
                0.6,
                n,
                times=[2.0 / n],
                initial=Beam(1.0),
                outputs="intermediate_scattering",
                **more,
            )
        ).intermediate_scattering(k, direction=0.4)
        for more in ({}, {"scatterers": "hard disks"})
    )
    change = np.abs(dense - dilute).max()
    assert 0.1 * n < change < 3.0 * n * math.log(1.0 / n)
    assert np.abs(dense.imag).max() > 0.1

"""Runs reduced to a case: the errors are the spread that repeated runs have."""

import math

import numpy as np
import pytest

from kinetics import Scene, solve
from kinetics.crosscheck.report.algebra import algebra_process
from kinetics.crosscheck.report.run_methods import (
    OUTPUTS,
    _rescaled_errors,
    _without_each,
    jackknife_error,
    output_times,
    scaled_density,
)
from kinetics.crosscheck.report.settings import ReportSettings
from particles import BoltzmannGrad, simulate


def test_the_scaled_density_of_gaussian_velocities_and_its_errors() -> None:
    # F = exp(-c^2)/pi whatever the unit of the speeds; 300 repeats show the true spread
    edges = np.array([0.0, 0.3, 0.8, 1.2, 2.0])
    area = math.pi * np.diff(edges**2)
    exact = -np.diff(np.exp(-(edges**2))) / area
    rng = np.random.default_rng(2)
    runs = [
        scaled_density(np.hypot(*rng.normal(0, 7.0, (2, 25, 40))), edges, area) for _ in range(300)
    ]
    values = np.array([run.value for run in runs])
    errors = np.array([run.error for run in runs])
    spread = values.std(axis=0)
    # the mean of 300 is within 5 of its own errors
    assert np.all(np.abs(values.mean(axis=0) - exact) < 5 * spread / math.sqrt(300))
    # 300 repeats know the spread to 4 %; the jackknife is a little conservative
    np.testing.assert_allclose(np.sqrt((errors**2).mean(axis=0)), spread, rtol=0.2)


def test_leaving_out_a_configuration_keeps_the_others() -> None:
    times = np.array([1.0, 10.0])
    run = simulate(BoltzmannGrad(0.04), 0.7, times=times, media=5, tracers=20, seed=3)
    parts = list(_without_each(run))
    assert len(parts) == 5
    assert all(part.samples.tolist() == [80, 80] for part in parts)
    replicates = np.array([part.msd.value for part in parts])
    np.testing.assert_allclose(jackknife_error(replicates), run.msd.error, rtol=1e-12)


def test_errors_with_the_measured_free_path_put_in_are_the_true_ones() -> None:
    # Boltzmann-Grad runs obey the equation with any l that they have: data minus theory at the
    # run's own l must have mean 0 and the stated spread. 50 seeds know a spread to 10 %.
    times = output_times(200.0, 6)
    deviations: dict[str, list[np.ndarray]] = {"thermal_speed": [], "msd": []}
    for seed in range(50):
        run = simulate(BoltzmannGrad(0.04), 0.7, times=times, media=30, tracers=20, seed=seed)
        density = 1 / (2 * float(run.mean_free_path.value))
        scene = Scene(0.7, number_density=density, times=times, outputs=OUTPUTS)
        theory = solve(scene, rtol=1e-4)
        errors = _rescaled_errors(run, theory, 3, 0.04)
        for name, z in deviations.items():
            data, expected = getattr(run, name).value, getattr(theory, name)
            z.append(((data - expected) / errors[name])[2:])
    for z in deviations.values():
        assert np.all(np.abs(np.mean(z, axis=0)) < 5 / math.sqrt(50))
        assert np.all((np.std(z, axis=0) > 0.65) & (np.std(z, axis=0) < 1.45))


def test_leaving_by_an_exception_ends_the_derivations() -> None:
    with pytest.raises(KeyError), algebra_process(ReportSettings()) as algebra:
        raise KeyError
    assert algebra.returncode == -9

"""What runs are reduced to: densities and errors of samples whose truth is known."""

import math

import numpy as np

from kinetics.crosscheck.report.runs import scaled_density


def test_the_scaled_density_of_gaussian_velocities_and_its_errors() -> None:
    # F = exp(-c^2)/pi whatever the unit of the speeds; 300 repeats show the true spread
    edges = np.array([0.0, 0.3, 0.8, 1.2, 2.0])
    area = math.pi * np.diff(edges**2)
    exact = -np.diff(np.exp(-(edges**2))) / area
    rng = np.random.default_rng(2)
    samples = [np.hypot(*rng.normal(0, 7.0, (2, 25, 40))) for _ in range(300)]
    runs = [scaled_density(each, edges, area) for each in samples]
    values, errors = (np.array([getattr(r, k) for r in runs]) for k in ("value", "error"))
    spread = values.std(axis=0)
    assert np.all(np.abs(values.mean(axis=0) - exact) < 5 * spread / math.sqrt(300))
    # 300 repeats know the spread to 4 %; the jackknife is a little conservative
    np.testing.assert_allclose(np.sqrt((errors**2).mean(axis=0)), spread, rtol=0.2)

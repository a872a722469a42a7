"""Errors of shares and of functions of sums, against the formulas that they must reduce to."""

import numpy as np
import pytest

from particles import OBSERVABLES, BoltzmannGrad, simulate
from particles.results import estimate_shares


def test_the_error_of_a_share_of_unequal_configurations_is_cochrans() -> None:
    # The variance of a ratio estimator, written out: n/(n - 1) sum (c - p m)^2 / (sum m)^2.
    rng = np.random.default_rng(7)
    n = 4
    m = rng.integers(100, 300, (n, 1)).astype(float)
    counts = rng.binomial(m.astype(int), 0.3)[:, :, None].astype(float)
    products = (part.sum(axis=0) for part in (counts, counts**2, counts * m[:, :, None]))
    estimate = estimate_shares(*products, np.stack((m.sum(axis=0), (m**2).sum(axis=0))), n)
    p = counts.sum() / m.sum()
    variance = n / (n - 1) * np.sum((counts[:, 0, 0] - p * m[:, 0]) ** 2) / m.sum() ** 2
    assert estimate.value[0, 0] == pytest.approx(p, rel=1e-14)
    assert estimate.error[0, 0] == pytest.approx(np.sqrt(variance), rel=1e-9)


@pytest.mark.parametrize("field", [0.0, 0.3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_estimates_are_those_of_the_raw_data(dimension: int, field: float) -> None:
    given = np.random.default_rng(4).normal(size=(3, 50, dimension))
    refused = {"velocity_component_histogram"} if field else set()
    run = simulate(
        BoltzmannGrad(0.05, diameter=2.0, dimension=dimension), 0.6, given, [0.0, 2.0, 60.0],
        media=3, tracers=50, field=field, observables=sorted({*OBSERVABLES} - refused),
    )  # fmt: skip
    r, v = run.positions, run.velocities
    assert r.shape == v.shape == (3, 150, dimension)
    np.testing.assert_allclose(v[0], given.reshape(150, dimension), rtol=1e-14)
    r2, v2 = (r**2).sum(axis=2), (v**2).sum(axis=2)
    means = {
        "msd": r2.mean(axis=1),
        "thermal_speed": np.sqrt(v2.mean(axis=1)),
        "velocity_autocorrelation": (v * v[0]).sum(axis=2).mean(axis=1),
    }
    if field:
        about = r - r.mean(axis=1, keepdims=True)
        spread = np.einsum("tni,tnj->tij", about, about) / 150
        means |= {
            "drift": v[:, :, 0].mean(axis=1),
            "mean_velocity": v.mean(axis=1),
            "velocity_tensor": np.einsum("tni,tnj->tij", v, v) / 150,
            "mean_displacement": r.mean(axis=1),
            "dispersion": spread,
            "dispersion_parallel": spread[:, 0, 0],
            "dispersion_perpendicular": spread[:, 1:, 1:].trace(axis1=1, axis2=2) / (dimension - 1),
        }
    for name, expected in means.items():
        estimate = getattr(run, name)
        assert name in run.outputs
        np.testing.assert_allclose(estimate.value, expected, rtol=1e-9, atol=1e-9, err_msg=name)
        assert estimate.error.shape == expected.shape
    # Errors: of a mean over three configurations, and the jackknife of a bent function of means.
    far, fast = (x[-1].reshape(3, 50).mean(axis=1) for x in (r2, v2))
    assert run.msd.error[-1] == pytest.approx(far.std(ddof=1) / np.sqrt(3), rel=1e-9)
    without = np.sqrt((fast.sum() - fast) / 2)
    assert run.thermal_speed.error[-1] == pytest.approx(without.std() * np.sqrt(2), rel=1e-9)
    if not field:
        kurtosis = (r2**2).mean(axis=1)[1:] / r2.mean(axis=1)[1:] ** 2
        np.testing.assert_allclose(run.kurtosis.value[1:], kurtosis, rtol=1e-12)
        a2 = dimension / (dimension + 2) * (v2**2).mean(axis=1) / v2.mean(axis=1) ** 2 - 1
        np.testing.assert_allclose(run.a2.value, a2, rtol=1e-11)
    values = {"speed": np.sqrt(v2), "velocity_component": abs(v[:, :, 0]), "displacement": r2**0.5}
    for name in [f"{one}_histogram" for one in values if f"{one}_histogram" not in refused]:
        histogram = getattr(run, name)
        for k in (1, 2):
            counts = np.histogram(values[name.removesuffix("_histogram")][k], histogram.edges)[0]
            np.testing.assert_allclose(histogram.probability.value[k], counts / 150, atol=1e-14)
    # The last flight ends at the last time.
    ln_v, ln_t, x, y, _, *z = run.finals.T
    np.testing.assert_allclose(np.stack((x, y, *z), axis=1), r[-1], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(np.exp(2 * ln_v), v2[-1], rtol=1e-11)
    np.testing.assert_allclose(np.exp(ln_t), 60.0, rtol=1e-12)

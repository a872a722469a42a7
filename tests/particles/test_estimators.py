"""Errors of shares and of functions of sums, against the formulas that they must reduce to."""

import numpy as np
import pytest

from particles.estimators import jackknife, share


def test_the_error_of_a_share_of_unequal_configurations_is_cochrans() -> None:
    # The variance of a ratio estimator, written out: n/(n - 1) sum (c - p m)^2 / (sum m)^2.
    rng = np.random.default_rng(7)
    n = 4
    m = rng.integers(100, 300, (n, 1)).astype(float)
    counts = rng.binomial(m.astype(int), 0.3)[:, :, None].astype(float)
    estimate = share(
        counts.sum(axis=0),
        (counts**2).sum(axis=0),
        (counts * m[:, :, None]).sum(axis=0),
        np.stack((m.sum(axis=0), (m**2).sum(axis=0))),
        n,
    )
    p = counts.sum() / m.sum()
    variance = n / (n - 1) * np.sum((counts[:, 0, 0] - p * m[:, 0]) ** 2) / m.sum() ** 2
    assert estimate.value[0, 0] == pytest.approx(p, rel=1e-14)
    assert estimate.error[0, 0] == pytest.approx(np.sqrt(variance), rel=1e-9)


@pytest.mark.parametrize("n", [2, 3, 10])
def test_the_jackknife_of_a_mean_is_its_standard_error(n: int) -> None:
    values = np.random.default_rng(n).normal(size=n)
    sums = np.stack((np.ones(n), values), axis=1)
    estimate = jackknife(sums, lambda s: s[1] / s[0])
    assert float(estimate.value) == pytest.approx(values.mean(), rel=1e-13)
    assert float(estimate.error) == pytest.approx(values.std(ddof=1) / np.sqrt(n), rel=1e-10)

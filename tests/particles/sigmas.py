"""Numbers with standard errors against what is exact."""

from math import inf, sqrt
from typing import Any

import numpy as np
from scipy.stats import chi2

from particles import Ensemble


def check(value: Any, error: Any, exact: Any, relative: float = inf) -> None:
    """The values are within 4 standard errors, and these are no more than a part of the exact."""
    value, error, exact = map(np.asarray, (value, error, exact))
    if relative < inf:
        assert np.all(error < np.maximum(relative * abs(exact), 1e-12)), (value, error)
    assert np.all(abs(value - exact) < 4 * error), (value, exact, (value - exact) / error)


def check_averages(run: Ensemble, solution: Any, names: tuple[str, ...]) -> None:
    for name in names:
        estimate = getattr(run, name)
        check(estimate.value, estimate.error, getattr(solution, name))


def check_counts(n: int, counts: Any, shares: Any) -> None:
    """Of n independent tracers, against the share of all in each bin; what is left is a bin."""
    expected = n * np.append(shares, 1.0 - shares.sum())
    found, used = np.append(counts, n - counts.sum()), expected > 20.0
    chi_square = np.sum((found - expected)[used] ** 2 / expected[used])
    assert used.sum() > 10
    assert 1e-3 < chi2.sf(chi_square, used.sum() - 1) < 0.999, (chi_square, used.sum())


def square(run: Ensemble) -> tuple[np.ndarray, np.ndarray]:
    """<v^2> and its error."""
    speed = run.thermal_speed
    return speed.value**2, 2 * speed.value * speed.error


def mean(values: np.ndarray) -> tuple[float, float]:
    """Mean and error of numbers (n_times, tracers); those of a tracer are not independent."""
    each = np.atleast_2d(values).mean(axis=0)
    return each.mean(), each.std(ddof=1) / sqrt(each.size)

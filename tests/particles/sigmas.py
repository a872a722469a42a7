"""Numbers with standard errors against what is exact."""

from math import inf, sqrt
from typing import Any

import numpy as np

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


def square(run: Ensemble) -> tuple[np.ndarray, np.ndarray]:
    """<v^2> and its error."""
    speed = run.thermal_speed
    return speed.value**2, 2 * speed.value * speed.error


def mean(values: np.ndarray) -> tuple[float, float]:
    """Mean and error of numbers (n_times, tracers); those of a tracer are not independent."""
    each = np.atleast_2d(values).mean(axis=0)
    return each.mean(), each.std(ddof=1) / sqrt(each.size)

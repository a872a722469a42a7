"""Estimates with standard errors, from sums kept per configuration.

Tracers of one configuration share their scatterers and are not independent; configurations are. So
every error is the spread over configurations: the delete-one jackknife, and the ratio estimator's
variance for histograms (Cochran, Sampling Techniques, chapters 6 and 9). It is infinite with one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from particles.results import Value


@dataclass(frozen=True, eq=False)
class Estimate(Value):
    """A value and its standard error, arrays of one shape; time is the first axis.

    The value is NaN where nothing was sampled, the error infinite where it is unknown.
    """

    value: np.ndarray
    error: np.ndarray

    def __repr__(self) -> str:
        """One line for each of the first and last values along the first axis, ten at most."""
        values, errors = np.atleast_1d(self.value), np.atleast_1d(self.error)
        if values.ndim > 1:
            return f"Estimate of shape {values.shape}"
        lines = [_shown(float(v), float(e)) for v, e in zip(values, errors, strict=True)]
        if len(lines) > 9:
            lines[4:-4] = [f"... {len(lines) - 8} more"]
        return f"Estimate({lines[0]})" if len(lines) == 1 else "\n".join(["Estimate", *lines])

    def divided(self, by: np.ndarray | float) -> "Estimate":
        """Return the estimate in another unit."""
        return Estimate(self.value / by, self.error / by)


def _shown(value: float, error: float) -> str:
    """A number to the second digit of its error; as it is where that is too long, or unknown."""
    if not (0.0 < error < np.inf and 1e-4 <= max(abs(value), error) < 1e6):
        return f"{value:.6g} ± {error:.2g}"
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


@dataclass(frozen=True, eq=False)
class Histogram(Value):
    """Share of the samples in each bin.

    edges (n_bins + 1,), the same at every time. probability: Estimate (n_times, n_bins) of the
    share in a bin, not divided by its width; below, above (n_times,): the shares outside.
    """

    edges: np.ndarray
    probability: Estimate
    below: np.ndarray
    above: np.ndarray

    @property
    def density(self) -> Estimate:
        """Probability per unit of the variable, (n_times, n_bins)."""
        return self.probability.divided(np.diff(self.edges))


def jackknife(sums: np.ndarray, function: Callable[[np.ndarray], np.ndarray]) -> Estimate:
    """Return function(total) with its delete-one error.

    sums (n_configurations, ...); function maps a sum over configurations to an array.
    """
    with np.errstate(all="ignore"):
        total, n = sums.sum(axis=0), len(sums)
        value = np.asarray(function(total), dtype=float)
        if n < 2:
            return Estimate(value, np.full(value.shape, np.inf))
        # Deviations from the value: no cancellation in the squares.
        deviations = np.array([function(total - part) for part in sums]) - value
        error = np.sqrt((n - 1) * deviations.var(axis=0))
    return Estimate(value, np.where(np.isnan(error), np.inf, error))


def share(
    counts: np.ndarray, squares: np.ndarray, cross: np.ndarray, samples: np.ndarray, n: int
) -> Estimate:
    """Return counts / samples with its error over n configurations.

    counts, squares, cross (n_times, n_bins): sums over them of the count c in a bin, of c^2 and of
    c m, m the number of samples; samples (2, n_times): sums of m and of m^2.
    """
    with np.errstate(all="ignore"):
        total = samples[0][:, None]
        p = counts / total
        spread = np.maximum(squares - 2.0 * p * cross + p * p * samples[1][:, None], 0.0)
        error = np.sqrt(spread * (n / (n - 1))) / total if n > 1 else np.full(p.shape, np.inf)
    return Estimate(p, np.where(np.isnan(error), np.inf, error))

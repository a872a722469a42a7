"""Chi-square where errors are correlated, and known only from the spread of groups.

Of a vector d of differences the covariance C is the jackknife spread of `replicates`, the same with
each of G groups left out in turn. T^2 = d C^-1 d is then no chi-square, but T^2 (G - p)/(p (G - 1))
has the F-distribution with p and G - p degrees of freedom (Hotelling), for groups that are not
Gaussian with `effective_groups` as G. What is reported is the chi-square that has its p-value.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc, gammaincc, gammainccinv

from kinetics.crosscheck.words import Verdict, gaussian_sigmas, judge_sigmas

Array = NDArray[np.float64]


class ChiSquare(NamedTuple):
    """A chi-square; groups that the covariance is from, None if it is exact; statistic: T^2."""

    value: float
    freedom: int
    p_value: float
    groups: int | None
    statistic: float

    @property
    def verdict(self) -> Verdict:
        """On what is left, without a correction for the number of looks."""
        return judge_sigmas(gaussian_sigmas(self.p_value))


def errors(replicates: Array) -> Array:
    """Standard errors from delete-one replicates (G, ...)."""
    return np.asarray(replicates.std(axis=0) * np.sqrt(len(replicates) - 1))


def covariance(replicates: Array) -> Array:
    """Covariance from delete-one replicates (G, p): (p, p)."""
    n, deviation = len(replicates), replicates - replicates.mean(axis=0)
    return np.asarray((n - 1) / n * (deviation.T @ deviation))


def most_freedom(groups: int) -> int:
    """Components that a chi-square from so many groups may have."""
    return max(1, (groups - 1) // 4)  # or the covariance is too uncertain


def spread_out(count: int, most: int) -> list[int]:
    """At most so many of the indices 0 .. count - 1, evenly, with the last."""
    if count <= most:
        return list(range(count))
    return sorted({round(count - 1 - k * (count - 1) / max(most - 1, 1)) for k in range(most)})


def with_spread(error: Array, *values: Array, least: float = 1e-9) -> NDArray[np.bool_]:
    """Where standard errors are more than rounding: over the value at least `least`."""
    with np.errstate(invalid="ignore"):
        size = np.max(np.abs(values), axis=0)
        return np.asarray((error > least * size) & np.isfinite(error))


def effective_groups(replicates: Array) -> Array:
    """Groups that a variance from delete-one replicates (G, ...) is as good as, G at most."""
    # the relative variance of a variance is (2 + kurtosis)/G (Satterthwaite's rule)
    deviation = replicates - replicates.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        excess = np.mean(deviation**4, axis=0) / np.mean(deviation**2, axis=0) ** 2 - 3
    excess = np.where(np.isfinite(excess), np.maximum(excess, 0.0), 0.0)
    return np.asarray(1 + 2 * (len(replicates) - 1) / (2 + excess))


def whitening(matrix: Array, least: float = 1e-9) -> Array:
    """W with W C W^T = 1 on the components that C has: (rank, p).

    least: eigenvalue of correlations, to the largest, below which two components are the same.
    """
    scale = np.sqrt(np.diagonal(matrix))
    scale = np.where(scale > 0, scale, np.inf)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = values > least * max(float(values[-1]), 1e-300)
    return np.asarray((vectors[:, kept] / np.sqrt(values[kept])).T / scale)


def hotelling(difference: Array, replicates: Array, known: Array | None = None) -> ChiSquare | None:
    """Test of a difference (p,) with its replicates (G, p); None without freedom.

    known (p, p): the covariance of an error of the theory, which is added.
    """
    groups = len(replicates)
    if difference.size == 0:
        return None
    axes = whitening(covariance(replicates) + (0.0 if known is None else known))
    white = axes @ difference
    freedom, statistic = white.size, float(white @ white)
    if freedom == 0 or groups <= freedom:
        return None
    effective = max(float(effective_groups(replicates @ axes.T).mean()), freedom + 1.0)
    # the upper tail of the F-distribution; a p-value below doubles is 0
    share = 1 / (1 + statistic / (effective - 1))
    p_value = float(betainc((effective - freedom) / 2, freedom / 2, share))
    value = 2 * float(gammainccinv(freedom / 2, p_value)) if p_value > 1e-300 else statistic
    return ChiSquare(value, freedom, p_value, groups, statistic)


def pearson(counts: Array, expected: Array) -> ChiSquare:
    """Chi-square of counts, two at least, against those expected."""
    value, freedom = float(np.sum((counts - expected) ** 2 / expected)), counts.size - 1
    return ChiSquare(value, freedom, float(gammaincc(freedom / 2, value / 2)), None, value)

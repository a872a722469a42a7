"""Densities of samples over their own root mean square, and how fast they fall, with errors."""

import numpy as np

from kinetics.crosscheck.report.case import Array, Measured

BANDS = np.array([0.0, 0.4, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0])
"""Bands of R = r/sqrt(<r^2>) between which the fall of G(R) is measured; the first is p(0)."""


def jackknife_error(replicates: Array) -> Array:
    """Standard error from n >= 2 estimates that each leave out one group, shape (n, ...)."""
    n = len(replicates)
    return np.asarray(np.sqrt((n - 1) * np.var(replicates, axis=0)))


def scaled_density(samples: Array, edges: Array, measure: Array) -> Measured:
    """Density of samples over their own root mean square, per bin, with its jackknife error.

    samples (n_groups, n_in_group): absolute values; edges (n_bins + 1,) of the scaled variable;
    measure (n_bins,): length or area of each bin. The scale is the sample's, also when a group is
    left out.
    """
    every, replicates = _shares(samples, edges)
    return Measured(every / measure, jackknife_error(replicates / measure))


def _shares(samples: Array, edges: Array) -> tuple[Array, Array]:
    """Share of the samples in each bin of x/rms, and the same without each of the groups."""
    groups, size = samples.shape
    everything = np.sort(samples, axis=None)
    by_group = np.sort(samples, axis=1)
    squares = np.sum(samples**2, axis=1)

    def share(without: int | None) -> Array:
        n, total = groups * size, float(np.sum(squares))
        if without is not None:
            n, total = n - size, total - float(squares[without])
        at = edges * np.sqrt(total / n)
        below = np.searchsorted(everything, at)
        if without is not None:
            below = below - np.searchsorted(by_group[without], at)
        return np.asarray(np.diff(below) / n)

    return share(None), np.array([share(group) for group in range(groups)])


def band_exponent(shares: Array) -> Array:
    """Local exponent n of p(R) ~ exp(-(R/b)^n) from the shares of the `BANDS`.

    shares (..., n_bands); returns (..., n_bands - 2), at `band_middles`: between neighbours, the
    slope of ln ln(p0/p) over ln R, p being the mean of G(R)/(2 pi R) over a band, R its root mean
    square radius, and p0 the first band's. NaN where a band is empty or above the first.
    """
    area = np.pi * np.diff(BANDS**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = shares / area
        fall = np.log(np.log(p[..., :1] / p[..., 1:]))
        exponent = np.diff(fall, axis=-1) / np.diff(np.log(_radii()[1:]))
    return np.where(np.isfinite(exponent), exponent, np.nan)


def _radii() -> Array:
    """Root mean square radius of each band, as of a density that is flat in it."""
    return np.asarray(np.sqrt((BANDS[1:] ** 2 + BANDS[:-1] ** 2) / 2))


def band_middles() -> Array:
    """The R at which `band_exponent` stands: geometric means of neighbouring bands."""
    radii = _radii()[1:]
    return np.asarray(np.sqrt(radii[1:] * radii[:-1]))


def measured_exponent(samples: Array) -> Measured:
    """`band_exponent` of absolute displacements (n_groups, n_in_group), with jackknife errors."""
    every, replicates = _shares(samples, BANDS)
    return Measured(band_exponent(every), jackknife_error(band_exponent(replicates)))

"""Estimates from particles that the report forms itself: late rates, and scaled densities in bins.

A scaled density is that of a speed over its own root mean square, c = v/v0, or of a distance,
R = r/sqrt(<r^2>). Errors are jackknifed: each group of tracers is left out once.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.sample import errors as jackknife_error
from kinetics.crosscheck.report.cases import FloatArray, Measured

#: Edges of the bins of c = v/v0 for F(c). Chosen: narrow where F has its mass, up to c = 6.
SPEED_EDGES = np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(2.25, 6.0, 16)])
#: Edges of the bins of R = r/sqrt(<r^2>) for G(R). Chosen likewise.
POSITION_EDGES = np.concatenate([np.linspace(0.0, 3.0, 31), np.linspace(3.25, 6.0, 12)])
SPEEDS = (SPEED_EDGES[1:] + SPEED_EDGES[:-1]) / 2
DISTANCES = (POSITION_EDGES[1:] + POSITION_EDGES[:-1]) / 2
#: Samples that a bin of a test expects at least. Derived: a difference of 10 % must exceed the
#: limit at 95 %, 2 standard errors of 1/sqrt(n), beside a deviation of 2.5 of them by chance.
MIN_SAMPLES_PER_TEST = 2500
#: Bins that a density must have to be tested: the distribution of a single one is its norm.
MIN_BINS_PER_TEST = 3


def late_rates(
    times: FloatArray, averages: Mapping[str, FloatArray], early: int, half_rate: float
) -> dict[str, FloatArray]:
    """Return h from 1/v0, and d<r^2>/d ln t, between the time of index `early` and the last.

    Parameters
    ----------
    averages : "thermal_speed" and "msd", of shape (..., n_times)
    half_rate : 1/(2 l)
    """
    speeds = averages["thermal_speed"][..., [early, -1]]
    displacements = averages["msd"][..., [early, -1]]
    slope = np.diff(1 / speeds)[..., 0] / (times[-1] - times[early])
    spread = np.diff(displacements)[..., 0] / np.log(times[-1] / times[early])
    return {"cooling_rate": np.asarray(slope / half_rate), "msd_slope": np.asarray(spread)}


def unit_ball(dimension: int) -> float:
    """Return the area of the unit circle, or the volume of the unit sphere."""
    if dimension == 2:
        return math.pi
    return 4 * math.pi / 3


def shell_volumes(edges: FloatArray, dimension: int) -> FloatArray:
    """Return the area, or the volume, of the shell between each two edges."""
    return np.asarray(unit_ball(dimension) * np.diff(edges**dimension))


def scaled_density(samples: FloatArray, edges: FloatArray, measure: FloatArray) -> Measured:
    """Return the density of samples over their own root mean square, in bins.

    Parameters
    ----------
    samples : (n_groups, n_in_group)
    edges : (n_bins + 1,), of the scaled variable
    measure : (n_bins,), length, area or volume of each bin
    """
    sorted_samples = np.sort(samples, axis=None)
    sorted_groups = np.sort(samples, axis=1)
    total_square = np.sum(sorted_samples**2)

    def density_without(group: FloatArray) -> FloatArray:
        count = sorted_samples.size - group.size
        scaled_edges = edges * np.sqrt((total_square - np.sum(group**2)) / count)
        below = np.searchsorted(sorted_samples, scaled_edges)
        below_in_group = np.searchsorted(group, scaled_edges)
        return np.asarray(np.diff(below - below_in_group) / count / measure)

    replicates = np.array([density_without(group) for group in sorted_groups])
    return Measured(density_without(sorted_samples[:0]), jackknife_error(replicates))


def merge_bins(shares: FloatArray, samples: int) -> NDArray[np.int64] | None:
    """Return indices of those edges between which enough samples are expected for a test.

    Parameters
    ----------
    shares : (n_bins,), of the samples that the theory expects in each bin
    samples : their number

    Returns None where there are fewer bins than `MIN_BINS_PER_TEST`.
    """
    expected = samples * np.concatenate([[0.0], np.cumsum(np.nan_to_num(shares))])
    chosen = [0]
    for index in range(1, len(expected)):
        if expected[index] - expected[chosen[-1]] >= MIN_SAMPLES_PER_TEST:
            chosen.append(index)
    if len(chosen) <= MIN_BINS_PER_TEST:
        return None
    return np.asarray(chosen)


def jackknifed(
    by_group: Mapping[str, FloatArray],
    quantities: Callable[[Mapping[str, FloatArray]], dict[str, FloatArray]],
) -> dict[str, Measured]:
    """Return quantities that are functions of averages, with their errors.

    The sides of a relation come from the same tracers: their ratio is formed first.

    Parameters
    ----------
    by_group : averages of each group, (n_groups,)
    quantities : maps averages, by name, to quantities, by name
    """
    means: dict[str, FloatArray] = {}
    means_without_group: dict[str, FloatArray] = {}
    for name, groups in by_group.items():
        means[name] = np.asarray(groups.mean())
        means_without_group[name] = (groups.sum() - groups) / (groups.size - 1)
    replicates = quantities(means_without_group)
    estimates: dict[str, Measured] = {}
    for name, value in quantities(means).items():
        estimates[name] = Measured(value, jackknife_error(replicates[name]))
    return estimates

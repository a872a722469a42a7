"""A mean velocity that all times share: a wind, or an offset of the velocities.

Where nothing drives tracers, the mean velocity of an isotropic start is zero, and that of a
directed one dies out. So one that is the same at all times is no part of the theory.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.words import limit_factor

Array = NDArray[np.float64]

#: Times at which a mean velocity must be the same. The origin of the number is not recorded.
MIN_TIMES = 3
#: Groups from which its standard error is known. The origin of the number is not recorded.
MIN_GROUPS = 5
#: Share of all means of data without a drift, in which none is to be found.
SURE = 1.0 - 1e-7
#: Share of the means of one time that differ from that of all times by less, if there is a drift.
ALIKE = 1.0 - 1e-4
#: Largest drift over sqrt(<v^2>) at the first time: a beam that has not collided has 1.
MAX_OVER_SPEED = 0.7


class Drift(NamedTuple):
    """A mean velocity in U and its standard errors, shape (d,)."""

    velocity: Array
    error: Array


def find_drift(velocity: Array, group: NDArray[np.int64]) -> Drift | None:
    """Return the mean velocity that all times share; None if there is none.

    Parameters
    ----------
    velocity : in U, NaN where a tracer is missing, shape (n_times, n, d)
    group : of each tracer, of which groups are independent, shape (n,)
    """
    number, different = np.unique(group, return_inverse=True)[::-1]
    n_groups = different.size
    if velocity.shape[0] < MIN_TIMES or n_groups < MIN_GROUPS:
        return None
    drifts = []
    errors = []
    is_drift = []
    rms_speed = np.sqrt(np.nanmean(np.sum(velocity[0] ** 2, axis=1)))
    for axis in range(velocity.shape[2]):
        component = velocity[:, :, axis]
        is_there = np.isfinite(component)
        sums = np.array([np.bincount(number, row, n_groups) for row in np.nan_to_num(component)])
        counts = np.array([np.bincount(number, row, n_groups) for row in is_there])
        total = counts.sum(axis=1)
        means = sums.sum(axis=1) / total
        # of each group, to the difference of the mean at a time from its expectation
        parts = (sums - counts * means[:, None]) / total[:, None]
        variances = np.sum(parts**2, axis=1) * n_groups / (n_groups - 1)
        if not np.all(variances > 0.0):
            return None
        weights = 1.0 / variances / np.sum(1.0 / variances)
        drift = float(weights @ means)
        error = float(np.sqrt(np.sum((weights @ parts) ** 2) * n_groups / (n_groups - 1)))
        is_constant = np.abs(means - drift) < limit_factor(n_groups, ALIKE) * np.sqrt(variances)
        is_sure = abs(drift) > limit_factor(n_groups, SURE) * error
        is_drift.append(is_sure and bool(np.all(is_constant)))
        drifts.append(drift)
        errors.append(error)
    found = Drift(np.array(drifts), np.array(errors))
    is_fast = np.linalg.norm(found.velocity) > MAX_OVER_SPEED * rms_speed
    return found if any(is_drift) and not is_fast else None

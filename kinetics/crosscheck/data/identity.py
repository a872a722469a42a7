"""Rows without a label of their tracer: whether their order is the same at all times.

Displacements r(s) and r(t) of one tracer from its start are correlated, as what happens after s
does not depend on the place: <r(s) . r(t)> is about <|r(s)|^2>. Those of two tracers are not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.tracks import Tracks

Array = NDArray[np.float64]

#: Share of the rows that belong to one tracer below which their order says nothing.
MIN_SHARE_IN_ORDER = 0.5
#: Standard error of that share above which it cannot be told.
MAX_ERROR = 0.25


def share_in_order(tracks: Tracks) -> float | None:
    """Return the share of rows that have the place of their tracer in the order; None if unknown.

    Parameters
    ----------
    tracks : displacements from the start, of the k-th rows of each time
    """
    place = tracks.place
    mean_squares = np.nanmean(np.sum(place**2, axis=2), axis=1)
    correlation = 0.0
    information = 0.0
    for index in range(tracks.times.size - 1):
        if mean_squares[index] <= 0:
            continue
        products = np.sum(place[index] * place[index + 1], axis=1)
        n = np.count_nonzero(np.isfinite(products))
        if n:
            correlation += n * float(np.nanmean(products)) / mean_squares[index + 1]
            information += n * mean_squares[index] / mean_squares[index + 1]
    if information * place.shape[2] < MAX_ERROR**-2:
        return None
    return correlation / information

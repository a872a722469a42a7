"""How finely the numbers of a file are resolved: what differs by less is the same."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Relative resolution that is assumed at best, of the largest number: single precision has 6e-8,
#: and texts of 7 digits 1e-7. Chosen: ten times these.
BEST_RESOLUTION = 1e-6
#: Numbers from which the resolution is told. The origin of the number is not recorded.
NUMBERS_SAMPLED = 2000
#: Multiples of a decimal place that differ by this fraction of it are whole. The origin of the
#: number is not recorded.
WHOLE_WITHIN = 1e-4


def resolution_of(values: NDArray[Any]) -> float:
    """Return the smallest step of numbers, from their decimals; at least 1e-6 of the largest.

    Steps are powers of ten from that of the largest number on, so that the unit does not matter.
    """
    numbers = values[np.isfinite(values)].ravel()
    finest = BEST_RESOLUTION * float(np.max(np.abs(numbers), initial=0.0))
    sampled = numbers[:: numbers.size // NUMBERS_SAMPLED + 1]
    if not np.any(sampled):
        return finest
    decimals = -math.floor(math.log10(np.max(np.abs(sampled))))
    step = 10.0**-decimals
    while step > finest:
        multiples = sampled / step
        if np.all(np.abs(multiples - np.round(multiples)) < WHOLE_WITHIN):
            return step
        decimals += 1
        step = 10.0**-decimals
    return finest

"""How finely the numbers of a file are resolved: what differs by less is the same."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Relative resolution that is assumed at best, of the largest number: single precision has 6e-8,
#: and texts of 7 digits 1e-7. Chosen: ten times these.
BEST_RESOLUTION = 1e-6
#: Numbers from which the resolution is told.
NUMBERS_SAMPLED = 2000
#: Fewest decimals of a text that are looked for: numbers of pixels in thousands.
FEWEST_DECIMALS = -3
#: Decimals that are not looked for any more: a text with as many is as good as full precision.
MOST_DECIMALS = 8
#: Multiples of a decimal place that differ by this fraction of it are whole.
WHOLE_WITHIN = 1e-4


def resolution_of(values: NDArray[Any]) -> float:
    """Return the smallest step of numbers, from their decimals; at least 1e-6 of the largest."""
    numbers = values[np.isfinite(values)].ravel()
    if numbers.size == 0:
        return 0.0
    finest = BEST_RESOLUTION * float(np.max(np.abs(numbers)))
    sampled = numbers[:: numbers.size // NUMBERS_SAMPLED + 1]
    for decimals in range(FEWEST_DECIMALS, MOST_DECIMALS):
        step = 10.0**-decimals
        if step <= finest:
            break
        multiples = sampled / step
        if np.all(np.abs(multiples - np.round(multiples)) < WHOLE_WITHIN):
            return step
    return finest

r"""The principal solution of G(z+1) = r(z) G(z): the one that grows least (Noerlund).

Far to the right ln r is smooth, and by Euler and Maclaurin, with the Bernoulli numbers B_2j,

    ln G(b) - ln G(a) = integral of ln r from a to b - [ln r(b) - ln r(a)]/2
                        + sum over j of B_2j/(2j)! [(ln r)^(2j-1)(b) - (ln r)^(2j-1)(a)]

From there the recurrence itself leads to any other z.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

# B_2j/(2j), j = 1, 2, ...: the factor of the Taylor coefficient of order 2j - 1, which holds the
# factorial (DLMF 24.2.1)
_BERNOULLI = (1 / 12, -1 / 120, 1 / 252, -1 / 240, 1 / 132, -691 / 32760)
MOST_ORDERS = 2 * len(_BERNOULLI)


def log_growth(
    integral: NDArray[Any], begin: Sequence[Any], end: Sequence[NDArray[Any]]
) -> NDArray[Any]:
    """ln G(b) - ln G(a) where ln r is smooth, shape of the integral.

    integral : of ln r from a to b
    begin, end : Taylor coefficients of ln r at a and at b, from order 0 on, an even number up to
        `MOST_ORDERS`. Where ln r varies as ln z does, and |z| >= N, n of them leave about
        2 n!/((2 pi)^(n+2) N^(n+1))
    """
    value = integral - 0.5 * (end[0] - begin[0])
    for number, high, low in zip(_BERNOULLI, end[1::2], begin[1::2], strict=False):
        value = value + number * (high - low)
    return np.asarray(value)


def taylor_of_log(c: Sequence[NDArray[Any]]) -> list[NDArray[Any]]:
    """Taylor coefficients of the logarithm of a function with the coefficients c, each (n,)."""
    a = np.stack(c[1:]) / c[0]
    slope = np.empty_like(a)  # n d_n in row n - 1
    for n in range(len(a)):
        slope[n] = (n + 1) * a[n] - (slope[:n] * a[n - 1 :: -1][:n]).sum(axis=0)
    return [np.log(c[0]), *(row / (n + 1) for n, row in enumerate(slope))]

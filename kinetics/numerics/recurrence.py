r"""The principal solution of G(z+1) = r(z) G(z): the one that grows least (Noerlund).

Far to the right ln r is smooth, and by Euler and Maclaurin, with the Bernoulli numbers B_2j,

    ln G(b) - ln G(a) = integral of ln r from a to b - [ln r(b) - ln r(a)]/2
                        + sum over j of B_2j/(2j)! [(ln r)^(2j-1)(b) - (ln r)^(2j-1)(a)]

From there the recurrence itself leads to any other z. Begin with `log_growth`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetics.numerics import NumberArray

#: B_2j/(2j), j = 1, 2, ...: the factor of the Taylor coefficient of order 2j - 1, which holds the
#: factorial (DLMF 24.2.1).
BERNOULLI_FACTORS = np.array([1 / 12, -1 / 120, 1 / 252, -1 / 240, 1 / 132, -691 / 32760])
#: Most Taylor coefficients that `log_growth` can use.
MOST_ORDERS = 2 * len(BERNOULLI_FACTORS)


def log_growth(
    integral: NumberArray, begin: Sequence[NumberArray], end: Sequence[NumberArray]
) -> NumberArray:
    """Return ln G(b) - ln G(a) where ln r is smooth, shape of the integral.

    Parameters
    ----------
    integral : of ln r from a to b
    begin, end : Taylor coefficients of ln r at a and at b, from order 0 on, an even number up to
        `MOST_ORDERS`. Where ln r varies as ln z does, and |z| >= N, n of them leave about
        2 n!/((2 pi)^(n+2) N^(n+1))
    """
    value = integral - 0.5 * (end[0] - begin[0])
    odd_orders = zip(BERNOULLI_FACTORS.tolist(), end[1::2], begin[1::2], strict=False)
    for factor, at_end, at_begin in odd_orders:
        value = value + factor * (at_end - at_begin)
    return np.asarray(value)


def taylor_of_log(c: Sequence[NumberArray]) -> list[NumberArray]:
    """Return Taylor coefficients of the logarithm of a function with the coefficients c, each (n,).

    With a_n = c_n/c_0 and d_n those of the logarithm, n d_n = n a_n - sum_j j d_j a_(n-j), j < n.
    """
    a = np.stack(c[1:]) / c[0]
    slope = np.empty_like(a)  # n d_n in row n - 1
    for n in range(len(a)):
        products = slope[:n] * a[n - 1 :: -1][:n]
        slope[n] = (n + 1) * a[n] - products.sum(axis=0)
    logarithm = [np.log(c[0])]
    for n, row in enumerate(slope, start=1):
        logarithm.append(row / n)
    return logarithm

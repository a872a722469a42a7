"""Numerical methods without physics; imports nothing of this project. Begin with `chebyshev`.

- `chebyshev`: polynomials through Chebyshev points, on one interval and on equal panels
- `panel_shifts`: averages of f(x - shift) over many shifts, on equal panels
- `blocks`: equations of many blocks, each of which is coupled to its neighbours
- `gauss`: Gauss-Legendre quadrature
- `log_grid`: equidistant nodes in the logarithm of the speed, and Fourier sums on them
- `refinement`: finer resolutions until two of them agree
- `recurrence`: solutions of G(z+1) = r(z) G(z)
- `cache`: results that are kept, for threads
"""

import math
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

#: The relative spacing of doubles, 2.2e-16.
ROUNDING = float(np.finfo(float).eps)
#: e-folds after which nothing is left beside 1: 40, as e^-40 = 4e-18.
FOLDS = 4.0 - math.log(ROUNDING)
#: ln of the largest double, 709.8: e to more than that overflows.
LARGEST_LOG = math.log(float(np.finfo(float).max))

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
#: Real or complex numbers.
NumberArray = NDArray[np.inexact[Any]]

P = ParamSpec("P")
T = TypeVar("T")


def one_blas_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function so that, while it runs, BLAS uses one thread in the whole process.

    More would wait for each other: the matrices of a solve are small. Finding the libraries takes
    about a millisecond: for functions that take much longer.
    """

    @wraps(function)
    def limited(*arguments: P.args, **keywords: P.kwargs) -> T:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return function(*arguments, **keywords)

    return limited

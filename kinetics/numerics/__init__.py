"""Numerical methods without physics.

- `chebyshev`: polynomials through Chebyshev points; `panels`: many of them side by side
- `blocks`: equations of many blocks, each of which knows its neighbours
- `gauss`: Gauss-Legendre quadrature
- `log_grid`: equidistant nodes in the logarithm of the speed, and Fourier sums on them
- `recurrence`: solutions of G(z+1) = r(z) G(z)

Imports nothing of this project. Begin with `chebyshev.py`.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

"""What the solvers of driven tracers need of an axis of speeds: one protocol.

A function of the speed is stored by its values at nodes, and means the polynomial, or polynomials
on panels, through them. A distribution is stored by the averages over it of the polynomials that
are 1 at one node and 0 at the others. Two axes implement it:

- `kinetics.driven.panels.SpeedPanels`: polynomials on panels, which need not be continuous
- `kinetics.driven.chebyshev_axis.ChebyshevSpeedAxis`: polynomials in one smooth variable
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from numpy.typing import NDArray

from kinetics.numerics import FloatArray


class VelocityAxis(Protocol):
    """Nodes from rest to a highest speed, and polynomials through values at them.

    The parity, 0 or 1, is that of the harmonic: harmonic m of a smooth function of the velocity is
    an even or an odd function of the speed, as m is. An axis may make use of it.
    """

    @property
    def size(self) -> int:
        """The number of nodes."""

    @property
    def highest(self) -> float:
        """The highest speed."""

    @property
    def speeds(self) -> FloatArray:
        """The nodes, rising, shape (size,)."""

    def interpolation(self, v: FloatArray, parity: int = 0) -> FloatArray:
        """Return the rows that take values at the nodes to those at speeds v (n,), (n, size)."""

    def averaged(
        self, density: Callable[[FloatArray], NDArray[Any]], parity: int, kinks: FloatArray
    ) -> NDArray[Any]:
        """Return the averages of the polynomial of each node over a density of the speed, (size,).

        Parameters
        ----------
        density : of the speed, real or complex; a function of speeds (n,)
        parity : of the harmonic
        kinks : speeds at which the density is not smooth
        """

"""The unknowns of the backward equation (`backward`), and what drives each of them.

Most are averages of one power of the speed or of the displacement; lengths are in mean free paths.
The displacement r enters by its harmonics: what a tracer has moved along its first direction drives
r^2, and so on, so that each observable is driven by simpler ones. v is the speed, phi the direction
of the velocity, T = v t/l and X = ln T. Begin with `Observable`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Observable:
    """One unknown of the backward equation, y(X) with dy/dX = p y + T (collisions + sources).

    Parameters
    ----------
    degree : p, the power of the speed by which it scales
    harmonic : m, its angular harmonic
    constant : the part of the sources that does not depend on X
    sources : pairs of a factor and an observable; the factor times it is a part of the sources
    growth : late, y is a polynomial of this degree in X = ln T, 0 to 2; in T where speeds are kept
    """

    degree: float = 0.0
    harmonic: int = 0
    constant: float = 0.0
    sources: tuple[tuple[float, Observable], ...] = ()
    growth: int = 1

    @property
    def is_power(self) -> bool:
        """Whether it is a power of the speed, times exp(-i m phi): then nothing drives it."""
        return not (self.sources or self.constant)


def speed_power(p: float, harmonic: int = 0) -> Observable:
    """Return v^p cos(m (phi - phi_0)), phi_0 the initial direction."""
    return Observable(degree=p, harmonic=harmonic, growth=0)


#: The number of collisions: each free path adds one.
MEAN_COLLISIONS = Observable(constant=1.0)
#: The displacement along the initial direction, in l.
DISPLACEMENT_ALONG_START = Observable(harmonic=1, constant=1.0)
#: r^2, in l^2: d<r^2> = 2 <r.v> dt, seen backwards.
SQUARED_DISPLACEMENT = Observable(sources=((2.0, DISPLACEMENT_ALONG_START),))
#: d r^2/d ln t, in l^2: driven by the velocity along the initial direction.
MSD_SLOPE = Observable(degree=1.0, sources=((2.0, speed_power(1.0, 1)),), growth=0)


def quartic_displacement(dimension: int) -> Observable:
    """Return r^4, in l^4: <exp(i k.r)> to the fourth order in k, by harmonics.

    With y_1 the displacement along the start and y_2 = r^2, the harmonic 2 of the second order is
    driven by y_1, the harmonic 1 of the third order by y_2 and by that, and r^4 by the latter. The
    factors come from the coupling of neighbouring harmonics, in the plane or in space.
    """
    if dimension == 2:
        second_from_first = 0.25
        third_from_square = -0.125
        third_from_second = -0.5
        quartic_from_third = -64.0
    else:
        second_from_first = 2.0 / 3.0
        third_from_square = 1.0 / 6.0
        third_from_second = 0.4
        quartic_from_third = 40.0
    second = Observable(harmonic=2, sources=((second_from_first, DISPLACEMENT_ALONG_START),))
    sources_of_third = ((third_from_square, SQUARED_DISPLACEMENT), (third_from_second, second))
    third = Observable(harmonic=1, sources=sources_of_third)
    return Observable(sources=((quartic_from_third, third),), growth=2)

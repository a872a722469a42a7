"""How finely driven tracers are resolved: on panels of speeds, and on one smooth variable.

A first resolution need only be often enough: `kinetics.numerics.refinement` takes finer ones until
two solutions agree. Numbers of nodes and harmonics grow with the digits that are asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinetics.drive import Drive

#: Fewest nodes of a panel: v^4 (1 - v t) is a polynomial on it.
MIN_PANEL_NODES = 6
#: Least rtol that the first resolution of a steady state is made for; rounding is of this size.
MIN_RTOL_OF_STEADY_STATE = 1e-12
#: Least rtol that the first resolution over time is made for: more takes a minute.
MIN_RTOL_OVER_TIME = 1e-7


def digits_of(rtol: float, min_rtol: float) -> float:
    """Return the decimal digits of a relative tolerance, not more than those of `min_rtol`."""
    return -math.log10(max(rtol, min_rtol))


@dataclass(frozen=True)
class Growth:
    """A number that grows with the decimal digits that are asked for.

    Parameters
    ----------
    base : at no digit
    per_digit, per_squared_digit : what a digit, and its square, add
    """

    base: float
    per_digit: float = 0.0
    per_squared_digit: float = 0.0

    def at(self, digits: float) -> float:
        """Return the number for so many digits."""
        return self.base + self.per_digit * digits + self.per_squared_digit * digits**2


# The numbers of the first resolutions. They came with commits f03ecfc4 and 07d85ecc. Chosen: one
# that is too small costs one more solution, one that is too large time. Steady states are as
# accurate and as fast without `MIN_SPAN`, `MIN_SPAN_IN_BATH` and `MIN_COUPLED` (24 random drives,
# rtol 1e-4 to 1e-6); over short times, where the span is small, this was not measured.

# -- panels: a field alone, over time, and the density of its steady state
#: Nodes of a panel for the density of the steady state.
PANEL_NODES_OF_STEADY_STATE = Growth(4.4, per_digit=0.85)
#: Nodes of a panel over time.
PANEL_NODES_OVER_TIME = Growth(2.5, per_digit=1.3)
#: Length of the first panel of the steady state without a digit, of the usual speed.
FIRST_PANEL_OF_STEADY_STATE = 0.35
#: The same over time.
FIRST_PANEL_OVER_TIME = 0.6
#: So many digits make the first panel a tenth.
DIGITS_PER_DECADE = 6.0
#: Digits for which harmonics over time are counted, at least; there are two for each digit.
MIN_DIGITS_OF_HARMONICS = 4.0
#: What steps over time may miss, over the tolerance.
STEP_OVER_TOLERANCE = 2.0

# -- one smooth variable: a field alone
#: Nodes where a field alone drives.
NODES_IN_FIELD = Growth(6.0, per_digit=2.5)
#: Harmonics that such a field, or one that outweighs other drives, couples.
HARMONICS_IN_FIELD = Growth(4.0, per_squared_digit=0.25)

# -- one smooth variable: other drives
#: Nodes where nothing drives.
NODES_UNDRIVEN = Growth(20.0, per_digit=5.0)
#: Nodes in a bath, beside those of the span of the axis.
MIN_NODES_IN_BATH = 6.0
#: Nodes in a bath for each unit of the span.
NODES_PER_SPAN_IN_BATH = Growth(0.0, per_digit=0.45)
#: The same with a field.
NODES_PER_SPAN_IN_BATH_AND_FIELD = Growth(0.0, per_squared_digit=0.1)
#: The span of the axis is asinh(top speed/scale); so much of it is counted in a bath, at least.
MIN_SPAN_IN_BATH = 2.5
#: Nodes without a bath, beside those of the span of the axis.
MIN_NODES = 8.0
#: Nodes without a bath for each unit of the span.
NODES_PER_SPAN = Growth(0.0, per_digit=0.8)
#: So much of the span is counted without a bath, at least.
MIN_SPAN = 3.0
#: Harmonics that a weak field couples, beside those of the digits.
MIN_COUPLED = 2.0
#: Harmonics that a weak field couples for each digit.
COUPLED_PER_DIGIT = 0.6
#: So many more for sqrt(field) over the scale of the speed.
COUPLED_PER_DIGIT_AND_FIELD = 0.4
#: Points of the quadrature over impacts in a field.
POINTS_WITH_FIELD = Growth(14.0, per_squared_digit=0.26)
#: The same without a field.
POINTS_WITHOUT_FIELD = Growth(6.0, per_digit=2.4)


@dataclass(frozen=True)
class PanelResolution:
    """How finely the velocity, and the time, are resolved where a field alone drives.

    Parameters
    ----------
    nodes : of a panel of speeds
    harmonics : M, odd; harmonics 0 ... M are solved
    lowest : the first panel is so long, of the usual speed
    rtol : what speeds above the highest, and a step of time, may miss
    step : the first step of time, over the longest: a finer solution has others
    """

    nodes: int
    harmonics: int
    lowest: float
    rtol: float
    step: float = 1.0

    @classmethod
    def steady(cls, rtol: float, harmonics: int) -> PanelResolution:
        """Return one for the density of the steady state.

        harmonics : as many as averages need
        """
        digits = digits_of(rtol, MIN_RTOL_OF_STEADY_STATE)
        nodes = max(math.ceil(PANEL_NODES_OF_STEADY_STATE.at(digits)), MIN_PANEL_NODES)
        return cls(
            nodes=nodes,
            harmonics=harmonics | 1,
            lowest=FIRST_PANEL_OF_STEADY_STATE * 10.0 ** (-digits / DIGITS_PER_DECADE),
            rtol=10.0**-digits,
        )

    @classmethod
    def over_time(cls, rtol: float) -> PanelResolution:
        """Return a first one for averages and densities over time."""
        digits = digits_of(rtol, MIN_RTOL_OVER_TIME)
        nodes = max(math.ceil(PANEL_NODES_OVER_TIME.at(digits)), MIN_PANEL_NODES)
        return cls(
            nodes=nodes,
            harmonics=2 * math.ceil(max(digits, MIN_DIGITS_OF_HARMONICS)) - 1,
            lowest=FIRST_PANEL_OVER_TIME * 10.0 ** (-digits / DIGITS_PER_DECADE),
            rtol=STEP_OVER_TOLERANCE * 10.0**-digits,
        )

    @property
    def finer(self) -> PanelResolution:
        """The next one, with more nodes and harmonics, and shorter steps.

        Nodes grow fastest: of a start of one speed, or from rest, averages miss what a polynomial
        misses at one point, and four more nodes leave a tenth of that.
        """
        return PanelResolution(
            nodes=self.nodes + 4,
            harmonics=self.harmonics + 2 * math.ceil(self.harmonics / 6),
            lowest=0.7 * self.lowest,
            rtol=0.1 * self.rtol,
            step=0.7 * self.step,
        )


#: Most nodes of a solution on one smooth variable: some seconds.
MAX_AXIS_NODES = 180
#: Most harmonics of such a solution: some seconds.
MAX_COUPLED_HARMONICS = 70
#: The first solution has so few nodes, at most, that one finer solution is left.
MAX_FIRST_NODES = 0.8 * MAX_AXIS_NODES - 4.0
#: The same for harmonics.
MAX_FIRST_HARMONICS = 4 * MAX_COUPLED_HARMONICS // 5 - 2


@dataclass(frozen=True)
class ChebyshevResolution:
    """How finely the velocity is resolved on an axis of one smooth variable.

    Parameters
    ----------
    nodes : of the speed axis
    points : of the quadrature over the impact, in each of its two directions
    harmonics : M; harmonics 0 ... M are solved
    rtol : what speeds above the top, and a step of time, may miss
    """

    nodes: int
    points: int
    harmonics: int
    rtol: float

    @classmethod
    def first(
        cls, drive: Drive, rtol: float, span: float, harmonics: int = 1
    ) -> ChebyshevResolution:
        """Return one that is often enough.

        Parameters
        ----------
        drive : in units of l
        rtol : relative tolerance
        span : asinh of the highest speed over the scale of the axis
        harmonics : as many as the outputs need
        """
        digits = digits_of(rtol, MIN_RTOL_OF_STEADY_STATE)
        if drive.only_falls:
            return cls._first_in_field(digits)
        nodes = min(_first_nodes(drive, digits, span), MAX_FIRST_NODES)
        coupled = min(_first_coupled_harmonics(drive, digits), MAX_FIRST_HARMONICS)
        return cls(
            nodes=math.ceil(nodes),
            points=_first_points(drive, digits),
            harmonics=max(harmonics, math.ceil(coupled)),
            rtol=10.0**-digits,
        )

    @classmethod
    def _first_in_field(cls, digits: float) -> ChebyshevResolution:
        """Return the first resolution where a field alone drives."""
        return cls(
            nodes=math.ceil(NODES_IN_FIELD.at(digits)),
            points=0,
            harmonics=min(math.ceil(HARMONICS_IN_FIELD.at(digits)), MAX_FIRST_HARMONICS),
            rtol=10.0**-digits,
        )

    @property
    def finer(self) -> ChebyshevResolution | None:
        """The next one, with harmonics only where a field couples them; None at the end."""
        nodes = self.nodes + self.nodes // 5 + 3
        points = self.points + self.points // 5 + 3
        harmonics = self.harmonics
        if harmonics >= 3:
            harmonics += harmonics // 4 + 2
        if nodes > MAX_AXIS_NODES or harmonics > MAX_COUPLED_HARMONICS:
            return None
        return ChebyshevResolution(nodes, points, harmonics, 0.2 * self.rtol)

    @property
    def coarser(self) -> ChebyshevResolution:
        """One with four fifths of everything, to compare with."""
        return ChebyshevResolution(
            nodes=4 * self.nodes // 5,
            points=4 * self.points // 5,
            harmonics=max(4 * self.harmonics // 5, min(self.harmonics, 1)),
            rtol=5.0 * self.rtol,
        )


def _first_nodes(drive: Drive, digits: float, span: float) -> float:
    """Return how many nodes the first axis of speeds needs."""
    if not drive.is_driven:
        return NODES_UNDRIVEN.at(digits)
    if not drive.bath_speed:
        return MIN_NODES + NODES_PER_SPAN.at(digits) * max(span, MIN_SPAN)
    per_span = NODES_PER_SPAN_IN_BATH_AND_FIELD if drive.field else NODES_PER_SPAN_IN_BATH
    return MIN_NODES_IN_BATH + per_span.at(digits) * max(span, MIN_SPAN_IN_BATH)


def _first_coupled_harmonics(drive: Drive, digits: float) -> float:
    """Return how many harmonics a field couples; 0 without a field."""
    if drive.is_field_dominated:
        return HARMONICS_IN_FIELD.at(digits)
    if not drive.field:
        return 0.0
    relative_field = math.sqrt(drive.field) / drive.scale
    per_digit = COUPLED_PER_DIGIT + COUPLED_PER_DIGIT_AND_FIELD * relative_field
    return MIN_COUPLED + per_digit * digits


def _first_points(drive: Drive, digits: float) -> int:
    """Return how many points the first quadrature over impacts needs, in each direction."""
    points = POINTS_WITH_FIELD if drive.field else POINTS_WITHOUT_FIELD
    return math.ceil(points.at(digits))

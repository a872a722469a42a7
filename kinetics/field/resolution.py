"""Which panels, nodes and harmonics are needed for a relative accuracy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from kinetics.collision import CollisionLaw
from kinetics.field.panels import SpeedPanels

# Low panels: each `_RATIO` times as long as the one below. There f is as smooth as v^2 ln v is, and
# its Legendre coefficients fall as _DECAY^-n.
_RATIO = 5.0
_DECAY = (math.sqrt(_RATIO) + 1.0) ** 2 / (_RATIO - 1.0)
_BEST = 1e-12  # accuracy for which panels are made at first
_ACCURATE = 1e-10  # rtol at which panels for more than that are enough at low e
_FEWEST = 4  # nodes of a panel
_TOP_PANELS = 2  # where f falls
SMALL_RATIO = 1e-3  # speed ratio below which averages of v^-2 are not resolved
_FIRST_PANEL = 1e3  # by this much f may vary on the first panel, in units of the accuracy


@dataclass(frozen=True)
class TimeResolution:
    """How finely the averages are resolved.

    Parameters
    ----------
    nodes : of a panel of speeds
    harmonics : M, odd
    lowest : the first panel is about so long
    rtol : what a step of time may miss
    """

    nodes: int
    harmonics: int
    lowest: float
    rtol: float

    @classmethod
    def of(cls, rtol: float) -> TimeResolution:
        """A first one, whose error its finer one shows, for a relative accuracy."""
        digits = -math.log10(max(rtol, 1e-12))
        harmonics = 2 * math.ceil(max(digits, 4.0)) - 1
        nodes = math.ceil(1.5 * digits + 1.0)
        return cls(max(nodes, 6), harmonics, 0.6 * 10 ** (-digits / 6.0), rtol)

    @classmethod
    def for_densities(cls, rtol: float) -> TimeResolution:
        """A first one for densities: what M harmonics leave of them falls as M^-7."""
        digits = -math.log10(max(rtol, 1e-12))
        harmonics = 2 * math.ceil(7.0 * 10.0 ** ((digits - 6.0) / 7.0)) + 1
        return cls(max(math.ceil(1.5 * digits + 1.0), 6), max(harmonics, 7), 0.1, 0.2 * rtol)

    def finer(self) -> TimeResolution:
        """With half as many harmonics again, some more nodes and shorter steps."""
        harmonics = self.harmonics + 2 * math.ceil(self.harmonics / 4)
        return TimeResolution(self.nodes + 2, harmonics, 0.7 * self.lowest, 0.2 * self.rtol)


@dataclass(frozen=True)
class Resolution:
    """How finely the steady state is resolved.

    Parameters
    ----------
    speed : accuracy for which the panels of the speed are made
    harmonics : M, odd; harmonics 0 ... M are solved
    """

    speed: float
    harmonics: int = 7

    @classmethod
    def first(cls, law: CollisionLaw, rtol: float) -> Resolution:
        """Speeds that serve most laws; the error estimates see what they miss.

        At low e coarse panels miss more than they are made for, and fine ones a hundredth of it;
        but not where a bounce may nearly stop a tracer.
        """
        s, rtol = smallest_ratio(law), max(rtol, _BEST)
        if s > 0.2:
            return cls(rtol)
        return cls((5.0 if rtol <= _ACCURATE and not 0.0 < s < SMALL_RATIO else 0.1) * rtol)

    def finer_speeds(self) -> Resolution:
        """With panels for a tenth of the error."""
        return replace(self, speed=0.1 * self.speed)

    def powers(self, law: CollisionLaw) -> tuple[tuple[float, float], ...]:
        """Powers of 1/m by which the last harmonics are continued, and two others to compare with.

        f_m falls as m^-3 in the end, but as 1/m where a bounce may nearly stop a tracer: up to
        m of about the inverse of the smallest speed ratio.
        """
        if smallest_ratio(law) * self.harmonics < 1.0:
            return (1.0, 3.0), (1.0, 2.0), (1.0, 5.0)
        return (2.0, 4.0), (1.0, 3.0), (4.0, 6.0)

    def panels(self, law: CollisionLaw) -> SpeedPanels:
        """The speed axis: panels that grow by a factor up to where f falls, then equal ones."""
        highest = highest_speed(law, self.speed)
        edges = [highest / 8.0]
        counts: list[int] = []
        s = smallest_ratio(law)
        while True:
            low = edges[0] / _RATIO
            varies = _share(low, s, self.speed)
            if varies < self.speed * _FIRST_PANEL and low < 0.1:
                break
            wanted = math.log(varies * _RATIO**2 / self.speed) / math.log(_DECAY)
            counts.insert(0, max(_FEWEST, math.ceil(wanted)))
            edges.insert(0, low)
        counts.insert(0, max(_FEWEST, counts[0] - 1))
        width = (highest - edges[-1]) / _TOP_PANELS
        top = [edges[-1] + width * (j + 1.0) for j in range(_TOP_PANELS)]
        nodes = math.ceil(6.0 - 3.0 * math.log10(self.speed))
        return SpeedPanels((0.0, *edges, *top), (*counts, *[nodes] * _TOP_PANELS))


def _share(v: float, s: float, accuracy: float) -> float:
    """The share in the averages of what a panel from v on must resolve; s the least speed ratio.

    Below s, f varies as v^2/s^2 ln v, and above it, if s is small, as ln v. What stops tracers
    nearly is a source at rest, of which panels of a length v see a share v.
    """
    if s > SMALL_RATIO:
        return min(1.0, (v / s) ** 2)
    if s < 10.0 * accuracy:
        return min(1.0, v * v)
    return min(1.0, v * min(1.0, v / s))


def smallest_ratio(law: CollisionLaw) -> float:
    """The smallest speed ratio of a bounce."""
    return math.exp(-law.largest_loss)


def highest_speed(law: CollisionLaw, accuracy: float) -> float:
    """The speed above which f is negligible.

    Nearly elastic tracers have f = exp(-a v^4) with a = d kappa lambda_1(0)/4, up to the speed
    where the free fall exp(-v^2/2) is slower.
    """
    loss = float(law.harmonic_decay_rate(0.0, 1))
    a = 0.25 * law.dimension * law.mean_log_loss * loss
    fall = math.log(1.0 / accuracy) + 11.0
    if 16.0 * a * fall < 1.0:
        return (fall / a) ** 0.25
    return math.sqrt(2.0 * fall + 0.25 / a)

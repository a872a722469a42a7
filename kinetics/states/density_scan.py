"""A coarse look at a speed density, from the slowest to the fastest speed in doubles.

v is the speed and U its unit. The scan finds where the density is, how far averages of powers of
the speed reach, and whether they exist; :mod:`kinetics.states.function_points` then integrates
there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetics.errors import InputError
from kinetics.numerics import LARGEST_LOG, FloatArray, NumberArray
from kinetics.numerics.gauss import panels_of
from kinetics.states.halved_panels import ScannedPanels

#: Width in ln v of the panels on which a function of the speed is scanned. Chosen: half of it takes
#: twice as many evaluations, twice half as many, but parts that find narrow peaks are wider then.
SCAN_PANEL = 0.5
#: Equal parts of such a panel that are integrated one by one; a power of two, as panels are halved.
#: Chosen: at half and at twice no average of a smooth density moves (rtol 1e-8).
SCAN_PARTS = 8
#: Up to which |ln(v/U)|, how many Gauss points a part gets. Chosen: near U, where densities are,
#: peaks 0.1 % wide are seen; beyond e^70 only power laws matter. Fewer points than 8 everywhere.
SCAN_ZONES = ((16.0, 64), (70.0, 8), (math.inf, 2))
#: Parts that a closer scan has near U in place of each of SCAN_PARTS; a power of two. Chosen: it
#: sees peaks 0.001 % wide in some tenths of a second.
CLOSER_SCAN_FACTOR = 128
#: e-folds above its bulk to which a density that has a power-law tail goes on. Chosen; at half and
#: at twice nothing moves for a density without such a tail.
TAIL_LENGTH = 60.0
#: An average diverges if one of the last panels adds more than this of what the largest one adds.
#: Chosen: what converges has fallen far below by then.
DIVERGENT_SHARE = 1e-3
#: Panels count that add more than this times rtol to an average: a thousand add up to rtol. Chosen;
#: at half and at twice no average of a smooth density moves (rtol 1e-8).
SHARE_THAT_COUNTS = 1e-3
#: Panels beside those that count which are kept. What is left out falls from panel to panel.
#: Chosen: with 1 and with 4 averages of a smooth density move by 1e-12 (rtol 1e-8).
PANELS_BESIDE = 2
#: ln of the least term of a sum: exp underflows at -708.
LEAST_LOG = -700.0

#: The message that refuses a density without a finite integral.
NO_INTEGRAL = (
    "initial: the density has no finite integral over the speed, or a peak too narrow to find; "
    "it must be 1, and narrow peaks need a SpeedTable"
)


@dataclass(frozen=True, eq=False)
class DensityScan:
    """A function of ln v, integrated over equal panels; begin with `of`.

    Parameters
    ----------
    edges : of the panels in ln v, shape (n_panels + 1,)
    mass : integral of the absolute value over each panel, shape (n_panels,)
    parts : integral over equal parts of each panel, SCAN_PARTS of them, in a closer scan
        CLOSER_SCAN_FACTOR times as many, shape (n_panels, n_parts); NaN where the scan is too
        coarse to know it
    """

    edges: FloatArray
    mass: FloatArray
    parts: NumberArray

    @classmethod
    def of(cls, function: Callable[[FloatArray], NumberArray], is_closer: bool) -> DensityScan:
        """Scan a function of ln v; InputError where its integral is not finite.

        is_closer : whether narrow peaks near U are looked for
        """
        # from the least number of which the square is in the range of doubles to the largest
        first_edge = -0.5 * LARGEST_LOG // SCAN_PANEL
        last_edge = LARGEST_LOG // SCAN_PANEL
        edges = SCAN_PANEL * np.arange(first_edge, last_edge)
        distance = np.minimum(abs(edges[:-1]), abs(edges[1:]))
        mass = np.zeros(distance.size)
        n_parts_near = SCAN_PARTS * CLOSER_SCAN_FACTOR if is_closer else SCAN_PARTS
        parts: NumberArray = np.full((distance.size, n_parts_near), np.nan)
        nearest = 0.0
        for farthest, points_of_part in SCAN_ZONES:
            zone = np.nonzero((distance >= nearest) & (distance < farthest))[0]
            is_near = nearest == 0.0
            n_parts = n_parts_near if is_near else SCAN_PARTS
            # a closer scan takes one panel at a time: all at once need much memory
            groups = np.split(zone, zone.size) if is_near and is_closer else [zone]
            for panels in groups:
                mass[panels], integrals = _scan_panels(
                    function, edges[panels], n_parts, points_of_part
                )
                if is_near:  # elsewhere the scan is too coarse
                    parts = parts.astype(np.result_type(parts, integrals), copy=False)
                    parts[panels] = integrals
            nearest = farthest
        if not np.all(np.isfinite(mass)):
            raise InputError(NO_INTEGRAL)
        return cls(edges, mass, parts)

    @property
    def is_zero(self) -> bool:
        """Whether the function is zero everywhere."""
        return not self.mass.any()

    @property
    def _last_panel(self) -> int:
        """The last panel in which the function is not zero."""
        return int(np.nonzero(self.mass)[0][-1])

    @property
    def has_power_law_tail(self) -> bool:
        """Whether the function goes on far above its bulk, perhaps until numbers end."""
        bulk = int(self.mass.argmax())
        return bool(self.edges[self._last_panel] - self.edges[bulk] > TAIL_LENGTH)

    def _log_terms(self, power: float) -> FloatArray:
        """Return ln of what each panel adds to the average of v^power, (n_panels,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.mass) + power * 0.5 * (self.edges[1:] + self.edges[:-1]))

    def _shares(self, power: float, log_average: float) -> FloatArray:
        """Return what each panel adds to the average of v^power, relative to it, (n_panels,)."""
        return np.asarray(np.exp(np.maximum(self._log_terms(power) - log_average, LEAST_LOG)))

    def log_averages(self, powers: list[float]) -> list[float]:
        """Return ln of the integral of the absolute value times v^p, for each power p."""
        logs = []
        for power in powers:
            terms = self._log_terms(power)
            largest = float(terms.max())
            total = float(np.exp(np.maximum(terms - largest, LEAST_LOG)).sum())
            logs.append(largest + math.log(total))
        return logs

    def refuse_divergent(self, powers: list[float], log_averages: list[float]) -> None:
        """Raise InputError for a power p >= 2 to whose average the last panels add much."""
        last_panels = slice(self._last_panel - 2, self._last_panel + 1)
        for power, log_average in zip(powers, log_averages, strict=True):
            shares = self._shares(power, log_average)
            share_at_end = shares[last_panels].max()
            if power >= 2.0 and share_at_end >= DIVERGENT_SHARE * shares.max():
                raise InputError(
                    f"initial: <v^{power:g}> of the density does not exist, and it is needed"
                )

    def panels_that_count(
        self, powers: list[float], log_averages: list[float], rtol: float
    ) -> ScannedPanels:
        """Return the panels that the average of any of the powers notices, and a few beside."""
        counts = np.zeros(self.mass.shape, dtype=bool)
        for power, log_average in zip(powers, log_averages, strict=True):
            counts |= self._shares(power, log_average) > SHARE_THAT_COUNTS * rtol
        panels = np.nonzero(counts)[0]
        begin = max(panels[0] - PANELS_BESIDE, 0)
        end = min(panels[-1] + PANELS_BESIDE + 1, counts.size)
        ends = np.stack([self.edges[:-1], self.edges[1:]], axis=1)
        return ScannedPanels(ends[begin:end], self.parts[begin:end])


def _scan_panels(
    function: Callable[[FloatArray], NumberArray],
    begins: FloatArray,
    n_parts: int,
    points_of_part: int,
) -> tuple[FloatArray, NumberArray]:
    """Return the integrals of the absolute value over panels, (n,), and over parts, (n, n_parts).

    begins : of the panels, shape (n,)
    """
    offsets = np.linspace(0.0, SCAN_PANEL, n_parts + 1)
    begins_of_parts = begins[:, None] + offsets[:-1]
    ends_of_parts = begins[:, None] + offsets[1:]
    ends = np.stack([begins_of_parts, ends_of_parts], axis=2).reshape(-1, 2)
    x, w = panels_of(ends, points_of_part)
    values = function(x.ravel()).reshape(x.shape)
    with np.errstate(all="ignore"):
        mass = (np.abs(values) * w).reshape(begins.size, -1).sum(axis=1)
        parts = (values * w).sum(axis=1).reshape(begins.size, n_parts)
    return mass, parts

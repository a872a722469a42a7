"""Integration of a function that may have steps, kinks and infinities, by panels that are halved.

Begin with `integrate_by_halving`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinetics.numerics import ROUNDING, FloatArray, NumberArray
from kinetics.numerics.chebyshev import barycentric_weights, interpolation_rows
from kinetics.numerics.gauss import gauss_legendre, panels_of

#: Gauss points of a panel, or of a half of one. Chosen; with 8 an inverse square root is 1e-5 off
#: in place of 1e-8, with 24 smooth densities get twice as many points.
POINTS = 12
#: Half the width in ln v of the narrowest panel: a thousand roundings of ln v of order 1. Chosen.
NARROWEST = 1e3 * ROUNDING
#: Panels halved at once beyond which a density counts as noise. Chosen; time and points until then
#: are in proportion: 15 ms and 130,000 points.
MAX_PANELS = 5000
#: Error over the difference of 12 and 24 points where panels cannot be halved. Derived for an
#: inverse square root at the end of a panel: 1/(sqrt(2) - 1) = 2.4, and 4 with a margin.
UNRESOLVED_SAFETY = 4.0
#: Roundings of the speed that a panel may be off. Chosen; an inverse square root at the end of a
#: panel then is rounding where the panel is some thousand roundings wide.
VARIATION_SAFETY = 10.0
#: Roundings of its mass that a panel may be off. Chosen: sums of 24 and of 512 points.
MASS_SAFETY = 100.0


@dataclass(frozen=True, eq=False)
class ScannedPanels:
    """Panels to begin with, of which the integrals over some parts are known.

    Parameters
    ----------
    ends : of the panels, shape (n, 2)
    known_parts : integrals over equal parts of each panel, to compare with, a power of two of them;
        NaN where they are not known; shape (n, n_parts)
    """

    ends: FloatArray
    known_parts: NumberArray

    def halves_of(self, is_halved: np.ndarray, halves: FloatArray) -> ScannedPanels:
        """Return the halves, (n, 2, 2), of some of the panels."""
        parts = self.known_parts[is_halved]
        n_parts_of_half = parts.shape[1] // 2
        parts_of_halves = parts[:, : 2 * n_parts_of_half].reshape(2 * len(parts), n_parts_of_half)
        return ScannedPanels(halves[is_halved].reshape(-1, 2), parts_of_halves)


@dataclass(frozen=True, eq=False)
class Integral:
    """An integral as a sum.

    Parameters
    ----------
    x : points, shape (n_points,)
    weight : weights times the function there, shape (n_points,)
    error : estimate of what is not resolved
    """

    x: FloatArray
    weight: NumberArray
    error: float


def integrate_by_halving(
    function: Callable[[FloatArray], NumberArray],
    panels: ScannedPanels,
    importance: Callable[[FloatArray], FloatArray],
    tolerance: float,
    full_width: float,
) -> Integral:
    """Integrate a function on panels that are halved until each is resolved.

    A panel is resolved when 12 points on it give the same integral as 12 points on each half, when
    the polynomials through the latter go on to the values at the ends of the halves (else a step
    or a kink may lie between an end and the outermost point), and when the integral is that of the
    known parts, which may have more points.

    Parameters
    ----------
    function : maps points (n,) to values (n,)
    panels : to begin with
    importance : what an error of the integral around a point counts
    tolerance : largest error of a panel of the full width, or wider, times its importance; of
        narrower ones in proportion, so that those around a step or an infinity do not add up
    full_width : a width of panels

    Returns
    -------
    The integral; its error is that of panels too narrow to be halved, or too many.
    """
    points: list[FloatArray] = []
    weights: list[NumberArray] = []
    unresolved = 0.0
    while panels.ends.size:
        halved = HalvedPanels.of(function, panels.ends)
        error = halved.error_beside(panels.known_parts)
        ends = panels.ends
        width = ends[:, 1] - ends[:, 0]
        error_that_counts = error * np.maximum(importance(ends[:, 0]), importance(ends[:, 1]))
        is_resolved = error_that_counts <= tolerance * np.minimum(width / full_width, 1.0)
        is_last = (0.5 * width < NARROWEST) | (error <= halved.rounding)
        if len(ends) > MAX_PANELS:  # of noise
            is_last[:] = True
        unresolved_errors = np.where(is_last & ~is_resolved, error_that_counts, 0.0)
        unresolved += UNRESOLVED_SAFETY * float(unresolved_errors.sum())
        is_done = is_resolved | is_last
        points.append(halved.x[is_done].ravel())
        weights.append(halved.weighted[is_done].ravel())
        panels = panels.halves_of(~is_done, halved.halves)
    return Integral(np.concatenate(points), np.concatenate(weights), unresolved)


@dataclass(frozen=True, eq=False)
class HalvedPanels:
    """A function on panels, by 12 points on each half.

    Parameters
    ----------
    halves : ends of the halves, shape (n, 2, 2)
    x, weighted : points, and weights times the function there, shape (n, 24)
    integral, error : of each panel, and its estimate, shape (n,)
    rounding : of the integral, shape (n,)
    """

    halves: FloatArray
    x: FloatArray
    weighted: NumberArray
    integral: NumberArray
    error: FloatArray
    rounding: FloatArray

    @classmethod
    def of(cls, function: Callable[[FloatArray], NumberArray], ends: FloatArray) -> HalvedPanels:
        """Evaluate a function on panels ``ends``, (n, 2)."""
        n = ends.shape[0]
        middle = ends.mean(axis=1)
        halves = np.stack([ends[:, 0], middle, middle, ends[:, 1]], axis=1).reshape(n, 2, 2)
        coarse_x, coarse_weight = panels_of(ends, POINTS)
        fine_x, fine_weight = panels_of(halves.reshape(-1, 2), POINTS)
        fine_x = fine_x.reshape(n, 2 * POINTS)
        # from inside: a step at the end of a half is no concern of it
        x_at_ends = (halves + 0.5 * NARROWEST * np.array([1.0, -1.0])).reshape(n, 4)
        x = np.concatenate([coarse_x, fine_x, x_at_ends], axis=1)
        values = function(x.ravel()).reshape(n, -1)
        coarse, fine, at_ends = np.split(values, [POINTS, 3 * POINTS], axis=1)
        weighted = fine * fine_weight.reshape(n, 2 * POINTS)
        integral = weighted.sum(axis=1)
        difference = np.abs(integral - (coarse * coarse_weight).sum(axis=1))
        continued = (fine.reshape(2 * n, POINTS) @ _rows_to_ends().T).reshape(n, 4)
        outermost_point = float(gauss_legendre(POINTS)[0][0])
        gap_at_end = outermost_point * (middle - ends[:, 0])
        beyond_points = np.abs(at_ends - continued).max(axis=1) * gap_at_end
        # the speeds are rounded as well: of a steep function by this share of how much it varies
        variation = np.abs(fine - fine.mean(axis=1, keepdims=True)).max(axis=1)
        mass = np.abs(weighted).sum(axis=1)
        return cls(
            halves=halves,
            x=fine_x,
            weighted=weighted,
            integral=integral,
            error=np.maximum(difference, beyond_points),
            rounding=ROUNDING * (VARIATION_SAFETY * variation + MASS_SAFETY * mass),
        )

    def error_beside(self, known_parts: NumberArray) -> FloatArray:
        """Return errors, (n,), that also cover the difference from known parts (n, n_parts)."""
        if known_parts.shape[1] == 0:
            return self.error
        difference = np.abs(self.integral - known_parts.sum(axis=1))
        # NaN where a part is not known
        return np.fmax(self.error, np.where(difference > self.rounding, difference, 0.0))


@lru_cache(maxsize=1)
def _rows_to_ends() -> FloatArray:
    """Return rows that take values at the Gauss points of [0, 1] to the ends 0 and 1."""
    nodes = gauss_legendre(POINTS)[0]
    distances = np.array([0.0, 1.0])[:, None] - nodes
    return interpolation_rows(distances, barycentric_weights(nodes))

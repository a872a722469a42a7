"""What the figures draw, and lines that several of them have."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics import ScalingSolution, sonine
from kinetics.collision.medium import SETTLED
from kinetics.crosscheck.report.case import Array, Case, Mask, Measured
from kinetics.crosscheck.report.figures import Data, axis, series
from kinetics.crosscheck.report.settings import ReportSettings

LARGEST_RELATIVE_ERROR = 0.5
"""Standard error over value above which a point on a logarithmic axis is left out."""
LARGEST_RATIO_ERROR = 0.1
"""Standard error above which a ratio to the kinetic equation is left out."""
BEYOND_LAST = 10.0
"""Lines of the equation go on to so many times the last time of the particles."""
TIME = axis("time $t$", "d/U", "log")
RATIO = axis("over the equation")
RESTITUTION = axis("restitution $e$", limits=(0.0, 1.0))


@dataclass(frozen=True)
class Results:
    """What the figures of one report draw."""

    cases: Sequence[Case]
    settings: ReportSettings

    @property
    def spans(self) -> list[dict[str, float]]:
        """The last decade of each case's times, over which its rates are averaged."""
        return [
            {
                "restitution": c.restitution,
                "low": float(c.times[c.early]),
                "high": float(c.times[-1]),
            }
            for c in self.cooling
        ]

    @property
    def number_density(self) -> float:
        """In d^-2, or d^-3 in space."""
        return self.settings.number_density

    @property
    def dimension(self) -> int:
        """2 for disks, 3 for spheres."""
        return self.settings.dimension

    @property
    def is_papers_law(self) -> bool:
        """Whether scatterers are smooth disks, for which the paper's formulas are."""
        return self.settings.is_papers_law

    @property
    def is_smooth(self) -> bool:
        """Whether a bounce keeps the tangential velocity."""
        return self.settings.tangential_restitution == 1.0

    @property
    def gaussian_kurtosis(self) -> float:
        """<r^4>/<r^2>^2 of a Gaussian."""
        return 1 + 2 / self.dimension

    @property
    def words(self) -> dict[str, Any]:
        """What the sentences under a figure need to know of the law."""
        return {
            "papers_law": self.is_papers_law,
            "smooth": self.is_smooth,
            "spheres": self.dimension == 3,
            "scatterers": self.settings.scatterers,
        }

    @property
    def cooling(self) -> list[Case]:
        """The cases that cool: the law is not elastic."""
        return [case for case in self.cases if case.exact is not None]

    @property
    def dense_cases(self) -> list[Case]:
        """The cases for which there is an equation at the density of the disks."""
        return [case for case in self.cases if case.dense is not None]

    @property
    def settled(self) -> float:
        """Time in d/U from which on that equation is trusted."""
        return SETTLED / (2 * self.settings.half_rate)

    @property
    def printed(self) -> list[Case]:
        """The cooling cases at which the printed a2 is real."""
        return [case for case in self.cooling if np.isfinite(sonine.a2(case.restitution))]


def ends_of(times: Sequence[Array]) -> Array:
    """The first and the last of several ranges of times."""
    return np.array([min(t[0] for t in times), max(t[-1] for t in times)])


def solved(case: Case) -> Mask:
    """The late times that a figure shows."""
    return np.asarray(case.late.times <= BEYOND_LAST * case.times[-1])


def restitutions() -> Array:
    """0 <= e < 1, with the threshold from which on the printed a2 is real."""
    return np.sort([*np.linspace(0.0, 0.99, 100), 0.999, sonine.THRESHOLD_RESTITUTION + 1e-12])


@cache
def exact_states(
    tangential_restitution: float = 1.0, dimension: int = 2
) -> tuple[ScalingSolution, ...]:
    """The exact scaling state at each of the `restitutions`."""
    law = tangential_restitution, dimension
    return tuple(ScalingSolution(float(e), *law) for e in restitutions())


def level(source: str, x: ArrayLike, y: float, restitution: float | None = None) -> Data:
    """A horizontal line from the first x to the last."""
    return series(source, np.asarray(x)[[0, -1]], [y] * 2, None, restitution)


def particles(
    case: Case,
    x: Array,
    points: Sequence[Measured],
    shown: Callable[[Measured], Mask] | None = None,
    ranges: Array | None = None,
) -> list[Data]:
    """The points at x of `case.runs`, one `Measured` for each; only those that are `shown`.

    ranges (n, 2): the range of x that each point is an average over.
    """
    lines = []
    for run, measured in zip(case.runs, points, strict=True):
        keep: Any = ... if shown is None else shown(measured)
        seen, within = measured[keep], None if ranges is None else ranges[keep]
        e = case.restitution
        lines.append(series(run.name, x[keep], seen.value, seen.error, e, None, within))
    return lines


def over_equation(case: Case, x: Array, points: Sequence[Measured], expected: Array) -> list[Data]:
    """The points of both runs over what the kinetic equation expects at the same x."""
    return particles(case, x, [measured / expected for measured in points], small_error)


def small_error(measured: Measured) -> Mask:
    """Points of a ratio whose error leaves something to see."""
    return (measured.error > 0) & (measured.error < LARGEST_RATIO_ERROR)


def readable(measured: Measured) -> Mask:
    """Points of a logarithmic axis: positive, and with an error that leaves something to see."""
    value, error = measured.value, measured.error
    return (value > 0) & (error > 0) & (error < LARGEST_RELATIVE_ERROR * value)


def over_restitution(
    results: Results,
    of: Callable[[float, Any], Any],
    same_times: Callable[[Case], float],
    printed: Mapping[str, ArrayLike],
) -> list[Data]:
    """A quantity over e: `of` the exact scaling state, the solver's and both runs; and as printed.

    `of` takes the restitution and a state, then returns a number, or a run, then a `Measured`;
    `same_times` is the kinetic equation's value over the same times as those of the runs.
    """
    cases, settings = results.cooling, results.settings
    at, e = [case.restitution for case in cases], restitutions()
    states = exact_states(settings.tangential_restitution, settings.dimension)
    exact = [of(float(x), state) for x, state in zip(e, states, strict=True)]
    solver = [of(case.restitution, case.scaling_state[1]) for case in cases]
    lines = [series("exact", e, exact), series("solver", at, solver)]
    for case in cases:
        x, expected = case.restitution, same_times(case)
        lines.append(series("equation, same times", x, expected, None, x))
        lines += particles(case, np.array([x]), [_one(of(x, run)) for run in case.runs])
    return lines + [series(source, e, values) for source, values in printed.items()]


def _one(measured: Measured) -> Measured:
    return Measured(np.atleast_1d(measured.value), np.atleast_1d(measured.error))

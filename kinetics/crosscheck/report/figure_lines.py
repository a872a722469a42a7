"""Lines that several figures have."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Case, Mask, Measured
from kinetics.crosscheck.report.figures import Data, series
from kinetics.crosscheck.report.templates import paragraphs

if TYPE_CHECKING:
    from kinetics import ScalingSolution

LARGEST_RELATIVE_ERROR = 0.5
"""Standard error over value above which a point on a logarithmic axis is left out."""


def figure(name: str, x: Data, y: Data, lines: Sequence[Data], **values: Any) -> Data:
    """The data of one figure; `values` fill its title and description, which the template has."""
    title, description = paragraphs("figures.txt.j2", name.replace("-", "_"), **values)
    return {"title": title, "description": description, "x": x, "y": y, "series": list(lines)}


def restitutions() -> Array:
    """0 <= e < 1, with the threshold from which on the printed a2 is real."""
    return np.sort([*np.linspace(0.0, 0.99, 100), 0.999, sonine.THRESHOLD_RESTITUTION + 1e-12])


@cache
def exact_states() -> "tuple[ScalingSolution, ...]":
    """The exact scaling state at each of the `restitutions`."""
    from kinetics import ScalingSolution

    return tuple(ScalingSolution(float(e)) for e in restitutions())


def level(source: str, x: ArrayLike, y: float, restitution: float | None = None) -> Data:
    """A horizontal line from the first x to the last."""
    return series(source, np.asarray(x)[[0, -1]], [y] * 2, None, restitution)


def particles(
    case: Case,
    x: Array,
    points: Sequence[Measured],
    shown: Callable[[Measured], Mask] | None = None,
) -> list[Data]:
    """The points at x of `case.runs`, one `Measured` for each; only those that are `shown`."""
    lines = []
    for run, measured in zip(case.runs, points, strict=True):
        keep: Any = ... if shown is None else shown(measured)
        seen = measured[keep]
        lines.append(series(run.name, x[keep], seen.value, seen.error, case.restitution))
    return lines


def readable(measured: Measured) -> Mask:
    """Points of a logarithmic axis: positive, and with an error that leaves something to see."""
    value, error = measured.value, measured.error
    return (value > 0) & (error > 0) & (error < LARGEST_RELATIVE_ERROR * value)


def over_restitution(
    cases: Sequence[Case],
    of: Callable[[float, Any], Any],
    printed: Mapping[str, ArrayLike],
) -> list[Data]:
    """A quantity over e: `of` the exact scaling state, the solver's and both runs; and as printed.

    `of` takes the restitution and a state, then returns a number, or a run, then a `Measured`.
    """
    at, e = [case.restitution for case in cases], restitutions()
    exact = [of(float(x), state) for x, state in zip(e, exact_states(), strict=True)]
    solver = [of(case.restitution, case.scaling_state[1]) for case in cases]
    lines = [series("exact", e, exact), series("solver", at, solver)]
    for k, run in enumerate(cases[0].runs):
        points = [of(case.restitution, case.runs[k]) for case in cases]
        value, error = [float(p.value) for p in points], [float(p.error) for p in points]
        lines.append(series(run.name, at, value, error))
    return lines + [series(source, e, values) for source, values in printed.items()]

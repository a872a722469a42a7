"""What the data of every figure are made of: axes, series, and which points a figure can show."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics import sonine
from kinetics.crosscheck.report.case import Array, Case, ParticleEvidence

Data = dict[str, Any]

LARGEST_RELATIVE_ERROR = 0.5
"""Standard error over value above which a point on a logarithmic axis says nothing."""


def axis(
    label: str, unit: str = "", scale: str = "linear", limits: tuple[float, float] | None = None
) -> Data:
    """One axis; limits None leaves them to what is drawn."""
    return {
        "label": label,
        "unit": unit,
        "scale": scale,
        "limits": None if limits is None else list(limits),
    }


def series(
    source: str,
    x: ArrayLike,
    y: ArrayLike,
    error: ArrayLike | None = None,
    restitution: float | None = None,
    group: str | None = None,
) -> Data:
    """One line, or points with their standard errors."""
    return {
        "source": source,
        "restitution": restitution,
        "group": group,
        "x": _plain(x),
        "y": _plain(y),
        "error": None if error is None else _plain(error),
    }


def _plain(values: ArrayLike) -> list[float | None]:
    """Floats, and None for what has no finite value: JSON has no NaN."""
    return [
        float(v) if np.isfinite(v) else None for v in np.atleast_1d(np.asarray(values, dtype=float))
    ]


def figure(title: str, description: str, x: Data, y: Data, lines: Iterable[Data]) -> Data:
    """The data of one figure."""
    return {"title": title, "description": description, "x": x, "y": y, "series": list(lines)}


def both_runs(case: Case) -> tuple[ParticleEvidence, ParticleEvidence]:
    """The particles of a case."""
    return case.free, case.disks


def by_run(cases: Sequence[Case]) -> list[tuple[str, list[ParticleEvidence]]]:
    """The runs of every case, Boltzmann-Grad first, under the name that they share."""
    runs = zip(*(both_runs(case) for case in cases), strict=True)
    return [(same[0].name, list(same)) for same in runs]


def points(name: str, x: Array, value: Array, error: Array, restitution: float) -> Data:
    """Points of a logarithmic axis: positive, and with an error that leaves something to see."""
    keep = (value > 0) & (error > 0) & (error < LARGEST_RELATIVE_ERROR * value)
    return series(name, x[keep], value[keep], error[keep], restitution)


def middles(edges: Array) -> Array:
    """Where a bin's point stands."""
    return np.asarray((edges[1:] + edges[:-1]) / 2)


def all_restitutions() -> Array:
    """0 <= e < 1, with the threshold from which on the printed a2 is real."""
    return np.sort([*np.linspace(0.0, 0.99, 100), 0.999, sonine.THRESHOLD_RESTITUTION + 1e-12])


def over_restitution(
    cases: Sequence[Case],
    exact: Callable[[Array], ArrayLike],
    of_run: Callable[[Case, ParticleEvidence], tuple[float, float]],
    solver: Callable[[Case], float],
) -> list[Data]:
    """A quantity over e: exact, solved, and both runs' values with errors (`of_run` gives both)."""
    at = [case.restitution for case in cases]
    e = all_restitutions()
    lines = [series("exact", e, exact(e)), series("solver", at, [solver(case) for case in cases])]
    for name, runs in by_run(cases):
        pairs = np.array([of_run(case, run) for case, run in zip(cases, runs, strict=True)])
        lines.append(series(name, at, pairs[:, 0], pairs[:, 1]))
    return lines

"""The comparisons of one report: who says what against whom, and the verdict on each."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.report.case import Array, Case, Measured, ParticleEvidence
from kinetics.crosscheck.verdicts import (
    Verdict,
    corrected_sigmas,
    judge_approximation,
    judge_numerical,
    judge_sigmas,
    worst,
)

if TYPE_CHECKING:
    from kinetics import Solution

KINETIC = "kinetic equation"
RESCALED = "kinetic equation, measured l"
EXACT = "exact"
PAPER_FIT = "paper's fit"

LEAST_EXPECTED = 50
"""Samples that a bin must be expected to hold before its jackknife error is trusted."""

TITLES = {
    "free_path": "Mean free path l / d",
    "cooling_rate": "Cooling rate h(e)",
    "a2": "Second Sonine coefficient a₂ (deviations relative to 1 + a₂)",
    "thermal_speed": "Thermal speed v₀(t) / U",
    "scaled_vdf": "Scaled velocity distribution F(c)",
    "msd": "Mean square displacement ⟨r²(t)⟩ / d²",
    "msd_slope": "Slope d⟨r²⟩/d ln t / d²",
    "kurtosis": "Kurtosis of the displacement ⟨r⁴⟩/⟨r²⟩²",
    "position": "Scaled displacement distribution G(R)",
    "tail_exponent": "Local exponent n(R) of G(R)/R ~ exp(−(R/b)ⁿ)",
}
"""Every observable that a row can have, in the order of the report."""


@dataclass(frozen=True)
class Row:
    """One comparison: `source` says `value` (+- `error`), `against` says `theory`.

    `time` is in d/U, `c` a scaled speed and `distance` a scaled distance R, each None where it has
    no meaning; where a row looks at several times or bins (`looks`), they are those of the worst.
    `deviation` is relative to the theory, for a2 to 1 + a2 = <c^4>/2 (a2 itself passes through 0).
    `groups` independent groups stand behind the error; it, `sigmas` and `corrected_sigmas` are None
    unless the kind is statistical.
    """

    observable: str
    restitution: float
    kind: str
    source: str
    against: str
    value: float
    theory: float
    deviation: float
    error: float | None = None
    time: float | None = None
    c: float | None = None
    distance: float | None = None
    sigmas: float | None = None
    corrected_sigmas: float | None = None
    looks: int = 1
    groups: int | None = None
    verdict: Verdict = Verdict.UNDEFINED
    note: str = ""


def judged(rows: Iterable[Row]) -> list[Row]:
    """The rows with their statistical verdicts, corrected for the looks that each took."""
    return [_judge(row) if row.kind == "statistical" else row for row in rows]


def _judge(row: Row) -> Row:
    assert row.sigmas is not None
    assert row.groups is not None
    corrected = corrected_sigmas(row.sigmas, row.groups, row.looks)
    return replace(row, corrected_sigmas=corrected, verdict=judge_sigmas(corrected))


def numerical(
    case: Case, observable: str, value: float, theory: float, tolerance: float, note: str = ""
) -> Row:
    """The solver's value against the closed form."""
    deviation = relative(observable, value, theory)
    return Row(
        observable,
        case.restitution,
        "numerical",
        "solver",
        EXACT,
        value,
        theory,
        deviation,
        verdict=judge_numerical(deviation, tolerance),
        note=note or f"asked for {tolerance:g}",
    )


def approximation(
    case: Case,
    observable: str,
    source: str,
    value: float,
    theory: float,
    against: str = EXACT,
    time: float | None = None,
    note: str = "",
    distance: float | None = None,
) -> Row:
    """A printed formula's value against the theory."""
    deviation = relative(observable, value, theory)
    return Row(
        observable,
        case.restitution,
        "approximation",
        source,
        against,
        value,
        theory,
        deviation,
        time=time,
        distance=distance,
        verdict=judge_approximation(deviation),
        note=note,
    )


def statistical(
    case: Case,
    observable: str,
    source: ParticleEvidence,
    measured: Measured,
    theory: ArrayLike,
    against: str,
    times: Array | None = None,
    speeds: Array | None = None,
    distances: Array | None = None,
    note: str = "",
) -> list[Row]:
    """One row at the worst of its times or bins; none where nothing has an error to compare."""
    value, error, expected = np.broadcast_arrays(
        *(np.atleast_1d(a) for a in (measured.value, measured.error, theory))
    )
    at = worst(value, error, expected)
    if at is None:
        return []
    k = at.index
    return [
        Row(
            observable,
            case.restitution,
            "statistical",
            source.name,
            against,
            float(value[k]),
            float(expected[k]),
            relative(observable, float(value[k]), float(expected[k])),
            error=float(error[k]),
            time=None if times is None else float(times[k]),
            c=None if speeds is None else float(speeds[k]),
            distance=None if distances is None else float(distances[k]),
            sigmas=at.sigmas,
            looks=at.looks,
            groups=source.groups,
            note=note,
        )
    ]


def scale_of(observable: str, theory: float) -> float:
    """What deviations are relative to: |theory|, but 1 + a2 = <c^4>/2 for a2."""
    return 1 + theory if observable == "a2" else abs(theory)


def relative(observable: str, value: float, theory: float) -> float:
    """The relative deviation of a value from the theory."""
    return (value - theory) / scale_of(observable, theory)


def contact_value(number_density: float, diameter: float = 1.0) -> float:
    """Henderson's pair correlation of hard disks at contact, g(d), by which l = 1/(2 d rho0 g)."""
    fraction = math.pi * number_density * diameter**2 / 4
    return (1 - 7 * fraction / 16) / (1 - fraction) ** 2


def cooling_rate_between(
    times: Array, thermal_speed: Array, early: int, number_density: float
) -> float:
    """Estimate h from 1/v0 at `early` and at the last time: the slope of eq. veq over d rho0."""
    slope = (1 / thermal_speed[-1] - 1 / thermal_speed[early]) / (times[-1] - times[early])
    return float(slope / number_density)


def msd_slope_between(times: Array, msd: Array, early: int) -> float:
    """d<r^2>/d ln t, in d^2, between `early` and the last time."""
    return float((msd[-1] - msd[early]) / np.log(times[-1] / times[early]))


def last_vdf(solution: "Solution") -> Callable[[Array], Array]:
    """F(c) of a solution at its last time, from its radial density over v = c v0(t)."""
    v0 = float(solution.thermal_speed[-1])

    def vdf(c: Array) -> Array:
        return np.asarray(v0 * solution.speed_density(c * v0)[-1] / (2 * math.pi * c))

    return vdf


def bin_average(vdf: Callable[[Array], ArrayLike], edges: Array) -> Array:
    """F(c) averaged over the area of each bin of c: Gauss-Legendre, 8 points in each."""
    x, w = np.polynomial.legendre.leggauss(8)
    half = np.diff(edges)[:, None] / 2
    c = edges[:-1, None] + half * (x + 1)
    values = np.asarray(vdf(c.ravel())).reshape(c.shape)
    return np.asarray(np.sum(2 * c * values * w * half, axis=1) / np.diff(edges**2))


def largest_change(case: Case, kinetic: Array) -> float:
    """How far the VDF at the last time still is from the scaling state, relative to its peak."""
    assert case.scaled is not None
    final = bin_average(case.scaled.vdf, case.speed_edges)
    return float(np.max(np.abs(kinetic - final)) / np.max(final))


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """How many rows have each verdict, those that occur."""
    return {v.value: n for v in Verdict if (n := sum(row.verdict is v for row in rows))}

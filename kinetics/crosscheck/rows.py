"""The comparisons of one report: who says what against whom, and the verdict on each."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinetics import sonine
from kinetics.crosscheck.evidence import Array, Case, Measured, ParticleEvidence
from kinetics.crosscheck.settings import ReportSettings
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
}
"""Every observable that a row can have, in the order of the report."""


@dataclass(frozen=True)
class Row:
    """One comparison: `source` says `value` (+- `error`), `against` says `theory`.

    `time` is in d/U and `c` a scaled speed, each None where it has no meaning; where a row looks at
    several times or bins (`looks`), they are those of the worst. `deviation` is relative to the
    theory, for a2 to 1 + a2 = <c^4>/2 (a2 itself passes through 0). `groups` independent groups
    stand behind the error; it, `sigmas` and `corrected_sigmas` are None unless the kind is
    statistical.
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
    sigmas: float | None = None
    corrected_sigmas: float | None = None
    looks: int = 1
    groups: int | None = None
    verdict: Verdict = Verdict.UNDEFINED
    note: str = ""


def compare_case(case: Case, settings: ReportSettings) -> list[Row]:
    """Every row of one restitution; statistical ones are not judged yet (see `judged`)."""
    rows = [*_free_path(case, settings)]
    if case.exact is not None:
        rows += _cooling_rate(case, settings)
    rows += [*_a2(case, settings), *_thermal_speed(case)]
    if case.exact is not None:
        rows += _scaled_vdf(case, settings)
    return rows + _msd(case, settings)


def judged(rows: Iterable[Row]) -> list[Row]:
    """The rows with their statistical verdicts, corrected for the looks that each took."""
    return [_judge(row) if row.kind == "statistical" else row for row in rows]


def _judge(row: Row) -> Row:
    assert row.sigmas is not None
    assert row.groups is not None
    corrected = corrected_sigmas(row.sigmas, row.groups, row.looks)
    return replace(row, corrected_sigmas=corrected, verdict=judge_sigmas(corrected))


def _numerical(
    case: Case, observable: str, value: float, theory: float, tolerance: float, note: str = ""
) -> Row:
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


def _approximation(
    case: Case,
    observable: str,
    source: str,
    value: float,
    theory: float,
    against: str = EXACT,
    time: float | None = None,
    note: str = "",
) -> Row:
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
        verdict=judge_approximation(deviation),
        note=note,
    )


def _statistical(
    case: Case,
    observable: str,
    source: ParticleEvidence,
    measured: Measured,
    theory: ArrayLike,
    against: str,
    times: Array | None = None,
    speeds: Array | None = None,
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


def _free_path(case: Case, settings: ReportSettings) -> list[Row]:
    dilute = 1 / (2 * settings.number_density)
    dense = dilute / contact_value(settings.number_density)
    return [
        *_statistical(case, "free_path", case.free, case.free.free_path, dilute, "1/(2dρ₀)"),
        *_statistical(
            case,
            "free_path",
            case.disks,
            case.disks.free_path,
            dilute,
            "1/(2dρ₀)",
            note="disks that exclude each other are met sooner; not in the kinetic equation",
        ),
        *_statistical(
            case,
            "free_path",
            case.disks,
            case.disks.free_path,
            dense,
            "1/(2dρ₀g)",
            note="g: Henderson's contact value of hard disks in equilibrium",
        ),
    ]


def _against_both(
    case: Case,
    observable: str,
    free: Measured,
    disks: Measured,
    kinetic: ArrayLike,
    rescaled: ArrayLike,
    times: Array | None = None,
    note: str = "",
) -> list[Row]:
    """Boltzmann-Grad strictly; hard disks as they are, and with their own free path put in."""
    left = "what remains is beyond the free path: recollisions, corners, correlated free paths"
    own = Measured(disks.value, case.rescaled_errors[observable])
    return [
        *_statistical(case, observable, case.free, free, kinetic, KINETIC, times, note=note),
        *_statistical(
            case, observable, case.disks, disks, kinetic, KINETIC, times, note="finite density"
        ),
        *_statistical(case, observable, case.disks, own, rescaled, RESCALED, times, note=left),
    ]


def cooling_rate_between(
    times: Array, thermal_speed: Array, early: int, number_density: float
) -> float:
    """Estimate h from 1/v0 at `early` and at the last time: the slope of eq. veq over d rho0."""
    slope = (1 / thermal_speed[-1] - 1 / thermal_speed[early]) / (times[-1] - times[early])
    return float(slope / number_density)


def _cooling_rate(case: Case, settings: ReportSettings) -> list[Row]:
    assert case.exact is not None
    assert case.scaled is not None
    exact = case.exact.cooling_rate
    density = settings.number_density

    def between(thermal_speed: Array) -> float:
        return cooling_rate_between(case.times, thermal_speed, case.early, density)

    kinetic = between(case.kinetic.thermal_speed)
    start = (
        f"slope of 1/v0 from t = {case.times[case.early]:.4g} to {case.times[-1]:.4g} d/U; "
        f"the exact h is {exact:.5f}"
    )
    e = case.restitution
    return [
        _numerical(case, "cooling_rate", case.scaled.cooling_rate, exact, settings.rtol),
        _approximation(case, "cooling_rate", "Sonine", float(sonine.cooling_rate(e)), exact),
        _approximation(
            case, "cooling_rate", PAPER_FIT, float(sonine.cooling_rate_fitted(e)), exact
        ),
        *_against_both(
            case,
            "cooling_rate",
            case.free.cooling_rate,
            case.disks.cooling_rate,
            kinetic,
            between(case.rescaled.thermal_speed),
            note=start,
        ),
        *_statistical(
            case,
            "cooling_rate",
            case.disks,
            case.disks.cooling_rate,
            sonine.cooling_rate_fitted(e),
            PAPER_FIT,
            note="the paper's own claim",
        ),
    ]


def _a2(case: Case, settings: ReportSettings) -> list[Row]:
    rows = []
    if case.exact is not None and case.scaled is not None:
        exact = case.exact.a2
        rows = [
            _numerical(case, "a2", case.scaled.a2, exact, settings.rtol),
            _approximation(case, "a2", "Sonine", float(sonine.a2(case.restitution)), exact),
        ]
    return rows + _against_both(
        case, "a2", case.free.a2, case.disks.a2, case.kinetic.a2, case.rescaled.a2, case.times
    )


def _thermal_speed(case: Case) -> list[Row]:
    return _against_both(
        case,
        "thermal_speed",
        case.free.thermal_speed,
        case.disks.thermal_speed,
        case.kinetic.thermal_speed,
        case.rescaled.thermal_speed,
        case.times,
    )


def _scaled_vdf(case: Case, settings: ReportSettings) -> list[Row]:
    assert case.exact is not None
    assert case.scaled is not None
    centres = (case.speed_edges[1:] + case.speed_edges[:-1]) / 2
    # Where F is 1e-10 of its peak, a relative tolerance asks for more than double precision holds.
    exact = np.asarray(case.exact.vdf(centres))
    solver = np.asarray(case.scaled.vdf(centres))
    k = int(np.argmax(np.abs(solver - exact)))
    deviation = float((solver[k] - exact[k]) / np.max(exact))
    numerical = Row(
        "scaled_vdf",
        case.restitution,
        "numerical",
        "solver",
        EXACT,
        float(solver[k]),
        float(exact[k]),
        deviation,
        c=float(centres[k]),
        looks=len(centres),
        verdict=judge_numerical(deviation, settings.rtol),
        note=f"worst bin centre, relative to the peak; asked for {settings.rtol:g}",
    )
    kinetic, rescaled = (
        bin_average(last_vdf(solution), case.speed_edges)
        for solution in (case.kinetic, case.rescaled)
    )
    note = f"mean over a bin of c at the last time, bins of {LEAST_EXPECTED} samples or more"
    left = f"; still to change by {largest_change(case, kinetic):.1%} of the peak"
    rows = [numerical]
    for run, theory, against in (
        (case.free, kinetic, KINETIC),
        (case.disks, rescaled, RESCALED),
    ):
        expected = run.samples * theory * math.pi * np.diff(case.speed_edges**2)
        compared = np.where(expected >= LEAST_EXPECTED, theory, np.nan)
        rows += _statistical(
            case, "scaled_vdf", run, run.vdf, compared, against, speeds=centres, note=note + left
        )
    return rows


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
    assert case.exact is not None
    final = bin_average(case.exact.vdf, case.speed_edges)
    return float(np.max(np.abs(kinetic - final)) / np.max(final))


def _msd(case: Case, settings: ReportSettings) -> list[Row]:
    e, density = case.restitution, settings.number_density
    last, theory = float(case.times[-1]), float(case.kinetic.msd[-1])
    walk = float(sonine.msd_random_walk(last, e, density))
    late = slice(case.early, None)
    rows = [
        _approximation(
            case,
            "msd",
            PAPER_FIT,
            walk,
            theory,
            KINETIC,
            last,
            f"random walk (eq. msd) with l = {sonine.FITTED_FREE_PATH} d",
        ),
        _approximation(
            case,
            "msd",
            "Sonine",
            float(sonine.msd_sonine(last, e, density)),
            theory,
            KINETIC,
            last,
            "eq. ad8",
        ),
        *_statistical(
            case,
            "msd",
            case.disks,
            Measured(case.disks.msd.value[late], case.disks.msd.error[late]),
            sonine.msd_random_walk(case.times[late], e, density),
            PAPER_FIT,
            case.times[late],
            note="the paper's own claim, for late times: here the last decade",
        ),
    ]
    return rows + _against_both(
        case, "msd", case.free.msd, case.disks.msd, case.kinetic.msd, case.rescaled.msd, case.times
    )


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """How many rows have each verdict, those that occur."""
    return {v.value: n for v in Verdict if (n := sum(row.verdict is v for row in rows))}

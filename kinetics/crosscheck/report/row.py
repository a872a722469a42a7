"""One comparison: who says what against whom, how far apart they are, and the verdict on it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.numerals import numeral
from kinetics.crosscheck.report.case import Array, Case, Measured, ParticleRun
from kinetics.crosscheck.report.observables import band_middles, middles
from kinetics.crosscheck.verdicts import (
    Verdict,
    corrected_sigmas,
    judge_approximation,
    judge_numerical,
    judge_sigmas,
    worst,
)

KINETIC = "kinetic equation"
RESCALED = "kinetic equation, measured l"
EXACT, SOLVER = "exact", "solver"
PAPER_FIT = "paper's fit"


TWO_SIDED = 1.96
"""Standard errors of a Gaussian's two-sided 95 %."""


class Names(NamedTuple):
    """How an observable is called: over a table, and where space is short."""

    title: str
    short: str


OBSERVABLES = {
    "free_path": Names("Mean free path l / d", "mean free path"),
    "cooling_rate": Names("Cooling rate h(e)", "h(e)"),
    "a2": Names("Second Sonine coefficient a₂ (deviations relative to 1 + a₂)", "a₂"),
    "thermal_speed": Names("Thermal speed v₀(t) / U", "v₀(t)"),
    "scaled_vdf": Names("Scaled velocity distribution F(c)", "F(c)"),
    "msd": Names("Mean square displacement ⟨r²(t)⟩ / d²", "⟨r²(t)⟩"),
    "msd_slope": Names("Slope d⟨r²⟩/d ln t / d²", "d⟨r²⟩/d ln t"),
    "kurtosis": Names("Kurtosis of the displacement ⟨r⁴⟩/⟨r²⟩²", "⟨r⁴⟩/⟨r²⟩²"),
    "position": Names("Scaled displacement distribution G(R)", "G(R)"),
    "tail_exponent": Names("Local exponent n(R) of G(R)/R ~ exp(−(R/b)ⁿ)", "n(R)"),
}
"""Every observable that a row can have, in the order of the report."""
OVER_TIME = ("thermal_speed", "a2", "msd", "kurtosis")
"""Those that have a value at each time."""


@dataclass(frozen=True)
class Row:
    """One comparison: `source` says `value` (+- `error`), `against` says `theory`.

    `time` is in d/U, `c` a scaled speed and `distance` a scaled distance R, each None where it has
    no meaning; where a row looks at several times or bins (`looks`), they are those of the worst.
    `deviation` is relative to the theory, for a2 to 1 + a2 = <c^4>/2 (a2 itself passes through 0).
    `groups` independent groups stand behind the error; it, `sigmas` and `corrected_sigmas` are None
    unless the kind is statistical. `within` is the relative difference that a statistical row would
    have seen at 95 %, at every time or bin: how much "no difference" says.
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
    within: float | None = None


def numerical(e: float, observable: str, value: float, theory: float, tolerance: float) -> Row:
    """The solver's value against the closed form."""
    deviation = relative(observable, value, theory)
    return Row(
        observable, e, "numerical", SOLVER, EXACT, value, theory, deviation,
        verdict=judge_numerical(deviation, tolerance), note=f"asked for {numeral(tolerance, 'g')}",
    )  # fmt: skip


def approximation(
    e: float,
    observable: str,
    source: str,
    value: float,
    theory: float,
    against: str = EXACT,
    **where: Any,
) -> Row:
    """A printed formula's value against the theory; `where` are `time`, `distance` and `note`."""
    deviation = relative(observable, value, theory)
    return Row(
        observable, e, "approximation", source, against, value, theory, deviation,
        verdict=judge_approximation(deviation), **where,
    )  # fmt: skip


def statistical(
    case: Case,
    observable: str,
    run: ParticleRun,
    theory: ArrayLike,
    against: str = KINETIC,
    note: str = "",
) -> list[Row]:
    """What particles measured against the theory, at the worst time or bin; NaN is left out.

    The list is empty where nothing has an error to compare with. Against `RESCALED` the error is
    that of the difference, since the theory then changes with the run.
    """
    measured = run.vdf if observable == "scaled_vdf" else getattr(run, observable)
    if against == RESCALED:
        measured = Measured(measured.value, case.rescaled_errors.get(observable, measured.error))
    places: dict[str, Array] = {}
    if observable in OVER_TIME:
        places["time"] = case.times
    elif observable == "scaled_vdf":
        places["c"] = middles(case.speed_edges)
    elif observable == "position":
        places["distance"] = middles(case.position_edges)
    elif observable == "tail_exponent":
        places["distance"] = band_middles(case.dimension)
    who = (run.name, against)
    return estimated(case.restitution, observable, who, measured, theory, run.groups, note, places)


def estimated(
    e: float,
    observable: str,
    who: tuple[str, str],
    measured: Measured,
    theory: ArrayLike,
    groups: int,
    note: str = "",
    places: Mapping[str, Array] = MappingProxyType({}),
) -> list[Row]:
    """The row of an estimate at one or several places: at the worst; see `statistical`.

    who: source and against; groups: independent ones behind the errors; places: "time", "c" or
    "distance" of each value, (n,).
    """
    value, error, expected = np.broadcast_arrays(
        *(np.atleast_1d(a) for a in (measured.value, measured.error, theory))
    )
    at = worst(value, error, expected)
    if at is None:
        return []
    k = at.index
    corrected = corrected_sigmas(at.sigmas, groups, at.looks)
    usable = (error > 0) & np.isfinite(error) & np.isfinite(value) & np.isfinite(expected)
    scale = scale_of(observable, expected)
    seen = ((np.abs(value - expected) + TWO_SIDED * error) / scale)[usable]
    where: dict[str, Any] = {name: float(every[k]) for name, every in places.items()}
    row = Row(
        observable, e, "statistical", *who, float(value[k]), float(expected[k]),
        relative(observable, float(value[k]), float(expected[k])),
        error=float(error[k]), sigmas=at.sigmas, looks=at.looks, groups=groups, note=note,
        corrected_sigmas=corrected, verdict=judge_sigmas(corrected), within=float(np.max(seen)),
        **where,
    )  # fmt: skip
    return [row]


def scale_of(observable: str, theory: Any) -> Any:
    """What deviations are relative to: |theory|, but 1 + a2 = <c^4>/2 for a2."""
    return 1 + theory if observable == "a2" else abs(theory)


def relative(observable: str, value: float, theory: float) -> float:
    """The relative deviation of a value from the theory."""
    return float((value - theory) / scale_of(observable, theory))


def relative_error(row: Mapping[str, Any]) -> float:
    """The standard error of a row of the document, relative as its deviation is; in percent."""
    return float(100 * (row["error"] or 0) / scale_of(row["observable"], row["theory"]))


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """How many rows have each verdict, those that occur."""
    return {v.value: n for v in Verdict if (n := sum(row.verdict is v for row in rows))}

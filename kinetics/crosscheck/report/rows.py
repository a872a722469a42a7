"""Every comparison of a report as one table: who says what against whom, and the verdict on it.

A row looks at one number, or at several times or bins, of which it shows the worst: see `COLUMNS`.
"""

import json
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from kinetics import sonine
from kinetics.crosscheck import words
from kinetics.crosscheck.report import runs
from kinetics.crosscheck.report.runs import Array, Case, Measured, Results
from kinetics.crosscheck.report.systems import Cooling
from kinetics.crosscheck.words import Verdict


@cache
def kept() -> dict[str, Any]:
    """Words and formulas of the page: "observables", "story", "figures", "equations" and more."""
    file = files("kinetics.crosscheck") / "templates" / "report.json"
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found


OBSERVABLES: dict[str, list[str]] = kept()["observables"]
"""Every observable of a row in the order of the tables: its title with its unit, its short name."""
COLUMNS = (
    "system", "dimension", "observable", "restitution", "kind", "source", "against", "value",
    "theory", "deviation", "error", "time", "c", "distance", "sigmas", "corrected_sigmas", "looks",
    "groups", "verdict", "note", "within",
)  # fmt: skip
"""Of the table: `source` says `value` (± `error`), `against` says `theory`.

`restitution` is b of the viscoelastic. `time` is in d/U (in a field √(l/g)), `c` a scaled speed,
`distance` a scaled distance R, where they have a meaning. `deviation` is relative to the theory,
for a2 to 1 + a2 = <c^4>/2 (a2 itself passes through 0). `within` is the relative difference that
would have been seen at 95 % at every time or bin."""
PAPER_KURTOSIS = 4.0  # <R^4>/<R^2>^2 of (2R/eta) K0(R sqrt(2/eta)), eq. (53), for every eta
POSITION_FORMS = (
    ("paper, peak", sonine.position_peak, 0.2, 1.2),  # eq. (59), η = 0.75
    ("paper, tail", sonine.position_tail, 2.0, 4.0),  # eq. (58), η = 0.25, γ = 7.39
    ("paper's integral", sonine.position_integral, 0.2, 4.0),  # eq. (53), η = 1/2
)
"""Source, the printed G(R), and the R between which it is held against the equation."""


def comparisons(results: Results) -> Any:
    """The table of all rows of a report, with `COLUMNS`, in the order of `OBSERVABLES`."""
    rows, compare = [], _of_cooling if isinstance(results.system, Cooling) else _of_driven
    for case in results.cases:
        of = {"system": case.system, "dimension": case.dimension, "restitution": case.restitution}
        rows += [of | row for row in compare(case, results.system)]
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    order = list(OBSERVABLES)
    table = table.sort_values("observable", key=lambda x: x.map(order.index), kind="stable")
    table["note"] = table["observable"].map(kept()["notes"]).fillna("")
    return table.astype({"groups": "Int64", "looks": "int64"}).reset_index(drop=True)


def counts(table: Any) -> dict[str, int]:
    """How many rows have each verdict, those that occur."""
    found = table["verdict"].value_counts()
    return {v.value: int(found[v.value]) for v in Verdict if v.value in found}


def scale_of(observable: str, theory: Any) -> Any:
    """What deviations are relative to: |theory|, but 1 + a2 = <c^4>/2 for a2."""
    return 1 + theory if observable in ("a2", "steady_a2") else abs(theory)


def _row(
    observable: str, kind: str, source: str, against: str, value: float, theory: float, **more: Any
) -> dict[str, Any]:
    deviation = float((value - theory) / scale_of(observable, theory))
    row = {"observable": observable, "kind": kind, "source": source, "against": against,
           "value": float(value), "theory": float(theory), "deviation": deviation,
           "looks": 1}  # fmt: skip
    if kind == "approximation":
        row["verdict"] = words.judge_approximation(deviation).value
    return row | more


def _numerical(
    observable: str, value: float, theory: float, tolerance: float, scale: float | None = None
) -> dict[str, Any]:
    """The solver's value against the closed form; scale: what the deviation is relative to."""
    row = _row(observable, "numerical", runs.SOLVER, runs.EXACT, value, theory)
    if scale is not None:
        row["deviation"] = (value - theory) / scale
    verdict = words.judge_numerical(row["deviation"], tolerance)
    return row | {"verdict": verdict.value}


def estimated(
    observable: str, who: tuple[str, str], measured: Measured, theory: Any, groups: int,
    place: tuple[str, Array] | None = None,
) -> list[dict[str, Any]]:  # fmt: skip
    """The row of an estimate, the worst of its places; none where nothing has an error.

    who: source and against; place: "time", "c" or "distance" and its values. NaN is left out.
    """
    value, error, expected = np.broadcast_arrays(
        *(np.atleast_1d(a) for a in (measured.value, measured.error, theory))
    )
    found = words.worst(value, error, expected)
    if found is None:
        return []
    k, sigmas, looks = found
    corrected = words.corrected_sigmas(sigmas, groups, looks)
    usable = (error > 0) & np.isfinite(error) & np.isfinite(value) & np.isfinite(expected)
    limit = np.abs(value - expected) + words.limit_factor(groups) * error
    seen = limit / scale_of(observable, expected)
    within, verdict = float(np.max(seen[usable])), words.judge_sigmas(corrected)
    if verdict is Verdict.AGREES and within > 0.1:  # a tenth would not have been seen
        verdict = Verdict.NOT_TESTED
    where: dict[str, Any] = {} if place is None else {place[0]: float(place[1][k])}
    row = _row(
        observable, "statistical", *who, value[k], expected[k], error=float(error[k]),
        sigmas=sigmas, looks=looks, groups=groups, corrected_sigmas=corrected,
        verdict=verdict.value, within=within, **where,
    )  # fmt: skip
    return [row]


def _measured(
    case: Case, observable: str, source: str, against: str, theory: Any = None, said: str = ""
) -> list[dict[str, Any]]:
    """What a source of a case measured against what somebody says there, called `said`."""
    expected = case.theory[against][observable] if theory is None else theory
    found = case.measured[source][observable]
    place, groups = case.places.get(observable), case.runs[source].media
    return estimated(observable, (source, said or against), found, expected, groups, place)


def _of_driven(case: Case, system: Any) -> Iterable[dict[str, Any]]:
    (source,) = case.measured
    solver, exact = case.theory[runs.SOLVER], case.theory.get(runs.EXACT, {})
    for name in case.measured[source]:
        if name in solver and name not in exact:
            yield from _measured(case, name, source, runs.SOLVER)
    for name, theory in exact.items():
        yield _numerical(name, solver[name], theory, system.rtol)
        if name in case.measured[source]:  # those of averages of finite variance
            yield from _measured(case, name, source, runs.EXACT)


def _of_cooling(case: Case, system: Any) -> Iterable[dict[str, Any]]:
    (free, hard), theory, found = case.measured, case.theory, case.solved
    times, early, paper = case.times, found.early, system.is_papers_law

    def printed(name: str, source: str, against: str = runs.EXACT, **where: Any) -> dict[str, Any]:
        values = (float(np.ravel(theory[who][name])[-1]) for who in (source, against))
        return _row(name, "approximation", source, against, *values, **where)

    path, of = "free_path", "2d" if system.dimension == 2 else "πd²"
    for run in (free, hard):
        yield from _measured(case, path, run, runs.KINETIC, said=f"1/({of}ρ₀)")
    if case.cools:
        for name in ("cooling_rate", "a2"):
            yield _numerical(name, theory[runs.SOLVER][name], theory[runs.EXACT][name], system.rtol)
        # relative to the peak; the solver gives 0 where F is below its reach
        exact, solver = found.exact.vdf(runs.SPEEDS), found.scaled.reached_vdf(runs.SPEEDS)
        k, at = int(np.argmax(np.abs(solver - exact))), runs.SPEEDS
        row = _numerical("scaled_vdf", solver[k], exact[k], system.rtol, np.max(exact))
        yield row | {"c": float(at[k]), "looks": len(at)}
    measures = {"position": np.diff(runs.POSITION_EDGES)}
    measures |= {"scaled_vdf": runs.bin_measure(case.dimension)} if case.cools else {}
    averages = (*runs.OVER_TIME, *(("cooling_rate", "msd_slope") if case.cools else ()), *measures)
    for name, run in product(averages, (free, hard)):
        expected = theory[runs.KINETIC][name]
        if name in measures:
            expected = runs.filled(expected, case.samples(run), measures[name])
        yield from _measured(case, name, run, runs.KINETIC, expected)
    if not paper:
        return
    end: dict[str, Any] = {"time": float(times[-1])}
    late = np.where(np.arange(times.size) >= early, theory[runs.FIT]["msd"], np.nan)
    for source in (runs.FIT, runs.SONINE):
        yield printed("msd", source, runs.KINETIC, **end)
    yield from _measured(case, "msd", hard, runs.FIT, late)
    if not case.cools:
        return
    for source in (runs.SONINE, runs.FIT):
        yield printed("cooling_rate", source)
        yield printed("msd_slope", source)
    yield printed("a2", runs.SONINE)
    yield from _measured(case, "cooling_rate", hard, runs.FIT)
    who = ("paper's integral", runs.KINETIC, PAPER_KURTOSIS, float(found.kinetic.kurtosis[-1]))
    yield _row("kurtosis", "approximation", *who, **end)
    for source, form, low, high in POSITION_FORMS:
        r, position = np.linspace(low, high, 61), case.solved.position
        density = position.scaled_position_density(r)[-1]
        sure = density > 20.0 * position.rtol  # its logarithm is known to 5 %
        r, density = r[sure], density[sure]
        if r.size:  # at its worst
            values = form(r)
            k = int(np.argmax(np.abs(np.log(values / density))))
            yield _row(
                "position", "approximation", source, runs.KINETIC, values[k], density[k], **end,
                distance=float(r[k]),
            )  # fmt: skip


def records(table: Any) -> list[dict[str, Any]]:
    """The rows as dictionaries; None where a column has no value."""
    found = table.astype(object).where(table.notna(), None).to_dict("records")
    return [{str(key): value for key, value in row.items()} for row in found]


def points(results: Results) -> Any:
    """Everything measured and every theory at its times and bins, one number in a row."""
    found = []
    for case in results.cases:
        said = {
            (source, name): (getattr(x, "value", x), getattr(x, "error", np.nan))
            for source, numbers in [*case.measured.items(), *case.theory.items()]
            for name, x in numbers.items()
        }
        for (source, name), (value, error) in said.items():
            place, at = case.places.get(name, ("", np.nan))
            if np.shape(value) in ((), np.shape(at)):  # else shares over time and density
                columns = {"at": place, "x": at, "value": value, "error": error}
                first = {"system": case.system, "restitution": case.restitution}
                first |= {"source": source, "observable": name}
                found.append(pd.DataFrame({**first, **columns}, index=range(np.size(at))))
    return pd.concat(found, ignore_index=True)

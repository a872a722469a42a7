"""Every comparison of a report as one table: who says what against whom, and the verdict on it.

A row looks at one number, or at several times or bins, of which it shows the worst: see `COLUMNS`.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from kinetics import sonine
from kinetics.crosscheck import words
from kinetics.crosscheck.report.cases import (
    EXACT,
    FIT,
    FREE,
    KINETIC,
    OVER_TIME,
    SOLVER,
    SONINE,
    Case,
    CoolingCase,
    DensityTest,
    DrivenCase,
    FloatArray,
    Measured,
    Place,
    Results,
    ScalingStates,
)
from kinetics.crosscheck.report.estimates import SPEEDS
from kinetics.crosscheck.report.systems import System
from kinetics.crosscheck.report.words_of_report import report_words
from kinetics.crosscheck.words import Verdict

#: A row by the names of its columns; those without a value are absent.
Row = dict[str, object]

#: Columns of the table: `source` says `value` (± `error`), `against` says `theory`.
#:
#: `restitution` is b of the viscoelastic. `time` is in d/U (in a field √(l/g)), `c` a scaled speed,
#: `distance` a scaled distance R, where they have a meaning. `deviation` is relative to the theory,
#: for a2 to 1 + a2 = <c^4>/2 (a2 itself passes through 0). `within` is the relative difference that
#: would have been seen at 95 % at every time or bin.
COLUMNS = (
    "system",
    "dimension",
    "observable",
    "restitution",
    "kind",
    "source",
    "against",
    "value",
    "theory",
    "deviation",
    "error",
    "time",
    "c",
    "distance",
    "sigmas",
    "corrected_sigmas",
    "looks",
    "groups",
    "verdict",
    "note",
    "within",
)
# Kinds of rows.
STATISTICAL = "statistical"
NUMERICAL = "numerical"
APPROXIMATION = "approximation"
#: <R^4>/<R^2>^2 of (2R/eta) K0(R sqrt(2/eta)), eq. (53) of the paper, for every eta.
PAPER_KURTOSIS = 4.0
#: Relative difference that a test must be able to show, or its verdict is "not tested". Chosen;
#: `MEANING` of the verdict says it to the reader.
TESTABLE_DIFFERENCE = 0.1
#: G of a solution over its tolerance from which on the logarithm is known to 5 %.
SURE_DENSITY_OVER_RTOL = 20.0
#: Radii at which a printed G(R) is compared with the equation.
N_RADII = 61


@dataclass(frozen=True)
class PositionForm:
    """A printed G(R), and the R between which it is held against the equation."""

    source: str
    density: Callable[[FloatArray], FloatArray]
    low: float
    high: float


POSITION_FORMS = (
    # Eq. (59), eta = 0.75.
    PositionForm("paper, peak", sonine.position_peak, 0.2, 1.2),
    # Eq. (58), eta = 0.25, gamma = 7.39.
    PositionForm("paper, tail", sonine.position_tail, 2.0, 4.0),
    # Eq. (53), eta = 1/2.
    PositionForm("paper's integral", sonine.position_integral, 0.2, 4.0),
)


def comparisons(results: Results) -> pd.DataFrame:
    """Return the table of all rows of a report, with `COLUMNS`, by observable."""
    rows: list[Row] = []
    for cooling_case in results.cooling:
        rows += _rows_of_cooling(cooling_case, results.system)
    for driven_case in results.driven:
        rows += _rows_of_driven(driven_case, results.system)
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    order = list(report_words().observables)
    table = table.sort_values("observable", key=lambda x: x.map(order.index), kind="stable")
    table["note"] = table["observable"].map(report_words().notes).fillna("")
    return table.astype({"groups": "Int64", "looks": "int64"}).reset_index(drop=True)


def verdict_counts(table: pd.DataFrame) -> dict[str, int]:
    """Return how many rows have each verdict, those that occur."""
    counts = table["verdict"].value_counts()
    return {
        verdict.value: int(counts[verdict.value]) for verdict in Verdict if verdict.value in counts
    }


def scale_of(observable: str, theory: ArrayLike) -> FloatArray:
    """Return what deviations are relative to: |theory|, but 1 + a2 = <c^4>/2 for a2."""
    values = np.asarray(theory, dtype=float)
    if observable in ("a2", "steady_a2"):
        return np.asarray(1 + values)
    return np.abs(values)


# -- rows of each kind -----------------------------------------------------------------------------
@dataclass(frozen=True)
class Question:
    """What a row asks: is what a source says of an observable what another says of it?"""

    observable: str
    source: str
    against: str


def _row(question: Question, kind: str, value: float, theory: float) -> Row:
    """Return what rows of all kinds have."""
    deviation = float((value - theory) / scale_of(question.observable, theory))
    return {
        "observable": question.observable,
        "kind": kind,
        "source": question.source,
        "against": question.against,
        "value": float(value),
        "theory": float(theory),
        "deviation": deviation,
        "looks": 1,
    }


def _approximation(question: Question, value: float, theory: float) -> Row:
    """Return the row of a formula that claims no error of its own."""
    row = _row(question, APPROXIMATION, value, theory)
    deviation = float((value - theory) / scale_of(question.observable, theory))
    row["verdict"] = words.judge_approximation(deviation).value
    return row


def _numerical(
    observable: str, value: float, theory: float, tolerance: float, scale: float | None = None
) -> Row:
    """Return the row of the solver's value against the closed form.

    scale : what the deviation is relative to; None: as usual for the observable
    """
    row = _row(Question(observable, SOLVER, EXACT), NUMERICAL, value, theory)
    divisor = float(scale_of(observable, theory))
    if scale is not None:
        divisor = scale
    deviation = float((value - theory) / divisor)
    row["deviation"] = deviation
    row["verdict"] = words.judge_numerical(deviation, tolerance).value
    return row


def statistical_rows(
    question: Question, measured: Measured, theory: ArrayLike, groups: int, place: Place | None
) -> list[Row]:
    """Return the row of an estimate, the worst of its places; none where nothing has an error.

    Parameters
    ----------
    theory : a number, or one for each place; places of NaN are left out
    groups : independent groups behind the errors
    place : what the estimate depends on
    """
    value, error, expected = np.broadcast_arrays(
        np.atleast_1d(measured.value),
        np.atleast_1d(measured.error),
        np.atleast_1d(np.asarray(theory, dtype=float)),
    )
    look = words.worst(value, error, expected)
    if look is None:
        return []
    index, sigmas, looks = look
    corrected = words.corrected_sigmas(sigmas, groups, looks)
    usable = (error > 0) & np.isfinite(error) & np.isfinite(value) & np.isfinite(expected)
    limit = np.abs(value - expected) + words.limit_factor(groups) * error
    within = float(np.max((limit / scale_of(question.observable, expected))[usable]))
    verdict = words.judge_sigmas(corrected)
    if verdict is Verdict.AGREES and within > TESTABLE_DIFFERENCE:
        verdict = Verdict.NOT_TESTED
    row = _row(question, STATISTICAL, value[index], expected[index])
    row |= {
        "error": float(error[index]),
        "sigmas": sigmas,
        "looks": looks,
        "groups": groups,
        "corrected_sigmas": corrected,
        "verdict": verdict.value,
        "within": within,
    }
    if place is not None:
        row[place.name] = float(place.values[index])
    return [row]


# -- driven tracers --------------------------------------------------------------------------------
def _rows_of_driven(case: DrivenCase, system: System) -> Iterator[Row]:
    """Yield particles against the solver, and both against exact relations."""
    first = _first_columns(case)
    solver = case.theory[SOLVER]
    exact = case.theory[EXACT]
    measured = case.measured[FREE]
    groups = case.sizes[FREE].groups
    for name, estimate in measured.items():
        if name in solver and name not in exact:
            question = Question(name, FREE, SOLVER)
            place = case.places.get(name)
            for row in statistical_rows(question, estimate, solver[name], groups, place):
                yield first | row
    for name, theory in exact.items():
        yield first | _numerical(name, float(solver[name]), float(theory), system.rtol)
        if name in measured:  # those of averages of finite variance
            question = Question(name, FREE, EXACT)
            for row in statistical_rows(question, measured[name], theory, groups, None):
                yield first | row


def _first_columns(case: CoolingCase | DrivenCase) -> Row:
    """Return the columns that all rows of a case share."""
    return {"system": case.system, "dimension": case.dimension, "restitution": case.value}


# -- a gas that is left alone ----------------------------------------------------------------------
def _rows_of_cooling(case: CoolingCase, system: System) -> Iterator[Row]:
    """Yield all rows of a case that is left alone."""
    first = _first_columns(case)
    groups_of_rows: list[Iterable[Row]] = [_free_paths(case)]
    if case.scaling is not None:
        groups_of_rows.append(_scaling_state(case.scaling, system.rtol))
    groups_of_rows.append(_particles(case))
    if system.is_papers_law:
        groups_of_rows.append(_paper_displacement(case))
        if case.cools:
            groups_of_rows.append(_paper_rates(case))
            groups_of_rows.append(_paper_positions(case))
    for rows in groups_of_rows:
        for row in rows:
            yield first | row


def _compare(
    case: CoolingCase,
    observable: str,
    source: str,
    against: str,
    theory: ArrayLike | None = None,
    title: str = "",
) -> list[Row]:
    """Return the row of what a source measured against what somebody says.

    theory : in place of what they say; title : what the row calls them
    """
    if theory is None:
        theory = case.theory[against][observable]
    question = Question(observable, source, title or against)
    groups = case.sizes[source].groups
    measured = case.measured[source][observable]
    return statistical_rows(question, measured, theory, groups, case.places.get(observable))


def _free_paths(case: CoolingCase) -> Iterator[Row]:
    """Yield the mean free path of each run against the formula."""
    cross_section = "2d" if case.dimension == 2 else "πd²"
    for source in case.measured:
        yield from _compare(case, "free_path", source, KINETIC, title=f"1/({cross_section}ρ₀)")


def _scaling_state(scaling: ScalingStates, rtol: float) -> Iterator[Row]:
    """Yield the solver against the closed form of the scaling state."""
    solved = scaling.solved
    closed = scaling.exact
    yield _numerical("cooling_rate", solved.cooling_rate, closed.cooling_rate, rtol)
    yield _numerical("a2", solved.a2, closed.a2, rtol)
    # Relative to the peak; the solver gives 0 where F is below its reach.
    exact = closed.vdf(SPEEDS)
    computed = solved.reached_vdf(SPEEDS)
    worst = int(np.argmax(np.abs(computed - exact)))
    row = _numerical("scaled_vdf", computed[worst], exact[worst], rtol, float(np.max(exact)))
    yield row | {"c": float(SPEEDS[worst]), "looks": len(SPEEDS)}


def _particles(case: CoolingCase) -> Iterator[Row]:
    """Yield averages, late rates and scaled densities of each run against the equation."""
    averages: tuple[str, ...] = OVER_TIME
    densities = ["position"]
    if case.cools:
        averages = (*averages, "cooling_rate", "msd_slope")
        densities.append("scaled_vdf")
    for observable in averages:
        for source in case.measured:
            yield from _compare(case, observable, source, KINETIC)
    for observable in densities:
        for source in case.measured:
            test: DensityTest = case.tests[source][observable]
            question = Question(observable, source, KINETIC)
            groups = case.sizes[source].groups
            yield from statistical_rows(question, test.measured, test.theory, groups, test.place)


def _paper_displacement(case: CoolingCase) -> Iterator[Row]:
    """Yield <r^2> of the paper's formulas against the equation, and of hard disks against them."""
    for source in (FIT, SONINE):
        row = _printed(case, "msd", source, KINETIC)
        row["time"] = float(case.times[-1])
        yield row
    is_late = np.arange(case.times.size) >= case.early
    late = np.where(is_late, case.theory[FIT]["msd"], np.nan)
    yield from _compare(case, "msd", _hard(case), FIT, late)


def _paper_rates(case: CoolingCase) -> Iterator[Row]:
    """Yield the paper's rates of late times and its a2 against the exact ones."""
    for source in (SONINE, FIT):
        yield _printed(case, "cooling_rate", source, EXACT)
        yield _printed(case, "msd_slope", source, EXACT)
    yield _printed(case, "a2", SONINE, EXACT)
    yield from _compare(case, "cooling_rate", _hard(case), FIT)


def _paper_positions(case: CoolingCase) -> Iterator[Row]:
    """Yield the paper's forms of G(R) against the equation, each at its worst R."""
    end = float(case.times[-1])
    kurtosis = float(case.solutions.kinetic.kurtosis[-1])
    question = Question("kurtosis", "paper's integral", KINETIC)
    yield _approximation(question, PAPER_KURTOSIS, kurtosis) | {"time": end}
    position = case.solutions.position
    for form in POSITION_FORMS:
        radii = np.linspace(form.low, form.high, N_RADII)
        density = position.scaled_position_density(radii)[-1]
        is_sure = density > SURE_DENSITY_OVER_RTOL * position.rtol
        if not np.any(is_sure):
            continue
        printed = form.density(radii[is_sure])
        expected = density[is_sure]
        worst = int(np.argmax(np.abs(np.log(printed / expected))))
        question = Question("position", form.source, KINETIC)
        row = _approximation(question, printed[worst], expected[worst])
        yield row | {"time": end, "distance": float(radii[is_sure][worst])}


def _printed(case: CoolingCase, observable: str, source: str, against: str) -> Row:
    """Return the row of a printed formula, at the last time if it depends on time."""
    value = float(np.ravel(case.theory[source][observable])[-1])
    theory = float(np.ravel(case.theory[against][observable])[-1])
    return _approximation(Question(observable, source, against), value, theory)


def _hard(case: CoolingCase) -> str:
    """Return the source of the particles among scatterers with places."""
    return next(source for source in case.measured if source != FREE)


# -- tables ----------------------------------------------------------------------------------------
def records(table: pd.DataFrame) -> list[Row]:
    """Return the rows as dictionaries; None where a column has no value."""
    filled = table.astype(object).where(table.notna(), None)
    filled.columns = filled.columns.astype(str)
    return filled.to_dict("records")


def points(results: Results) -> pd.DataFrame:
    """Return everything measured and every theory at its times and bins, one number in a row."""
    frames = []
    for case in results.cases:
        for source, estimates in case.measured.items():
            for name, estimate in estimates.items():
                place = case.places.get(name)
                frame = _points_of(name, estimate.value, estimate.error, place)
                frames.append(_with_source(frame, case, source))
        for source, theory in case.theory.items():
            for name, values in theory.items():
                frame = _points_of(name, values, np.nan, case.places.get(name))
                frames.append(_with_source(frame, case, source))
    return pd.concat(frames, ignore_index=True)


def _with_source(frame: pd.DataFrame, case: Case, source: str) -> pd.DataFrame:
    """Return points with columns that say of what system they are, and of which source."""
    frame.insert(0, "system", case.system)
    frame.insert(1, "restitution", case.value)
    frame.insert(2, "source", source)
    return frame


def _points_of(
    observable: str, value: ArrayLike, error: ArrayLike, place: Place | None
) -> pd.DataFrame:
    """Return the columns of one observable that follow from its place."""
    where = ""
    at: ArrayLike = np.nan
    if place is not None:
        where = place.name
        at = place.values
    columns = {"observable": observable, "at": where, "x": at, "value": value, "error": error}
    return pd.DataFrame(columns, index=range(np.size(at)))

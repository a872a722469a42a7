"""The findings of a report in words, and the small tables that the words point to.

A number that belongs to one restitution stands in a table, beside its e; each finding is said once.
Sentences are in `templates/report.json`, with "{words}" that are filled in `story.py`.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pandas import DataFrame

from kinetics.crosscheck.report import algebra, rows
from kinetics.crosscheck.report.algebra import AlgebraRow, Erratum
from kinetics.crosscheck.report.cases import (
    EXACT,
    FIT,
    FREE,
    KINETIC,
    SOLVER,
    CoolingCase,
    DrivenCase,
    FloatArray,
    Measured,
    Results,
)
from kinetics.crosscheck.report.curves import exact_rates, limiting_drift
from kinetics.crosscheck.report.systems import Cooling, Driven
from kinetics.crosscheck.report.words_of_report import report_words
from kinetics.crosscheck.words import AGREES_BELOW, Verdict, numeral

HOLDS = "holds"
FAILS = "does not hold"
#: Relative difference from a limit (of a drift, of d<r^2>/d ln t) from which on it is reached.
REACHED_WITHIN = 0.01
#: Exponent n of a tail exp(-a R^n) below which it is called exponential. Chosen.
EXPONENTIAL_BELOW = 1.1
#: Radius R at which the tail of G(R) is looked at. The origin is not recorded.
TAIL_RADIUS = 4.0
#: Per cents from which on a range of differences is told without decimals.
WHOLE_PERCENTS_FROM = 5
#: Observables whose agreement a finding tells in numbers.
TOLD_OBSERVABLES = ("thermal_speed", "msd", "drift")
NARROW_SPACE = "\u202f"


@dataclass(frozen=True)
class SummaryRecord:
    """A number of the table of the findings, at one restitution."""

    quantity: str
    restitution: float
    value: float
    error: float | None = None


@dataclass(frozen=True)
class Claim:
    """A claim of the paper: where it stands and in which words, whether it holds, and why."""

    claim: str
    place: str
    words: str
    judgement: str
    text: str


@dataclass(frozen=True)
class Story:
    """What was compared, the findings, one line, the paper's claims and errata, and tables."""

    compared: str
    findings: list[str]
    line: str
    tables: Mapping[str, list[SummaryRecord]]
    claims: Sequence[Claim] = ()
    errata: Sequence[Erratum] = ()


def tell_story(results: Results, table: DataFrame, checks: Sequence[AlgebraRow]) -> Story:
    """Return the story of any report; `checks` are the rows of the algebra."""
    system = results.system
    if isinstance(system, Driven):
        return _story_of_driven(results.driven, system, table)
    if isinstance(system, Cooling):
        return _story_of_cooling(results, system, table, checks)
    raise TypeError(f"no story of a {type(system).__name__}")


# -- sentences of all reports ----------------------------------------------------------------------
def span(values: Iterable[float], form: str) -> str:
    """Return the smallest and the largest of some numbers, as a sentence says it, without NaN."""
    finite = [value for value in values if math.isfinite(value)]
    if not finite:
        return "–"
    low = numeral(min(finite), form)
    high = numeral(max(finite), form)
    if low == high:
        return low
    return f"{low} to {high}"


def range_of_differences(values: Sequence[float]) -> str:
    """Return relative differences as a range of per cent: "15 to 20 % below"."""
    percents = 100 * np.asarray(values, float)
    form = ".1f"
    if np.all(np.abs(percents) >= WHOLE_PERCENTS_FROM):
        form = ".0f"
    if np.all(percents < 0):
        return f"{span(-percents, form)} % below"
    if np.all(percents > 0):
        return f"{span(percents, form)} % above"
    return f"{span(percents, '+' + form)} % from"


def agreement(table: DataFrame) -> str:
    """Return in how many comparisons particles and solver agree, and what was not tested."""
    with_free = table[(table.kind == rows.STATISTICAL) & (table.source == FREE)]
    is_tested = with_free.verdict != Verdict.NOT_TESTED
    tested = with_free[is_tested]
    limits = []
    for name in TOLD_OBSERVABLES:
        limits_of_observable = tested[tested.observable == name].within
        if len(limits_of_observable):
            within = numeral(100 * limits_of_observable.max(), ".2g")
            limits.append(f"{_short_name(name)} within {within} %")
    untested = with_free[~is_tested].observable.value_counts()
    names = [f"{_short_name(str(name))} ({count})" for name, count in untested.items()]
    solver = table[table.kind == rows.NUMERICAL]
    n_met = int((solver.verdict == Verdict.AGREES).sum())
    return (
        report_words()
        .story["agreement"]
        .format(
            same=int((tested.verdict == Verdict.AGREES).sum()),
            tested=len(tested),
            testable=" that could show a difference of 10 %" if names else "",
            within=f": {', '.join(limits)}" if limits else "",
            not_tested=f"; not tested: {', '.join(names)}" if names else "",
            solver=f". The solver meets the closed forms in {n_met} of {len(solver)}"
            if len(solver)
            else "",
        )
    )


def _short_name(observable: str) -> str:
    """Return the short name of an observable."""
    return report_words().observables[observable].short


def expected_by_chance(table: DataFrame) -> str:
    """Return what the verdicts allow for, and what they expect by chance."""
    count = int((table.kind == rows.STATISTICAL).sum())
    expected = numeral(count * math.erfc(AGREES_BELOW / math.sqrt(2)), ".2g")
    return report_words().story["chance"].format(rows=count, expected=expected)


# -- a gas that is left alone ----------------------------------------------------------------------
def _story_of_cooling(
    results: Results, system: Cooling, table: DataFrame, checks: Sequence[AlgebraRow]
) -> Story:
    """Return the story of a gas that is left alone."""
    words = report_words()
    is_judged = system.is_papers_law and bool(results.inelastic)
    errata = algebra.errata(checks)
    sentences = _system_words(results, system) | _spread_words(results, system)
    sentences["rates_of_paper"] = ""
    findings = words.findings["elastic"]
    if is_judged:
        sentences |= _rate_words(results.inelastic)
        sentences["errata"] = _errata_sentence(errata)
        findings = words.findings["paper"]
    elif results.inelastic:
        findings = words.findings["others"]
    sentences["spread"] = words.cooling["spread"].format(**sentences)
    summary: list[SummaryRecord] = []
    for case in results.cooling:
        summary += _summary(case, system)
    return Story(
        compared=words.cooling["compared"].format(**sentences),
        findings=[agreement(table), *(text.format(**sentences) for text in findings)],
        line=words.cooling["line"].format(**sentences),
        tables={"summary": summary},
        claims=_claims(results.inelastic) if is_judged else [],
        errata=errata,
    )


def _system_words(results: Results, system: Cooling) -> dict[str, str]:
    """Return the words that say what was compared."""
    first = results.cooling[0]
    tangential = f", e_t = {system.tangential_restitution:g},"
    return {
        "of": system.scatterers,
        "free": f"{first.sizes[FREE].total:,}".replace(",", NARROW_SPACE),
        "hard": f"{first.sizes[system.hard].total:,}".replace(",", NARROW_SPACE),
        "density": f"{system.number_density:g}",
        "rough": "" if system.is_smooth else tangential,
        "authors": " (H.-D. Kim and H. Hayakawa)" if system.is_papers_law else "",
        "rtol": numeral(system.rtol, ".0e"),
        "power": "³" if system.dimension == 3 else "²",
    }


def _spread_words(results: Results, system: Cooling) -> dict[str, str]:
    """Return how far hard scatterers spread beside the dilute and the corrected equation."""
    ratios = []
    corrected = []
    for case in results.cooling:
        msd = case.measured[system.hard]["msd"].last
        ratios.append(msd / _last(case, KINETIC, "msd"))
        if case.solutions.dense is not None:
            # The second order of the correction was fitted to other runs.
            corrected.append(float(msd.value) / case.solutions.dense.msd[-1] - 1)
    errors = span([100 * float(ratio.error) for ratio in ratios], ".1f")
    of_corrected = ""
    if corrected:
        difference = range_of_differences(corrected)
        of_corrected = f"; corrected for density, nothing fitted here, {difference} it"
    return {
        "disks": range_of_differences([float(ratio.value) - 1 for ratio in ratios]),
        "sure": f"± {errors} %",
        "corrected": of_corrected,
    }


def _rate_words(cases: Sequence[CoolingCase]) -> dict[str, str]:
    """Return the exact h/(1 - e), over all e and at those of the report."""
    restitutions, exact = exact_rates(1.0, 2)
    rates = span([_number(case, EXACT, "cooling_rate") / (1 - case.value) for case in cases], ".2f")
    return {
        "most": f"{max(exact / (1 - restitutions)):.2f}",
        "rates": rates,
        "rates_of_paper": f"exact h/(1 − e) at these e is {rates}, not 1.45; ",
    }


def _errata_sentence(errata: Sequence[Erratum]) -> str:
    """Return how many of the printed formulas are in error; empty where none was found."""
    if not errata:
        return ""
    count = "Nine" if len(errata) == 9 else str(len(errata))
    return report_words().cooling["errata"].format(count=count)


def _last(case: CoolingCase, source: str, observable: str) -> float:
    """Return the last value of what a source says of an observable."""
    return float(np.ravel(case.theory[source][observable])[-1])


def _number(case: CoolingCase, source: str, observable: str) -> float:
    """Return what a source says of an observable that is one number."""
    return float(case.theory[source][observable])


@dataclass(frozen=True)
class SummaryWriter:
    """Makes the records of one restitution."""

    restitution: float

    def record(self, quantity: str, value: float) -> SummaryRecord:
        """Return a number without an error."""
        return SummaryRecord(quantity, self.restitution, float(value))

    def estimate(self, quantity: str, estimate: Measured) -> SummaryRecord:
        """Return the last value of an estimate."""
        last = estimate.last
        return SummaryRecord(quantity, self.restitution, float(last.value), float(last.error))

    def percent(self, quantity: str, ratio: float) -> SummaryRecord:
        """Return a ratio as the per cent by which it differs from 1."""
        return SummaryRecord(f"{quantity}, %", self.restitution, 100 * (float(ratio) - 1))

    def percent_of_estimate(self, quantity: str, ratio: Measured) -> SummaryRecord:
        """Return the last value of a measured ratio in the same way."""
        last = ratio.last
        percent = 100 * (float(last.value) - 1)
        return SummaryRecord(f"{quantity}, %", self.restitution, percent, 100 * float(last.error))


def _summary(case: CoolingCase, system: Cooling) -> Iterator[SummaryRecord]:
    """Yield what the findings rest on, at one restitution."""
    write = SummaryWriter(case.value)
    if case.cools:
        yield from _summary_of_rates(case, system)
    yield from _summary_of_displacement(case, system)
    if case.cools:
        share = np.maximum.accumulate(
            case.solutions.late.msd_slope / _number(case, EXACT, "msd_slope")
        )
        late_times = case.solutions.late.times
        time = np.exp(np.interp(1 - REACHED_WITHIN, share, np.log(late_times)))
        limit = f"{1 - REACHED_WITHIN:.0%}"
        when = f"time from which d⟨r²⟩/d ln t has {limit} of its limit, d/U"
        yield write.record(when, float(f"{time:.2g}"))
        yield write.record("a₂, exact (a Gaussian has 0)", _number(case, EXACT, "a2"))
    exponent = tail_exponent(case)
    yield write.record("tail exponent n at R = 4 (exponential 1, Gaussian 2)", exponent)
    kurtosis = case.solutions.kinetic.kurtosis[-1]
    yield write.record("kurtosis of the displacement at the end", kurtosis)
    yield write.record("… at 10⁹ d/U", case.solutions.late.kurtosis[-1])
    trapped = float(case.measured[system.hard]["trapped"].value)
    yield write.record("tracers at rest in corners of hard scatterers", trapped)


def tail_exponent(case: CoolingCase) -> float:
    """Return n of the tail exp(-a R^n) of G at `TAIL_RADIUS`, at the last time."""
    exponents, _ = case.solutions.position.position_tail((TAIL_RADIUS,))
    return float(exponents[-1][0])


def _summary_of_rates(case: CoolingCase, system: Cooling) -> Iterator[SummaryRecord]:
    """Yield the cooling rate, exact, and how the start and the density change it."""
    write = SummaryWriter(case.value)
    hard = case.measured[system.hard]["cooling_rate"]
    exact = _number(case, EXACT, "cooling_rate")
    rate = _number(case, KINETIC, "cooling_rate")
    unit = 1.0
    title = "h"
    if system.is_smooth:
        unit = 1 - case.value
        title = "h/(1 − e)"
    yield write.record(f"{title}, exact, late times", exact / unit)
    yield write.percent("… start not yet forgotten", rate / exact)
    yield write.percent_of_estimate("… finite density, measured", hard / rate)
    dense = case.solutions.dense
    if dense is not None:
        rise = 1 / dense.thermal_speed[-1] - 1 / dense.thermal_speed[case.early]
        window = (case.times[-1] - case.times[case.early]) * system.half_rate
        yield write.percent("… finite density, predicted", rise / window / rate)
    yield write.estimate(f"{title}, {system.hard}", hard / unit)


def _summary_of_displacement(case: CoolingCase, system: Cooling) -> Iterator[SummaryRecord]:
    """Yield the free path and <r^2> of hard scatterers beside what theories say."""
    write = SummaryWriter(case.value)
    hard = case.measured[system.hard]
    free_path = hard["free_path"] / _number(case, KINETIC, "free_path")
    yield write.percent_of_estimate("free path over dilute", free_path)
    over_dilute = hard["msd"].last / _last(case, KINETIC, "msd")
    yield write.percent_of_estimate(f"⟨r²⟩ of {system.hard} at the end over dilute", over_dilute)
    dense = case.solutions.dense
    if dense is not None:
        over_corrected = hard["msd"].last / dense.msd[-1]
        yield write.percent_of_estimate("⟨r²⟩ at the end over corrected", over_corrected)
    if FIT in case.theory and case.cools:
        over_walk = hard["msd"].last / _last(case, FIT, "msd")
        yield write.percent_of_estimate("⟨r²⟩ at the end over the paper’s walk", over_walk)
        slope = _number(case, FIT, "msd_slope") / _number(case, EXACT, "msd_slope")
        yield write.percent("late slope of the walk over dilute", slope)


def _claims(cases: Sequence[CoolingCase]) -> list[Claim]:
    """Return what the paper claims, where, whether it holds, and why."""
    exponents = [n for n in map(tail_exponent, cases) if math.isfinite(n)]
    is_exponential = max(exponents, default=math.nan) < EXPONENTIAL_BELOW
    slopes = [_number(case, EXACT, "msd_slope") * math.log(10) for case in cases]
    sentences = {
        "decades": span(slopes, ".3g"),
        "tail": HOLDS if is_exponential else FAILS,
        "a2": span([_number(case, EXACT, "a2") for case in cases], ".2f"),
    }
    return [Claim(*(text.format(**sentences) for text in claim)) for claim in report_words().claims]


# -- driven tracers, and a restitution of the impact speed -----------------------------------------
@dataclass(frozen=True)
class Span:
    """A word of a finding: the range of a quantity of the summary, in a format."""

    quantity: str
    form: str


DRIVEN_SPANS = {
    "diffusion": Span("D", ".4g"),
    "a2": Span("a₂, steady", ".3g"),
    "einstein": Span("μ⟨vₓ²⟩/D", ".4g"),
    "power": Span("local power of t in v₀ at the end", ".3g"),
    "msd": Span("⟨r²⟩ at the end", ".4g"),
    "ratio": Span("D⊥/D∥", ".2f"),
}


def _story_of_driven(cases: Sequence[DrivenCase], system: Driven, table: DataFrame) -> Story:
    """Return the story of driven tracers."""
    records: list[SummaryRecord] = []
    for case in cases:
        for quantity, value in _driven_summary(case).items():
            records.append(SummaryRecord(quantity, case.value, float(value)))
    sentences: dict[str, str] = {"of": system.scatterers}
    for word, wanted in DRIVEN_SPANS.items():
        values = [record.value for record in records if record.quantity == wanted.quantity]
        sentences[word] = span(values, wanted.form)
    for name, strength in system.drive.items():
        sentences[name] = f"{strength:g}"
    sentences["constant"] = f"{float(limiting_drift(0.0, system.dimension)):.4f}"
    words = report_words()
    compared, first, last = (text.format(**sentences) for text in words.driven[system.name])
    agree = agreement(table)
    return Story(
        compared=words.story["driven"].format(what=compared),
        findings=[first, agree, last],
        line=f"Finding: {agree}",
        tables={"summary": records},
    )


def _driven_summary(case: DrivenCase) -> Mapping[str, float]:
    """Return what the findings rest on, by name."""
    if case.state is None:
        return _decay_summary(case)
    if case.state.field:
        return _field_summary(case, case.state.drift)
    state = case.state
    einstein = state.mobility * state.mean_square_along / state.diffusion_coefficient
    return {
        "v₀, steady": state.thermal_speed,
        "a₂, steady": state.a2 if abs(state.a2) > state.rtol else 0.0,
        "collision rate": state.collision_rate,
        "D": state.diffusion_coefficient,
        "mobility μ": state.mobility,
        "μ⟨vₓ²⟩/D": einstein,
    }


def _decay_summary(case: DrivenCase) -> Mapping[str, float]:
    """Return the last averages of tracers that nothing drives."""
    averages = case.theory[SOLVER]
    speeds = np.asarray(averages["thermal_speed"])
    fall = math.log(speeds[-1] / speeds[-3])
    return {
        "v₀ at the end": speeds[-1],
        "⟨r²⟩ at the end": np.asarray(averages["msd"])[-1],
        "local power of t in v₀ at the end": fall / math.log(case.times[-1] / case.times[-3]),
        "a₂ at the end": np.asarray(averages["a2"])[-1],
    }


def _field_summary(case: DrivenCase, drift: float) -> Mapping[str, float]:
    """Return drift and dispersion in a field, and how the drift is reached from rest."""
    averages = case.theory[SOLVER]
    summary = {}
    for name in ("diffusion_parallel", "diffusion_perpendicular", "drift", "mean_speed"):
        summary[_short_name(name)] = float(averages[name])
    parallel = float(averages["diffusion_parallel"])
    perpendicular = float(averages["diffusion_perpendicular"])
    summary["D⊥/D∥"] = perpendicular / parallel
    over_drift: FloatArray = np.asarray(averages["drift_from_rest"]) / drift
    summary["overshoot of ⟨v_z⟩ from rest, %"] = 100 * (float(np.max(over_drift)) - 1)
    is_away = np.flatnonzero(abs(over_drift - 1) > REACHED_WITHIN)
    first_within = int(is_away[-1]) + 1 if is_away.size else 0
    reached_at = math.nan
    if first_within < len(case.times):
        reached_at = float(case.times[first_within])
    summary[f"within {REACHED_WITHIN:.0%} of u from t"] = reached_at
    return summary

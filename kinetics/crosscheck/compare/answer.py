"""The answer: fits become a Comparison. Begin with `answer`.

Of the fits, one for each medium, the likeliest is judged; where data and theory differ, causes are
looked for, and where one of them is another medium, that is shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kinetics.crosscheck.compare.causes import tested_causes
from kinetics.crosscheck.compare.fit import Fit
from kinetics.crosscheck.compare.flat_directions import cannot_tell
from kinetics.crosscheck.compare.judge import Judgement, judge
from kinetics.crosscheck.compare.measured import Measured
from kinetics.crosscheck.compare.media import across_media, media_not_excluded
from kinetics.crosscheck.compare.noted import drifts, never_move, noted
from kinetics.crosscheck.compare.observables import OBSERVABLES
from kinetics.crosscheck.compare.result import OUTCOMES, Comparison, Explanation, Parameter, Row
from kinetics.crosscheck.compare.statistics import root_of_variance
from kinetics.crosscheck.compare.theory import Theory
from kinetics.crosscheck.compare.wrong_unit import wrong_unit
from kinetics.crosscheck.data.sample import Law, Sample
from kinetics.crosscheck.words import Verdict, number, numeral

#: Remark on the densities of dense scatterers, of which there is no theory that is good enough.
NO_DENSITIES = "At a finite density averages alone are compared, with an error of the theory."
#: Remark on a start that is the sample itself.
OWN_START = "The theory starts from the data's own speeds: early densities' p-values are too high."
#: How what drives a tracer is written, by its name in `Law`.
SYMBOLS = {
    "tangential_restitution": "e_t",
    "field": "field",
    "mass_ratio": "M/m",
    "bath_speed": "w",
    "heating": "D_v",
    "drag": "γ",
    "capture_speed": "v_c",
}
#: Differences that are said to be excluded are at most this: a larger limit says nothing.
MAX_WITHIN = 1.0


@dataclass(frozen=True, eq=False)
class JudgedFit:
    """A fit, and the judgement on it at all times of the sample, which is made when it is read."""

    fitted: Fit
    sample: Sample

    @cached_property
    def judgement(self) -> Judgement:
        """The judgement on the fit at all times of its sample."""
        measured = Measured.of(self.sample, self.fitted.measured.layout.names)
        theory = Theory(measured.layout, measured.has_velocities)
        return judge(self.fitted, measured, theory)

    @property
    def medium(self) -> str:
        """The scatterers of the theory."""
        return self.fitted.point.scatterers


def answer(sample: Sample, fits: Sequence[Fit], media: Sequence[str], explain: bool) -> Comparison:
    """Return the comparison of a sample with the likeliest of its fits.

    Parameters
    ----------
    sample : at all its times
    fits : one for each medium that was tried, which look at some of these
    media : that a cause is looked for in
    explain : whether causes of a difference are looked for
    """
    judged = [JudgedFit(fitted, sample) for fitted in fits]
    best = _likeliest(judged)
    found_in_data = never_move(sample) or wrong_unit(fits)
    if found_in_data is None and best.judgement.verdict is Verdict.DIFFERS:
        found_in_data = drifts(sample)  # else a fit would make a restitution of it
    verdict = Verdict.DIFFERS if found_in_data else best.judgement.verdict
    explanations: list[Explanation] = [found_in_data] if found_in_data and explain else []
    if explain and not found_in_data:
        explanations, medium = _explained(best, verdict, media)
        of_medium = [other for other in judged if other.medium == medium]
        if of_medium and medium != best.medium:  # what explains is shown
            best = of_medium[0]
            verdict = best.judgement.verdict
    return _comparison(sample, judged, best, verdict, found_in_data, explanations)


def _likeliest(judged: Sequence[JudgedFit]) -> JudgedFit:
    """Return the likeliest of the fits that agree with the data, or of all."""
    likeliest_first = sorted(judged, key=lambda fit: fit.fitted.criterion)
    for fit in likeliest_first:  # those after one that agrees need no judgement
        if fit.judgement.verdict is Verdict.AGREES:
            return fit
    return likeliest_first[0]


def _explained(
    best: JudgedFit, verdict: Verdict, media: Sequence[str]
) -> tuple[list[Explanation], str]:
    """Return what explains a difference or is to be noted, the likeliest first, and its medium."""
    law = best.sample.law
    if law.is_driven and not law.field:
        return [], best.medium
    medium = best.medium
    explanations: list[Explanation] = []
    if verdict in (Verdict.DIFFERS, Verdict.UNCLEAR):
        tested = tested_causes(best.fitted, media)
        if tested and tested[0].explanation.outcome == "explains":
            medium = tested[0].fitted.point.scatterers
        explanations += [cause.explanation for cause in tested]
    if not law.field:
        explanations += noted(best.fitted, best.judgement.residuals)
    # a stable sort: the likeliest of one outcome stays first
    order = list(OUTCOMES)
    return sorted(explanations, key=lambda item: order.index(item.outcome)), medium


def _comparison(
    sample: Sample,
    judged: Sequence[JudgedFit],
    best: JudgedFit,
    verdict: Verdict,
    found_in_data: Explanation | None,
    explanations: Sequence[Explanation],
) -> Comparison:
    point = best.fitted.point
    judgement = best.judgement
    remarks = [*judgement.remarks]
    if point.has_own_start and judgement.has_densities:
        remarks.append(OWN_START)
    if point.scatterers != "dilute":
        remarks.append(NO_DENSITIES)
    cause = found_in_data
    if cause is None and verdict is not Verdict.AGREES and explanations:
        likeliest = explanations[0]
        if likeliest.outcome in ("explains", "found") and likeliest.headline:
            cause = likeliest
    fits = [other.fitted for other in judged]
    not_excluded = media_not_excluded(best.fitted, fits, not sample.has_velocities)
    values, _, covariance = across_media(best.fitted, not_excluded)
    reported = replace(best.fitted, point=values, covariance=covariance)
    parameters = _parameters(reported, verdict, found_in_data)
    averages = best.fitted.chi_square
    clock = best.fitted.clock
    unknown = cannot_tell(reported.names, reported.covariance, "these data")
    return Comparison(
        verdict=verdict,
        summary=_summary(best, parameters, verdict, cause),
        parameters=parameters,
        initial=point.start_in_words,
        samples=best.fitted.measured.n_tracers,
        groups=sample.groups,
        grouping=sample.grouping,
        names=sample.names,
        warnings=(*sample.warnings, *remarks),
        tests=tuple(test._replace(time=_scaled_time(test.time, clock)) for test in judgement.tests),
        explanations=tuple(explanations),
        numbers=tuple(_row_on_clock(row, clock) for row in judgement.rows),
        medium=point.scatterers,
        covariance=_covariance_of_two(reported),
        overall_p_value=judgement.p_value,
        chi_square=None if averages is None else averages.value,
        dof=None if averages is None else averages.freedom,
        units=_units(sample, clock),
        dimension=sample.law.dimension,
        unit_names=dict(sample.unit_names),
        cannot_tell=unknown,
        media=_chi_squares(judged),
        undecided=tuple(fit.point.scatterers for fit in not_excluded),
        n_times=int(sample.times.size),
        first_time=clock * float(sample.times[0]),
        last_time=clock * float(sample.times[-1]),
        next_step=_next_step(verdict, cause, unknown),
    )


def _scaled_time(time: float | None, clock: float) -> float | None:
    return None if time is None else time * clock


def _row_on_clock(row: Row, clock: float) -> Row:
    """Return a row with its times in d/U of the fitted U."""
    if clock == 1.0:
        return row
    return row._replace(time=row.time * clock, since=_scaled_time(row.since, clock))


def _units(sample: Sample, clock: float) -> dict[str, float]:
    """Return d, U and d/U in the data's units; none if the data have them themselves."""
    units = dict(sample.units)
    if clock == 1.0:
        return units
    return {
        "length": units.get("length", 1.0),
        "speed": _unit_of_fitted_speed(sample) * clock,
        "time": units.get("time", 1.0) / clock,
    }


def _unit_of_fitted_speed(sample: Sample) -> float:
    """Return what a fitted U is in units of: the unit of length over that of time.

    That is not the unit of speed where a unit of time was specified beside it.
    """
    return sample.units.get("length", 1.0) / sample.units.get("time", 1.0)


def _chi_squares(judged: Sequence[JudgedFit]) -> dict[str, tuple[float, int]]:
    """Return the chi-square of all averages and its degrees of freedom, by medium."""
    chi_squares = {}
    for fit in judged:
        chi_square = fit.fitted.chi_square
        if chi_square is not None:
            chi_squares[fit.medium] = (chi_square.value, chi_square.freedom)
    return chi_squares


def _covariance_of_two(fitted: Fit) -> tuple[tuple[float, ...], ...]:
    """Return the covariance of those that were fitted of e and ln l."""
    chosen = [index for index, name in enumerate(fitted.names) if name in ("restitution", "path")]
    return tuple(map(tuple, fitted.covariance[np.ix_(chosen, chosen)].tolist()))


def _next_step(verdict: Verdict, cause: Explanation | None, unknown: tuple[str, ...]) -> str:
    """Return what to do next, in one sentence; empty where nothing is left."""
    if cause is not None and cause.outcome == "found":
        return "Mend the data, or say their units, and compare again."
    if cause is not None:
        return "Check what the likeliest cause names, specify it, and compare again."
    if verdict is Verdict.DIFFERS:
        return "Look at the rows that deviate (--rows) and at how the data were made."
    if verdict is Verdict.UNCLEAR:
        return "Measure more tracers: half the error decides."
    if verdict is Verdict.NOT_TESTED:
        return "Measure more independent tracers or media."
    if unknown:
        return "Measure closer frames at the beginning, or longer tracks, or specify a number."
    return ""


def _parameters(
    fitted: Fit, verdict: Verdict, found_in_data: Explanation | None
) -> dict[str, Parameter]:
    """Return the numbers of the theory; those that were fitted have standard errors."""
    why_none = ""
    if verdict is Verdict.DIFFERS:
        why_none = found_in_data.headline if found_in_data else "the model does not fit"
    point = fitted.point
    law = fitted.measured.sample.law
    parameters = {
        "restitution": _parameter(fitted, "restitution", point.restitution, why_none),
        "number_density": _parameter(fitted, "path", law.free_path(point.path), why_none),
        "mean_free_path": _parameter(fitted, "path", point.path, why_none),
    }
    if "path" not in fitted.names:
        parameters["mean_free_path"] = Parameter(point.path, None, "from ρ₀")
    units = fitted.measured.sample.units
    if "speed_unit" in fitted.names:
        speed = _parameter(fitted, "speed_unit", point.speed_unit, why_none)
        unit = _unit_of_fitted_speed(fitted.measured.sample)
        parameters["speed_unit"] = speed.in_unit(unit)
    if "position_noise" in fitted.names:
        deviation, error = root_of_variance(*fitted.value("position_noise"))
        position_error = Parameter(deviation, error, "fitted")
        if why_none:
            position_error = Parameter(None, None, f"no value: {why_none}")
        parameters["position_error"] = position_error.in_unit(units.get("length", 1.0))
    return parameters


def _parameter(fitted: Fit, name: str, value: Any, why_none: str) -> Parameter:
    """Return one number: specified, fitted, or without a value."""
    if callable(value):
        return Parameter(None, None, f"told: {value}")
    if name not in fitted.names:
        return Parameter(value, None, "told")
    if why_none:
        shown = numeral(value, ".5g")
        return Parameter(None, None, f"no value: {why_none}; the theory that is shown has {shown}")
    at, error = fitted.value(name)
    if at:
        error = error * value / at  # the density has the relative error of the path
    has_velocities = fitted.measured.has_velocities
    source = "fitted to v₀ and ⟨r²⟩ over time" if has_velocities else "fitted to positions"
    return Parameter(value, error, source)


# -- in words --------------------------------------------------------------------------------------
def _summary(
    best: JudgedFit,
    parameters: dict[str, Parameter],
    verdict: Verdict,
    cause: Explanation | None,
) -> str:
    """Return what was fitted, the verdict, and what was compared."""
    sentences = [_verdict_in_words(best, parameters, verdict, cause)]
    sentences.append(_what_was_compared(best))
    clearest = _clearest_deviation(best.judgement, best.fitted.clock)
    if clearest:
        sentences.append(clearest)
    return " ".join(sentences)


def _verdict_in_words(
    best: JudgedFit,
    parameters: dict[str, Parameter],
    verdict: Verdict,
    cause: Explanation | None,
) -> str:
    if cause is not None and cause.outcome == "found":
        return f"They differ. Look at the data first: {cause.headline}."
    explains = f"; {cause.headline} explains it" if cause else ""
    n_groups = best.sample.groups
    words = {
        Verdict.AGREES: f"No difference seen, better than {_excluded(best.judgement)}.",
        Verdict.UNCLEAR: f"A difference is possible, more samples would show it{explains}.",
        Verdict.DIFFERS: f"They differ{explains}.",
        Verdict.NOT_TESTED: (
            f"Not tested: {n_groups} independent groups are too few for errors this large."
        ),
    }
    text = words.get(verdict, "Nothing could be tested.")
    fitted = _fitted_in_words(parameters)
    return f"{fitted}, fitted. {text}" if fitted else text


def _excluded(judgement: Judgement) -> str:
    """Return what differences the data exclude, by observable."""
    excluded = []
    for test in judgement.tests:
        is_informative = test.within is not None and test.within <= MAX_WITHIN
        if is_informative and test.verdict is Verdict.AGREES:
            assert test.within is not None
            form = ".2g" if test.within < 0.001 else ".2%"
            within = numeral(test.within, form)
            excluded.append(f"{within} for {OBSERVABLES[test.observable].text}")
    return ", ".join(excluded) or "no average"


def _fitted_in_words(parameters: dict[str, Parameter]) -> str:
    """Return the values that were fitted."""
    symbols = {"restitution": "e", "number_density": "ρ₀"}
    values = []
    for name, symbol in symbols.items():
        parameter = parameters[name]
        if parameter.error is not None:
            values.append(f"{symbol} = {number(parameter.value, parameter.error)}")
    return " and ".join(values)


def _what_was_compared(best: JudgedFit) -> str:
    sample = best.sample
    point = best.fitted.point
    clock = best.fitted.clock
    first = numeral(clock * sample.times[0], ".4g")
    last = numeral(clock * sample.times[-1], ".4g")
    n_tracers = best.fitted.measured.n_tracers
    system = f"{_medium_in_words(best)}, {_system_in_words(best)}"
    return (
        f"{n_tracers} tracers at {sample.times.size} times from {first} to {last} d/U, compared "
        f"with the kinetic equation for {system}, from {point.start_in_words}."
    )


def _medium_in_words(best: JudgedFit) -> str:
    """Return the scatterers of the theory: "dilute scatterers", "hard disks"."""
    return "dilute scatterers" if best.medium == "dilute" else best.medium


def _system_in_words(best: JudgedFit) -> str:
    """Return the numbers of the theory in a clause."""
    law = best.sample.law
    point = best.fitted.point
    values: dict[str, Any] = {"e": point.restitution, "ρ₀": law.free_path(point.path)}
    for name, symbol in SYMBOLS.items():
        if getattr(law, name) != getattr(Law, name):
            values[symbol] = getattr(law, name)
    shown = []
    for symbol, value in values.items():
        text = str(value) if callable(value) else numeral(value, ".6g")
        shown.append(f"{symbol} = {text}")
    return ", ".join(shown)


def _clearest_deviation(judgement: Judgement, clock: float) -> str:
    """Return the test that differs most, in a sentence; empty if all agree.

    clock : see `Fit.clock`
    """
    no_difference = (Verdict.AGREES, Verdict.NOT_TESTED)
    different = [test for test in judgement.tests if test.verdict not in no_difference]
    if not different:
        return ""
    clearest = min(different, key=lambda test: test.p_value)
    at = ""
    if clearest.time is not None:
        at = f" at t = {numeral(clock * clearest.time, '.4g')}"
    return (
        f"Of {len(judgement.tests)} tests {len(different)} do not agree; the clearest is "
        f"{clearest.observable}{at}: chi-square {numeral(clearest.chi_square, '.4g')} with "
        f"{clearest.dof} degrees of freedom, p = {numeral(clearest.p_value, '.2g')}."
    )

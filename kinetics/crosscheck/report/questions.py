"""The paper's claims as questions, each answered in numbers with their errors.

The sentences stand in `../templates/report.txt.j2`, one block for each question.
"""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from kinetics import ScalingSolution, sonine
from kinetics.crosscheck.numerals import numeral
from kinetics.crosscheck.report.case import Case, Measured
from kinetics.crosscheck.report.figure_lines import Results, exact_states, restitutions
from kinetics.crosscheck.report.observables import (
    LARGEST_EXPONENT_ERROR,
    band_middles,
    bands_of,
    bin_average,
    cooling_rate_between,
    gaussian_vdf,
    msd_slope_between,
    printed_msd_slopes,
    sure_density,
)
from kinetics.crosscheck.report.row import OBSERVABLES, Row
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.verdicts import corrected_sigmas, worst

Answer = dict[str, Any]
CLOSE_TO_LIMIT = 0.99
"""Share of its limit at which d<r^2>/d ln t counts as reached."""
TAIL_REGION = (2.0, 4.0)
"""R between which the tail of G(R) is read and fitted."""
LEAST_POINTS = 10
"""Points of the tail region that a fit needs."""
CLEARLY_ABOVE = 1.1
"""Local exponent above which a tail is not called exponential."""
SHOWN_DISTANCES = (1.0, 2.0, 3.0, 4.0)


def all_answers(
    cases: Sequence[Case], rows: Sequence[Row], settings: ReportSettings
) -> list[Answer]:
    """Question, answer in words, and the numbers behind it; none if no restitution cools.

    Of another law than the paper's the questions are the same, without its printed formulas.

    Each number has a name, a unit, a restitution (None for all), a value and a standard error (None
    for what has none).
    """
    cooling = [case for case in cases if case.exact is not None]
    if not cooling:
        return []
    results = Results(cooling, settings)
    first = _proportional if settings.is_papers_law else _cooling
    questions = (first, _gaussian, _logarithmic, _exponential)
    answers = [answer(results) for answer in questions]
    return [*answers, _approximations(rows)] if settings.is_papers_law else answers


def _answer(block: str, numbers: list[dict[str, Any]], **values: Any) -> Answer:
    question, answer = paragraphs("report.txt.j2", block, **values)
    return {"question": question, "answer": answer, "numbers": numbers}


def _numbers(
    restitution: float | None, found: Mapping[str, float | Measured], unit: str = ""
) -> list[dict[str, Any]]:
    """The numbers of one restitution, by name."""
    numbers = []
    for name, number in found.items():
        value, error = number, None
        if isinstance(number, Measured):
            value, error = float(number.value), float(number.error)
        numbers.append(
            {"name": name, "unit": unit, "restitution": restitution, "value": value, "error": error}
        )
    return numbers


def _proportional(results: Results) -> Answer:
    e = restitutions()
    ratio = np.array([state.cooling_rate for state in exact_states()]) / (1 - e)
    numbers = []
    for case in results.cases:
        rates: dict[str, Any] = {"exact, t → ∞": case.scaling_state[0].cooling_rate}
        rates["kinetic equation, last decade"] = _rate_of_last_decade(case, results.settings)
        rates |= {run.name: run.cooling_rate for run in case.runs}
        scale = 1 - case.restitution
        over = {f"h/(1 - e), {name}": rate / scale for name, rate in rates.items()}
        numbers += _numbers(case.restitution, over)
    high, fit = int(np.argmax(ratio)), sonine.FITTED_COOLING_FACTOR
    limits = {"elastic": 4 / 3, "high": ratio[high], "inelastic": math.sqrt(2)}
    return _answer("proportional", numbers, at=e[high], fit=fit, **limits)


def _cooling(results: Results) -> Answer:
    """In place of `_proportional`, for laws that the paper does not have."""
    settings, e = results.settings, restitutions()
    states = exact_states(settings.tangential_restitution, settings.dimension)
    numbers = []
    for case in results.cases:
        exact, solver = case.scaling_state
        rates: dict[str, Any] = {"exact, t → ∞": exact.cooling_rate, "solver": solver.cooling_rate}
        rates["kinetic equation, last decade"] = _rate_of_last_decade(case, settings)
        rates |= {run.name: run.cooling_rate for run in case.runs}
        numbers += _numbers(case.restitution, {f"h, {name}": h for name, h in rates.items()})
    first, last = (states[k].cooling_rate for k in (0, -1))
    ends = {"first": first, "last": last, "ratio": last / (1 - e[-1]), "last_e": e[-1]}
    return _answer("cooling", numbers, **ends, **results.words)


def _rate_of_last_decade(case: Case, settings: ReportSettings) -> float:
    """h of the kinetic equation over the same window of times as the particles' values."""
    speed = case.kinetic.thermal_speed
    return cooling_rate_between(case.times, speed, case.early, settings.half_rate)


def _gaussian(results: Results) -> Answer:

    numbers, away, root = [], [], math.nan
    if results.is_papers_law:
        root = float(brentq(lambda e: ScalingSolution(e).a2, 0.1, 0.99))
        numbers = _numbers(None, {"e at which the exact a2 is 0": root})
    for case in results.cases:
        e, run = case.restitution, case.free
        found = {"a2, exact, t → ∞": case.scaling_state[0].a2}
        found["a2, kinetic equation, last time"] = float(case.kinetic.a2[-1])
        measured = {f"a2, {either.name}": either.a2[-1] for either in case.runs}
        numbers += _numbers(e, {**found, **measured})
        vdf = partial(gaussian_vdf, dimension=case.dimension)
        gaussian = bin_average(vdf, case.speed_edges, case.dimension)
        look = worst(run.vdf.value, run.vdf.error, gaussian)
        if look is None:
            continue
        sigmas = corrected_sigmas(look.sigmas, run.groups, look.looks)
        ratio = run.vdf[look.index] / gaussian[look.index]
        off = Measured(100 * (ratio.value - 1), 100 * ratio.error)
        numbers += _numbers(e, {f"F/Gaussian - 1 in its worst bin, {run.name}": off}, "%")
        numbers += _numbers(e, {"its sigmas, corrected for the bins looked at": sigmas}, "σ")
        away.append(sigmas)
    return _answer("gaussian", numbers, root=root, away=away, **results.words)


def _logarithmic(results: Results) -> Answer:
    numbers, errors, times = [], [], []
    for case in results.cases:
        e, late, limit = case.restitution, case.late, case.late_msd_slope
        decade = msd_slope_between(case.times, case.kinetic.msd, case.early)
        share = np.maximum.accumulate(late.msd_slope / limit)
        close = float(np.exp(np.interp(CLOSE_TO_LIMIT, share, np.log(late.times))))
        limits = {"exact": limit}
        if results.is_papers_law:
            walk, printed = printed_msd_slopes(e, 1 / (2 * late.scene.mean_free_path))
            limits |= {"random walk as printed": walk, "Sonine as printed": printed}
            errors.append(100 * (walk / limit - 1))
        means = {"kinetic equation": decade} | {run.name: run.msd_slope for run in case.runs}
        reached = {f"time from which it has {CLOSE_TO_LIMIT:.0%} of the limit": close}
        numbers += _numbers(e, {f"late slope, {k}": v for k, v in limits.items()}, "d²")
        numbers += _numbers(e, reached, "d/U")
        over = {f"mean slope over the last decade, {k}": v for k, v in means.items()}
        numbers += _numbers(e, over, "d²")
        times.append(close)
    found = {"share": CLOSE_TO_LIMIT, "times": times, "errors": errors}
    return _answer("logarithmic", numbers, **found, **results.words)


def _exponential(results: Results) -> Answer:
    cases = results.cases
    numbers: list[dict[str, Any]] = []
    growth, near, fits, ends = [], [], [], []
    last = numeral(cases[0].late.times[-1], ".0e")
    for case in cases:
        exponents, slopes = case.position.position_tail(SHOWN_DISTANCES)
        n, rate = exponents[-1].tolist(), slopes[-1].tolist()
        found = {f"n at R = {x:g}": n_x for x, n_x in zip(SHOWN_DISTANCES, n, strict=True)}
        found |= {f"−d ln p/dR at R = {SHOWN_DISTANCES[k]:g}": rate[k] for k in (1, 3)}
        found = {f"{name}, kinetic equation": x for name, x in found.items()} | _bands(case)
        known, density = sure_density(case, np.linspace(*TAIL_REGION, 41))
        if results.is_papers_law and known.size >= LEAST_POINTS:
            fit = sonine.fit_position(known, density, "tail")
            fits.append(fit)
            found["η of eq. (58) fitted to the kinetic equation"] = fit.eta
            found["γ of the same fit"] = fit.gamma
        late = float(case.late.kurtosis[-1])
        found["kurtosis at the last time, kinetic equation"] = float(case.kinetic.kurtosis[-1])
        end = f"kurtosis at t = {last} d/U, kinetic equation"
        numbers += _numbers(case.restitution, found | {end: late})
        growth.append(100 * (rate[3] / rate[1] - 1))
        near.append(n[3])
        ends.append(late)
    lowest = min([v for v in near if math.isfinite(v)], default=math.nan)
    return _answer(
        "exponential", numbers, nearly=lowest < CLEARLY_ABOVE, growth=growth, near=near, fits=fits,
        region=TAIL_REGION, eta=sonine.TAIL_ETA, gamma=sonine.TAIL_GAMMA, ends=ends, last=last,
        limit=results.gaussian_kurtosis, **results.words,
    )  # fmt: skip


def _bands(case: Case) -> dict[str, float | Measured]:
    """The local exponent between bands of R: equation and Boltzmann-Grad particles."""
    theory, measured = bands_of(case), case.free.tail_exponent
    found: dict[str, float | Measured] = {}
    seen = (measured.error > 0) & (measured.error < LARGEST_EXPONENT_ERROR)
    for k in np.flatnonzero(seen):
        name = f"n over bands around R = {band_middles(case.dimension)[k]:.2f}"
        found[f"{name}, kinetic equation"] = float(theory[k])
        found[f"{name}, {case.free.name}"] = measured[k]
    return found


def _approximations(rows: Sequence[Row]) -> Answer:
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row.kind == "approximation":
            name = f"{row.source} for {OBSERVABLES[row.observable].short}, against {row.against}"
            groups.setdefault(name, []).append(row)
    numbers: list[dict[str, Any]] = []
    deviations: dict[str, list[float]] = {}
    for name, same in groups.items():
        deviations[name.rsplit(",", 1)[0]] = [100 * row.deviation for row in same]
        for row in same:
            numbers += _numbers(row.restitution, {name: 100 * row.deviation}, "%")
    return _answer("approximations", numbers, deviations=deviations)

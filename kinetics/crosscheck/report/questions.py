"""The paper's claims as questions, each answered in numbers with their errors.

The sentences stand in `../templates/report.txt.j2`, one block for each question.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Case, Measured
from kinetics.crosscheck.report.figure_lines import exact_states, restitutions
from kinetics.crosscheck.report.observables import (
    band_middles,
    bands_of,
    bin_average,
    msd_slope_between,
    printed_msd_slopes,
    sure_density,
)
from kinetics.crosscheck.report.row import OBSERVABLES, Row
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
LARGEST_EXPONENT_ERROR = 0.5
"""Standard error of a measured exponent above which it is left out."""
SHOWN_DISTANCES = (1.0, 2.0, 3.0, 4.0)


def all_answers(cases: Sequence[Case], rows: Sequence[Row]) -> list[Answer]:
    """Question, answer in words, and the numbers behind it; none if no restitution cools.

    Each number has a name, a unit, a restitution (None for all), a value and a standard error (None
    for what has none).
    """
    cooling = [case for case in cases if case.exact is not None]
    if not cooling:
        return []
    return [
        _proportional(cooling),
        _gaussian(cooling),
        _logarithmic(cooling),
        _exponential(cooling),
        _approximations(rows),
    ]


def _answer(block: str, numbers: list[dict[str, Any]], **values: Any) -> Answer:
    question, answer = paragraphs("report.txt.j2", block, **values)
    return {"question": question, "answer": answer, "numbers": numbers}


def _number(
    name: str, restitution: float | None, value: float | Measured, unit: str = ""
) -> dict[str, Any]:
    return {
        "name": name,
        "unit": unit,
        "restitution": restitution,
        "value": float(value.value) if isinstance(value, Measured) else value,
        "error": float(value.error) if isinstance(value, Measured) else None,
    }


def _proportional(cases: Sequence[Case]) -> Answer:
    e = restitutions()
    ratio = np.array([state.cooling_rate for state in exact_states()]) / (1 - e)
    numbers = []
    for case in cases:
        scale, at = 1 - case.restitution, case.restitution
        numbers.append(_number("h/(1 - e), exact", at, case.scaling_state[0].cooling_rate / scale))
        numbers += [
            _number(f"h/(1 - e), {run.name}", at, run.cooling_rate / scale) for run in case.runs
        ]
    high, fit = int(np.argmax(ratio)), sonine.FITTED_COOLING_FACTOR
    limits = {"elastic": 4 / 3, "high": ratio[high], "inelastic": math.sqrt(2)}
    return _answer("proportional", numbers, at=e[high], fit=fit, **limits)


def _gaussian(cases: Sequence[Case]) -> Answer:
    from scipy.optimize import brentq

    from kinetics import ScalingSolution

    root = float(brentq(lambda e: ScalingSolution(e).a2, 0.1, 0.99))
    numbers, away = [_number("e at which the exact a2 is 0", None, root)], []
    for case in cases:
        e, run = case.restitution, case.free
        numbers.append(_number("a2, exact", e, case.scaling_state[0].a2))
        numbers += [_number(f"a2, {either.name}", e, either.a2[-1]) for either in case.runs]
        gaussian = bin_average(lambda c: sonine.vdf(c, 0.0), case.speed_edges)
        look = worst(run.vdf.value, run.vdf.error, gaussian)
        if look is None:
            continue
        sigmas = corrected_sigmas(look.sigmas, run.groups, look.looks)
        ratio = run.vdf[look.index] / gaussian[look.index]
        off = Measured(100 * (ratio.value - 1), 100 * ratio.error)
        numbers += [
            _number(f"F/Gaussian - 1 in its worst bin, {run.name}", e, off, "%"),
            _number("its sigmas, corrected for the bins looked at", e, sigmas),
        ]
        away.append(sigmas)
    return _answer("gaussian", numbers, root=root, away=away)


def _logarithmic(cases: Sequence[Case]) -> Answer:
    numbers: list[dict[str, Any]] = []
    errors, times = [], []
    for case in cases:
        e, late, limit = case.restitution, case.late, case.late_msd_slope
        decade = msd_slope_between(case.times, case.kinetic.msd, case.early)
        share = np.maximum.accumulate(late.msd_slope / limit)
        close = float(np.exp(np.interp(CLOSE_TO_LIMIT, share, np.log(late.times))))
        walk, printed = printed_msd_slopes(e, 1 / (2 * late.scene.mean_free_path))
        mean = "mean slope over the last decade"
        slopes: dict[str, float | Measured] = {
            "late slope, exact": limit,
            "late slope, random walk as printed": walk,
            "late slope, Sonine as printed": printed,
            f"time from which it has {CLOSE_TO_LIMIT:.0%} of the limit": close,
            f"{mean}, kinetic equation": decade,
            **{f"{mean}, {run.name}": run.msd_slope for run in case.runs},
        }
        numbers += [
            _number(name, e, value, "d/U" if name.startswith("time") else "d²")
            for name, value in slopes.items()
        ]
        errors.append(100 * (walk / limit - 1))
        times.append(close)
    return _answer("logarithmic", numbers, share=CLOSE_TO_LIMIT, times=times, errors=errors)


def _exponential(cases: Sequence[Case]) -> Answer:
    numbers: list[dict[str, Any]] = []
    growth, near, fits, ends = [], [], [], []
    for case in cases:
        e, last = case.restitution, f"{case.late.times[-1]:.0e}"
        exponents, slopes = case.position.position_tail(SHOWN_DISTANCES)
        n, rate = exponents[-1], slopes[-1]
        known, density = sure_density(case, np.linspace(*TAIL_REGION, 41))
        found = {
            f"n at R = {x:g}": float(n_x) for x, n_x in zip(SHOWN_DISTANCES, n, strict=True)
        } | {f"−d ln p/dR at R = {SHOWN_DISTANCES[k]:g}": float(rate[k]) for k in (1, 3)}
        numbers += [_number(f"{name}, kinetic equation", e, x) for name, x in found.items()]
        numbers += _bands(case)
        if known.size >= LEAST_POINTS:
            fit = sonine.fit_position(known, density, "tail")
            fits.append(fit)
            numbers += [
                _number("η of eq. gammatailg fitted to the kinetic equation", e, fit.eta),
                _number("γ of the same fit", e, fit.gamma),
            ]
        at_last, late = (float(s.kurtosis[-1]) for s in (case.kinetic, case.late))
        numbers += [
            _number("kurtosis at the last time, kinetic equation", e, at_last),
            _number(f"kurtosis at t = {last} d/U, kinetic equation", e, late),
        ]
        growth.append(100 * float(rate[3] / rate[1] - 1))
        near.append(float(n[3]))
        ends.append(late)
    lowest = min([v for v in near if math.isfinite(v)], default=math.nan)
    return _answer(
        "exponential", numbers, nearly=lowest < CLEARLY_ABOVE, growth=growth, near=near, fits=fits,
        region=TAIL_REGION, eta=sonine.TAIL_ETA, gamma=sonine.TAIL_GAMMA, ends=ends,
        last=f"{cases[0].late.times[-1]:.0e}",
    )  # fmt: skip


def _bands(case: Case) -> list[dict[str, Any]]:
    """The local exponent between bands of R: equation and Boltzmann-Grad particles."""
    theory, measured, numbers = bands_of(case), case.free.tail_exponent, []
    seen = (measured.error > 0) & (measured.error < LARGEST_EXPONENT_ERROR)
    for k in np.flatnonzero(seen):
        name = f"n over bands around R = {band_middles()[k]:.2f}"
        numbers += [
            _number(f"{name}, kinetic equation", case.restitution, float(theory[k])),
            _number(f"{name}, {case.free.name}", case.restitution, measured[k]),
        ]
    return numbers


def _approximations(rows: Sequence[Row]) -> Answer:
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row.kind == "approximation":
            name = f"{row.source} for {OBSERVABLES[row.observable].short}"
            groups.setdefault(f"{name}, against {row.against}", []).append(row)
    numbers = [
        _number(name, row.restitution, 100 * row.deviation, "%")
        for name, same in groups.items()
        for row in same
    ]
    deviations = {
        name.rsplit(",", 1)[0]: [100 * row.deviation for row in same]
        for name, same in groups.items()
    }
    return _answer("approximations", numbers, deviations=deviations)

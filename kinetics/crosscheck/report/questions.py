"""The paper's claims as questions, each answered in numbers with their errors."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.report.case import Case, Measured, ParticleEvidence
from kinetics.crosscheck.report.case_rows import sonine_slopes
from kinetics.crosscheck.report.figure_lines import all_restitutions
from kinetics.crosscheck.report.histograms import band_middles
from kinetics.crosscheck.report.observables import bands_of, sure_density
from kinetics.crosscheck.report.page import SHORT
from kinetics.crosscheck.report.row import Row, bin_average, msd_slope_between
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


def _number(
    name: str,
    restitution: float | None,
    value: float,
    error: float | None = None,
    unit: str = "",
) -> dict[str, Any]:
    return {
        "name": name,
        "unit": unit,
        "restitution": restitution,
        "value": value,
        "error": error,
    }


def _measured(
    name: str, restitution: float, run: ParticleEvidence, m: Measured, unit: str = ""
) -> dict[str, Any]:
    return _number(f"{name}, {run.name}", restitution, float(m.value), float(m.error), unit)


def _range(values: Sequence[float], form: str) -> str:
    """Smallest to largest of some numbers, as a sentence says it."""
    known = [v for v in values if math.isfinite(v)]
    if not known:
        return "–"
    low, high = (format(f(known), form) for f in (min, max))
    return low if low == high else f"{low} to {high}"


def _scaled(measured: Measured, scale: float) -> Measured:
    return Measured(measured.value / scale, measured.error / scale)


def _proportional(cases: Sequence[Case]) -> Answer:
    from kinetics.scaling.closed_form import ScalingSolution

    e = all_restitutions()
    ratio = np.array([ScalingSolution(float(x)).cooling_rate for x in e]) / (1 - e)
    high = int(np.argmax(ratio))
    free = [_scaled(case.free.cooling_rate, 1 - case.restitution) for case in cases]
    disks = [_scaled(case.disks.cooling_rate, 1 - case.restitution) for case in cases]
    exact = [case.exact.cooling_rate / (1 - case.restitution) for case in cases if case.exact]
    numbers = []
    for case, h, free_h, disk_h in zip(cases, exact, free, disks, strict=True):
        at = case.restitution
        numbers += [
            _number("h/(1 - e), exact", at, h),
            _measured("h/(1 - e)", at, case.free, free_h),
            _measured("h/(1 - e)", at, case.disks, disk_h),
        ]
    spread = ratio[high] / (4 / 3) - 1
    fit = sonine.FITTED_COOLING_FACTOR
    above = fit / ratio[high] - 1, fit / (4 / 3) - 1
    return {
        "question": "Is h(e) proportional to 1 − e?",
        "answer": (
            f"Not exactly. h/(1 − e) is {math.sqrt(2):.4f} at e = 0, rises to {ratio[high]:.4f} at "
            f"e = {e[high]:.2f} and falls to 4/3 as e → 1, a spread of {100 * spread:.1f} %. "
            f"The paper's {fit} lies "
            f"{100 * above[0]:.1f} to {100 * above[1]:.1f} % above it everywhere. Particle values "
            "are the slope of 1/v₀ over the last decade of time, hard disks read with l = 1/(2dρ₀) "
            "as the paper reads them: that is what lifts them towards 1.45."
        ),
        "numbers": numbers,
    }


def _gaussian(cases: Sequence[Case]) -> Answer:
    from scipy.optimize import brentq

    from kinetics.scaling.closed_form import ScalingSolution

    root = float(brentq(lambda e: ScalingSolution(e).a2, 0.1, 0.99))
    numbers, away = [_number("e at which the exact a2 is 0", None, root)], []
    for case in cases:
        assert case.exact is not None
        e, run = case.restitution, case.free
        last = Measured(run.a2.value[-1], run.a2.error[-1])
        numbers += [_number("a2, exact", e, case.exact.a2), _measured("a2", e, run, last)]
        disks = Measured(case.disks.a2.value[-1], case.disks.a2.error[-1])
        numbers.append(_measured("a2", e, case.disks, disks))
        gaussian = bin_average(lambda c: sonine.vdf(c, 0.0), case.speed_edges)
        look = worst(run.vdf.value, run.vdf.error, gaussian)
        if look is None:
            continue
        sigmas = corrected_sigmas(look.sigmas, run.groups, look.looks)
        off = run.vdf.value[look.index] / gaussian[look.index] - 1
        error = 100 * float(run.vdf.error[look.index] / gaussian[look.index])
        name = "F/Gaussian - 1 in its worst bin"
        numbers += [
            _measured(name, e, run, Measured(np.asarray(100 * off), np.asarray(error)), "%"),
            _number("its sigmas, corrected for the bins looked at", e, sigmas),
        ]
        away.append(sigmas)
    return {
        "question": "Is the velocity distribution Gaussian?",
        "answer": (
            "No. A Gaussian has a₂ = 0, which the exact a₂ of the scaling state only crosses, at "
            f"e = {root:.4f}. Even there F(0) = 0, as for every e above 0, where the Gaussian has "
            "1/π, and the tail is exponential."
            + (f" Boltzmann-Grad particles exclude it by {_range(away, '.0f')}σ." if away else "")
        ),
        "numbers": numbers,
    }


def _logarithmic(cases: Sequence[Case]) -> Answer:
    numbers: list[dict[str, Any]] = []
    errors, times = [], []
    for case in cases:
        assert case.exact is not None
        e, late = case.restitution, case.late
        density = 1 / (2 * late.scene.mean_free_path)
        limit = case.exact.diffusion_slope * late.scene.mean_free_path**2
        decade = msd_slope_between(case.times, case.kinetic.msd, case.early)
        share = np.maximum.accumulate(late.msd_slope / limit)
        close = float(np.exp(np.interp(CLOSE_TO_LIMIT, share, np.log(late.times))))
        walk, printed = sonine_slopes(e, density)
        numbers += [
            _number("late slope, exact", e, limit, unit="d²"),
            _number("late slope, random walk as printed", e, walk, unit="d²"),
            _number("late slope, Sonine as printed", e, printed, unit="d²"),
            _number(f"time from which it has {CLOSE_TO_LIMIT:.0%} of the limit", e, close,
                    unit="d/U"),
            _number("mean slope over the last decade, kinetic equation", e, decade, unit="d²"),
            *(_measured("mean slope over the last decade", e, run, run.msd_slope, "d²")
              for run in (case.free, case.disks)),
        ]  # fmt: skip
        errors.append(100 * (walk / limit - 1))
        times.append(close)
    return {
        "question": "Does the mean square displacement grow as ln t, and with which slope?",
        "answer": (
            "In the end, yes: the slope d⟨r²⟩/d ln t tends to 2l²/(κ(1 − ⟨cos χ⟩)), of which the "
            f"kinetic equation has {CLOSE_TO_LIMIT:.0%} from t = {_range(times, '.2g')} d/U on, "
            "later than most of the paper's data. The random walk as printed is off by "
            f"{_range(errors, '+.0f')} % in the limit."
        ),
        "numbers": numbers,
    }


def _exponential(cases: Sequence[Case]) -> Answer:
    numbers: list[dict[str, Any]] = []
    growth, near, fits, ends = [], [], [], []
    at = band_middles()
    r = np.linspace(*TAIL_REGION, 41)
    for case in cases:
        e = case.restitution
        exponents, slopes = case.position.position_tail(SHOWN_DISTANCES)
        n, rate = exponents[-1], slopes[-1]
        for x, exponent in zip(SHOWN_DISTANCES, n, strict=True):
            numbers.append(_number(f"n at R = {x:g}, kinetic equation", e, float(exponent)))
        for k in (1, 3):
            name = f"−d ln p/dR at R = {SHOWN_DISTANCES[k]:g}, kinetic equation"
            numbers.append(_number(name, e, float(rate[k])))
        growth.append(100 * float(rate[3] / rate[1] - 1))
        near.append(float(n[3]))
        theory = bands_of(case)
        measured = case.free.tail_exponent
        seen = np.flatnonzero((measured.error > 0) & (measured.error < 0.5))
        for band in seen:
            name = f"n over bands around R = {at[band]:.2f}"
            local = Measured(measured.value[band], measured.error[band])
            numbers += [
                _number(f"{name}, kinetic equation", e, float(theory[band])),
                _measured(name, e, case.free, local),
            ]
        known, density = sure_density(case, r)
        if known.size >= LEAST_POINTS:
            fit = sonine.fit_position(known, density, "tail")
            fits.append(fit)
            numbers += [
                _number("η of eq. gammatailg fitted to the kinetic equation", e, fit.eta),
                _number("γ of the same fit", e, fit.gamma),
            ]
        last, late = float(case.kinetic.kurtosis[-1]), float(case.late.kurtosis[-1])
        numbers += [
            _number("kurtosis at the last time, kinetic equation", e, last),
            _number(f"kurtosis at t = {case.late.times[-1]:.0e} d/U, kinetic equation", e, late),
        ]
        ends.append(late)
    lowest = min([v for v in near if math.isfinite(v)], default=math.nan)
    first = (
        "Nearly so at some e, far out."
        if lowest < CLEARLY_ABOVE
        else "Not where it can be seen; it lies between a Gaussian and an exponential."
    )
    return {
        "question": "Is the tail of G(R) exponential, and where?",
        "answer": (
            f"{first} At the last "
            "times the rate −d ln p/dR of p = G(R)/(2πR), which an exponential keeps and a "
            f"Gaussian doubles, grows by {_range(growth, '.0f')} % from R = 2 to 4, and the local "
            "exponent n in p ~ exp(−(R/b)ⁿ), 1 for an exponential and 2 for a Gaussian, falls to "
            f"{_range(near, '.2f')} at R = 4. The paper's tail form fitted to the equation between "
            f"R = {TAIL_REGION[0]:g} and {TAIL_REGION[1]:g} has "
            f"η = {_range([fit.eta for fit in fits], '.2f')} and "
            f"γ = {_range([fit.gamma for fit in fits], '.3g')} where the paper has "
            f"{sonine.TAIL_ETA} and {sonine.TAIL_GAMMA}. Nor is G(R) the same at all times: its "
            f"kurtosis is {_range(ends, '.2f')} at t = {cases[0].late.times[-1]:.0e} d/U, on its "
            "way to the 2 of a Gaussian."
        ),
        "numbers": numbers,
    }


def _approximations(rows: Sequence[Row]) -> Answer:
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row.kind == "approximation":
            groups.setdefault((row.observable, row.source, row.against), []).append(row)
    numbers, texts = [], []
    for (observable, source, against), same in groups.items():
        name = f"{source} for {SHORT[observable]}"
        numbers += [
            _number(f"{name}, against {against}", row.restitution, 100 * row.deviation, unit="%")
            for row in same
        ]
        known = [100 * row.deviation for row in same if math.isfinite(row.deviation)]
        texts.append(f"{name} {_range(known, '+.0f')} %" if known else f"{name} has no value")
    return {
        "question": "How far is each approximation of the paper off?",
        "answer": (
            "; ".join(texts) + ". Against the exact value, or else the kinetic equation at the "
            "last time; for G(R) at the worst R of its region, for a₂ relative to 1 + a₂."
        ),
        "numbers": numbers,
    }

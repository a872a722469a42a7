"""The paper's claims as questions, each answered in numbers with their errors."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetics import sonine
from kinetics.crosscheck.compared import bands_of, sonine_slopes
from kinetics.crosscheck.evidence import Case, Measured, ParticleEvidence
from kinetics.crosscheck.figure_parts import all_restitutions
from kinetics.crosscheck.histograms import band_middles
from kinetics.crosscheck.page import SHORT, number
from kinetics.crosscheck.rows import Row, bin_average, msd_slope_between
from kinetics.crosscheck.verdicts import corrected_sigmas, worst

Answer = dict[str, Any]
CLOSE_TO_LIMIT = 0.99
"""Share of its limit at which d<r^2>/d ln t counts as reached."""
TAIL_REGION = (2.0, 4.0)
"""R between which the tail of G(R) is read and fitted."""
SHOWN_DISTANCES = (1.0, 2.0, 3.0, 4.0)


def all_answers(cases: Sequence[Case], rows: Sequence[Row]) -> list[Answer]:
    """Question, answer in words, and the numbers behind it; none if no restitution cools.

    Each number has a name, a restitution (None for all), a value and a standard error (None for
    what has none).
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
    name: str, restitution: float | None, value: float, error: float | None = None
) -> dict[str, Any]:
    return {"name": name, "restitution": restitution, "value": value, "error": error}


def _measured(name: str, restitution: float, run: ParticleEvidence, m: Measured) -> dict[str, Any]:
    return _number(f"{name}, {run.name}", restitution, float(m.value), float(m.error))


def _list(cases: Sequence[Case], texts: Sequence[str]) -> str:
    """One text per restitution, in a sentence."""
    return ", ".join(
        f"{text} at e = {case.restitution:g}" for case, text in zip(cases, texts, strict=True)
    )


def _scaled(measured: Measured, scale: float) -> Measured:
    return Measured(measured.value / scale, measured.error / scale)


def _text(measured: Measured) -> str:
    return number(float(measured.value), float(measured.error))


def _proportional(cases: Sequence[Case]) -> Answer:
    from kinetics.exact import ScalingSolution

    e = all_restitutions()
    ratio = np.array([ScalingSolution(float(x)).cooling_rate for x in e]) / (1 - e)
    high, low = int(np.argmax(ratio)), int(np.argmin(ratio))
    free = [_scaled(case.free.cooling_rate, 1 - case.restitution) for case in cases]
    disks = [_scaled(case.disks.cooling_rate, 1 - case.restitution) for case in cases]
    exact = [case.exact.cooling_rate / (1 - case.restitution) for case in cases if case.exact]
    numbers = [
        _number("largest h/(1 - e), exact", float(e[high]), float(ratio[high])),
        _number("h/(1 - e) as e -> 1, exact", 1.0, 4 / 3),
        _number("h/(1 - e) at e = 0, exact", 0.0, math.sqrt(2)),
    ]
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
            f"e = {e[high]:.2f} and falls to 4/3 as e → 1, a spread of {100 * spread:.1f} %; the "
            f"smallest on 0 ≤ e ≤ {e[-1]:g} is {ratio[low]:.4f}. The paper's {fit} lies "
            f"{100 * above[0]:.1f} to {100 * above[1]:.1f} % above it everywhere. Over their last "
            "decade of time Boltzmann-Grad particles give "
            + _list(cases, [_text(h) for h in free])
            + "; hard disks, read with l = 1/(2dρ₀) as the paper reads them, "
            + _list(cases, [_text(h) for h in disks])
            + "."
        ),
        "numbers": numbers,
    }


def _gaussian(cases: Sequence[Case]) -> Answer:
    from scipy.optimize import brentq

    from kinetics.exact import ScalingSolution

    root = float(brentq(lambda e: ScalingSolution(e).a2, 0.1, 0.99))
    numbers = [_number("e at which the exact a2 is 0", None, root)]
    texts, away = [], []
    for case in cases:
        assert case.exact is not None
        e, run = case.restitution, case.free
        last = Measured(run.a2.value[-1], run.a2.error[-1])
        numbers += [_number("a2, exact", e, case.exact.a2), _measured("a2", e, run, last)]
        disks = Measured(case.disks.a2.value[-1], case.disks.a2.error[-1])
        numbers.append(_measured("a2", e, case.disks, disks))
        texts.append(f"{case.exact.a2:+.4f} (particles {_text(last)})")
        gaussian = bin_average(lambda c: sonine.vdf(c, 0.0), case.speed_edges)
        look = worst(run.vdf.value, run.vdf.error, gaussian)
        if look is None:
            continue
        sigmas = corrected_sigmas(look.sigmas, run.groups, look.looks)
        c = float(case.speed_edges[look.index : look.index + 2].mean())
        off = run.vdf.value[look.index] / gaussian[look.index] - 1
        error = float(run.vdf.error[look.index] / gaussian[look.index])
        numbers.append(
            _number("F/Gaussian - 1 at its worst bin, Boltzmann-Grad", e, float(off), error)
        )
        away.append(f"{100 * off:+.0f} % ({sigmas:.0f}σ) at c = {c:.2f} for e = {e:g}")
    return {
        "question": "Is the velocity distribution Gaussian?",
        "answer": (
            "No. The exact a₂ of the scaling state is "
            + _list(cases, texts)
            + f"; a Gaussian has 0, which the exact a₂ crosses at e = {root:.4f}. Even there "
            "F(0) = 0 for every e above 0, where the Gaussian has 1/π, and its tail is "
            "exponential. Boltzmann-Grad particles are away from the Gaussian by "
            + ", ".join(away)
            + " (the worst bins, corrected for the number of bins)."
        ),
        "numbers": numbers,
    }


def _logarithmic(cases: Sequence[Case]) -> Answer:
    numbers: list[dict[str, Any]] = []
    limits, particles, reached = [], [], []
    for case in cases:
        assert case.exact is not None
        e, late = case.restitution, case.late
        density = 1 / (2 * late.scene.mean_free_path)
        limit = case.exact.diffusion_slope * late.scene.mean_free_path**2
        decade = msd_slope_between(case.times, case.kinetic.msd, case.early)
        close = late.times[np.argmax(late.msd_slope >= CLOSE_TO_LIMIT * limit)]
        walk, printed = sonine_slopes(e, density)
        numbers += [
            _number("late d<r^2>/d ln t / d^2, exact", e, limit),
            _number("late d<r^2>/d ln t / d^2, random walk as printed", e, walk),
            _number("late d<r^2>/d ln t / d^2, Sonine as printed", e, printed),
            _number("d<r^2>/d ln t / d^2 over the last decade, kinetic equation", e, decade),
            _measured("d<r^2>/d ln t / d^2 over the last decade", e, case.free,
                      case.free.msd_slope),
            _measured("d<r^2>/d ln t / d^2 over the last decade", e, case.disks,
                      case.disks.msd_slope),
            _number(f"t U/d at which {CLOSE_TO_LIMIT:.0%} of the limit is reached", e, close),
        ]  # fmt: skip
        limits.append(f"{limit:.1f} d² (random walk {100 * (walk / limit - 1):+.0f} %)")
        particles.append(
            f"{_text(case.free.msd_slope)} d² (equation {decade:.1f}, hard disks "
            f"{_text(case.disks.msd_slope)})"
        )
        reached.append(f"t ≈ {close:.2g} d/U")
    return {
        "question": "Does the mean square displacement grow as ln t, and with which slope?",
        "answer": (
            "In the end, yes: d⟨r²⟩/d ln t tends to 2l²/(κ(1 − ⟨cos χ⟩)), exactly "
            + _list(cases, limits)
            + f", and the equation has {CLOSE_TO_LIMIT:.0%} of it from "
            + _list(cases, reached)
            + " on. Most of the paper's times are earlier: over their last decade Boltzmann-Grad "
            "particles have the mean slope " + _list(cases, particles) + "."
        ),
        "numbers": numbers,
    }


def _exponential(cases: Sequence[Case]) -> Answer:
    numbers: list[dict[str, Any]] = []
    rates, texts, fits, ends = [], [], [], []
    at = band_middles()
    r = np.linspace(*TAIL_REGION, 41)
    for case in cases:
        e = case.restitution
        exponents, slopes = case.position.position_tail(SHOWN_DISTANCES)
        n, rate = exponents[-1], slopes[-1]
        for x, exponent, slope in zip(SHOWN_DISTANCES, n, rate, strict=True):
            numbers += [
                _number(f"n(R = {x:g}), kinetic equation", e, float(exponent)),
                _number(f"-d ln p/dR at R = {x:g}, kinetic equation", e, float(slope)),
            ]
        rates.append(f"{rate[1]:.2f} → {rate[3]:.2f}, {100 * (rate[3] / rate[1] - 1):+.0f} %")
        theory = bands_of(case)
        measured = case.free.tail_exponent
        seen = np.flatnonzero((measured.error > 0) & (measured.error < 0.5))
        for k in seen:
            numbers += [
                _number(f"n(R = {at[k]:.3g}) between bands, kinetic equation", e, float(theory[k])),
                _measured(f"n(R = {at[k]:.3g}) between bands", e, case.free,
                          Measured(measured.value[k], measured.error[k])),
            ]  # fmt: skip
        text = f"n = {n[1]:.2f} at R = {SHOWN_DISTANCES[1]:g} and {n[3]:.2f} at R = 4"
        if seen.size:
            k = seen[-1]
            text += (
                f" (particles {number(float(measured.value[k]), float(measured.error[k]))} around "
                f"R = {at[k]:.2f}, the equation over the same bands {theory[k]:.2f})"
            )
        texts.append(text)
        fit = sonine.fit_position(r, case.position.scaled_position_density(r)[-1], "tail")
        numbers += [
            _number("eta of eq. gammatailg fitted to the kinetic equation", e, fit.eta),
            _number("gamma of eq. gammatailg fitted to the kinetic equation", e, fit.gamma),
            _number("kurtosis at the last time, kinetic equation", e, case.kinetic.kurtosis[-1]),
            _number(f"kurtosis at t = {case.late.times[-1]:.0e} d/U, kinetic equation", e,
                    case.late.kurtosis[-1]),
        ]  # fmt: skip
        fits.append(f"η = {fit.eta:.3f}, γ = {fit.gamma:.2f}")
        ends.append(f"{case.kinetic.kurtosis[-1]:.3f} → {case.late.kurtosis[-1]:.3f}")
    return {
        "question": "Is the tail of G(R) exponential, and where?",
        "answer": (
            "Between a Gaussian and an exponential, without one rate. At the last times the "
            "kinetic equation's p = G(R)/(2πR) has the rate −d ln p/dR, which an exponential keeps "
            "and a Gaussian doubles from R = 2 to 4, "
            + _list(cases, rates)
            + ". Its local exponent in p ~ exp(−(R/b)ⁿ), 2 for a Gaussian and 1 for an "
            "exponential, is " + _list(cases, texts) + ". The paper's form fitted to it between "
            f"R = {TAIL_REGION[0]:g} and {TAIL_REGION[1]:g} has "
            + _list(cases, fits)
            + f" (printed: {sonine.TAIL_ETA}, {sonine.TAIL_GAMMA}). Nor does G(R) stay the same: "
            f"its kurtosis falls from the last time to {cases[0].late.times[-1]:.0e} d/U as "
            + _list(cases, ends)
            + ", towards a Gaussian's 2."
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
            _number(f"{name} / {against} - 1", row.restitution, row.deviation) for row in same
        ]
        known = [row for row in same if math.isfinite(row.deviation)]
        if not known:
            texts.append(f"{name}: no real value at these e")
            continue
        texts.append(
            f"{name}: "
            + ", ".join(f"{100 * row.deviation:+.1f} % at e = {row.restitution:g}" for row in known)
        )
    return {
        "question": "How far is each approximation of the paper off?",
        "answer": (
            "From the exact value, or else from the kinetic equation at the last time (for G(R): "
            "at the worst R of its region; for a₂ relative to 1 + a₂). " + "; ".join(texts) + "."
        ),
        "numbers": numbers,
    }

"""What the data show by themselves, without a fit: tracers at rest, and missing ones."""

from __future__ import annotations

import numpy as np

from kinetics.crosscheck.compare.fit import Fit
from kinetics.crosscheck.compare.residuals import Residuals
from kinetics.crosscheck.compare.result import Explanation
from kinetics.crosscheck.compare.selection import even_in_logarithm
from kinetics.crosscheck.compare.statistics import ChiSquare
from kinetics.crosscheck.data.sample import Sample
from kinetics.crosscheck.words import Verdict, number, numeral

#: Share of tracers at rest from which on they are named, in data that begin after time 0.
MIN_SHARE_LATE = 0.01


def never_move(sample: Sample) -> Explanation | None:
    """Return what is said of particles with speed zero at every time; None if there are none."""
    if not sample.has_velocities or sample.times.size < 2 or sample.law.is_driven:
        return None
    n_at_rest = int(sample.at_rest.min())
    n_tracers = int(sample.samples.max())
    begins_late = sample.times[0] > 0.0
    if n_at_rest == 0 or (begins_late and n_at_rest < MIN_SHARE_LATE * n_tracers):
        return None
    share = n_at_rest / n_tracers
    headline = f"{numeral(share, '.2%')} of the particles ({n_at_rest}) never move"
    advice = ": are these the scatterers? Choose the tracers by --type, or leave the others out."
    return Explanation("scatterers", "found", headline + advice, value=share, headline=headline)


def drifts(sample: Sample) -> Explanation | None:
    """Return what is said of a mean velocity that all times share; None if there is none."""
    if sample.drift is None or sample.law.field or sample.law.is_driven:
        return None
    speed = float(np.linalg.norm(sample.drift.velocity))
    error = float(np.linalg.norm(sample.drift.error))
    components = ", ".join(numeral(value, ".3g") for value in sample.drift.velocity.tolist())
    headline = f"a wind, or an offset of the velocities, of {number(speed, error)} U"
    text = f"{headline}: their mean is ({components}) U at all times, and nothing drives tracers."
    return Explanation("wind", "found", text, value=speed, error=error, headline=headline)


def noted(fitted: Fit, residuals: Residuals) -> list[Explanation]:
    """Return what is said of tracers that come to rest, and of those that are missing later.

    Parameters
    ----------
    fitted : the averages at some times
    residuals : at all times
    """
    sample = residuals.measured.sample
    explanations = []
    if sample.has_velocities and int(sample.at_rest.max()):
        explanations.append(_come_to_rest(fitted, residuals))
    if not np.all(sample.is_complete):
        explanations.append(_are_missing(residuals, fitted.clock))
    return explanations


def _come_to_rest(fitted: Fit, residuals: Residuals) -> Explanation:
    """Return what is said of tracers at rest: whether the times at which there are none agree."""
    sample = residuals.measured.sample
    n_at_rest = int(sample.at_rest.max())
    headline = (
        f"tracers come to rest ({n_at_rest}): caught between scatterers, or stopped by a program"
    )
    chi_square = fitted.chi_square
    agrees = chi_square is None or chi_square.verdict is Verdict.AGREES
    before = _test_at(residuals, sample.at_rest == 0)
    agrees_before = before is not None and before.verdict is Verdict.AGREES
    # few change densities alone: where averages differ before, it is for another reason
    outcome = "noted"
    if agrees or agrees_before:
        outcome = "found"
    share = n_at_rest / int(sample.samples.max())
    return Explanation("traps", outcome, f"{headline}.", value=share, headline=headline)


def _are_missing(residuals: Residuals, clock: float) -> Explanation:
    """Return whether the times at which tracers are missing differ, and the others do not.

    clock : see `Fit.clock`
    """
    sample = residuals.measured.sample
    counts = sample.samples
    n_tracers = int(counts.max())
    fewest = int(np.argmin(counts))
    n_missing = n_tracers - int(counts[fewest])
    of_whole = _test_at(residuals, sample.is_complete)
    of_rest = _test_at(residuals, ~sample.is_complete)
    outcome = "noted"
    if of_rest is not None:
        outcome = "does not"
        if of_rest.verdict is not Verdict.AGREES:
            whole_agrees = of_whole is None or of_whole.verdict is Verdict.AGREES
            outcome = "explains" if whole_agrees else "in part"
    headline = f"{n_missing} tracers that are missing at later times"
    time = numeral(clock * sample.times[fewest], ".4g")
    text = (
        f"{headline}, of {n_tracers} at t = {time}. A cap on collisions takes the fast ones away."
    )
    explanation = Explanation(
        name="missing tracers",
        outcome=outcome,
        text=text,
        tested=of_rest is not None,
        value=n_missing / n_tracers,
        headline=headline,
    )
    if of_rest is not None:
        explanation = explanation._replace(chi_square_before=of_rest.value)
    if of_whole is not None:
        explanation = explanation._replace(
            chi_square_after=of_whole.value, dof=of_whole.freedom, p_value=of_whole.p_value
        )
    return explanation


def _test_at(residuals: Residuals, is_chosen: np.ndarray) -> ChiSquare | None:
    """Return the test of the averages at some of the times, a few of each."""
    layout = residuals.measured.layout
    chosen = []
    for name in layout.names:
        indices = layout.indices_of(name)
        is_there = is_chosen[layout.time_index[indices]] & (layout.time[indices] > 0.0)
        indices = indices[is_there]
        if indices.size:
            chosen.append(indices[even_in_logarithm(layout.time[indices])])
    return residuals.test(np.concatenate([np.empty(0, np.int64), *chosen]))

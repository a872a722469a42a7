"""What a verdict says, and from which threshold on: the only place where that is decided.

Three kinds of comparison have three kinds of verdict:

- *statistical*: an estimate with a standard error against a theory without one. A row that looks
  at `looks` times or bins takes the worst of them, and a report holds `rows` such rows, so that the
  two-sided p-value of the worst is multiplied by `looks * rows` (Bonferroni, which holds under any
  correlation between the looks) and turned back into sigmas before the thresholds are applied;
- *numerical*: a solver against a closed form, within the tolerance that was asked for;
- *approximation*: a printed formula against the exact value. It claims no error of its own, so the
  verdict only says how far off it is.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

AGREES_BELOW = 2.5
"""Corrected sigmas below which data and theory agree (p > 0.012)."""
DIFFERS_ABOVE = 4.0
"""Corrected sigmas from which on data and theory differ (p < 6.4e-5)."""
CLOSE_BELOW = 0.02
"""Relative deviation below which a printed approximation is called close."""
ROUGH_BELOW = 0.10
"""Relative deviation below which a printed approximation is called rough."""


class Verdict(StrEnum):
    """One word for one row of a comparison."""

    AGREES = "agrees"
    UNCLEAR = "unclear"
    DIFFERS = "differs"
    CLOSE = "close"
    ROUGH = "rough"
    FAR = "far"
    UNDEFINED = "undefined"


MEANING: dict[Verdict, str] = {
    Verdict.AGREES: f"statistical: below {AGREES_BELOW} sigma after correction for the number of "
    "looks and rows; numerical: within the tolerance asked for",
    Verdict.UNCLEAR: f"statistical: between {AGREES_BELOW} and {DIFFERS_ABOVE} sigma after "
    "correction; more samples would decide",
    Verdict.DIFFERS: f"statistical: {DIFFERS_ABOVE} sigma or more after correction; numerical: "
    "outside the tolerance asked for",
    Verdict.CLOSE: f"approximation off by less than {CLOSE_BELOW:.0%}",
    Verdict.ROUGH: f"approximation off by {CLOSE_BELOW:.0%} to {ROUGH_BELOW:.0%}",
    Verdict.FAR: f"approximation off by {ROUGH_BELOW:.0%} or more",
    Verdict.UNDEFINED: "the formula has no real value here",
}


@dataclass(frozen=True)
class Worst:
    """The look of a row that deviates most: its index, its sigmas and the corrected sigmas."""

    index: int
    sigmas: float
    corrected: float
    looks: int


def corrected_sigmas(sigmas: float, trials: int) -> float:
    """Two-sided sigmas after multiplying the p-value by the number of trials (Bonferroni)."""
    from scipy.special import log_ndtr, ndtri_exp

    log_p = log_ndtr(-abs(sigmas)) + math.log(trials)
    # log(1/2) is the p-value 1 of a two-sided test: nothing is left of the deviation.
    return 0.0 if log_p >= math.log(0.5) else float(-ndtri_exp(log_p))


def worst(values: ArrayLike, errors: ArrayLike, theory: ArrayLike, rows: int = 1) -> Worst:
    """The most deviating of the looks of one row, among `rows` rows.

    A look whose error is not positive (no sample has moved yet) cannot deviate and is left out.
    ValueError if no look is left.
    """
    v, s, t = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (values, errors, theory)))
    usable = np.flatnonzero((s > 0) & np.isfinite(v) & np.isfinite(t))
    if not usable.size:
        raise ValueError("no value with a positive standard error to compare")
    z = (v[usable] - t[usable]) / s[usable]
    k = int(np.argmax(np.abs(z)))
    looks = int(usable.size)
    return Worst(int(usable[k]), float(z[k]), corrected_sigmas(float(z[k]), looks * rows), looks)


def judge_sigmas(corrected: float) -> Verdict:
    """Verdict on a statistical comparison from its corrected sigmas."""
    if not math.isfinite(corrected):
        return Verdict.UNDEFINED
    if corrected < AGREES_BELOW:
        return Verdict.AGREES
    return Verdict.UNCLEAR if corrected < DIFFERS_ABOVE else Verdict.DIFFERS


def judge_numerical(deviation: float, tolerance: float) -> Verdict:
    """Verdict on a solver's relative deviation from a closed form."""
    return Verdict.AGREES if abs(deviation) <= tolerance else Verdict.DIFFERS


def judge_approximation(deviation: float) -> Verdict:
    """Verdict on a printed approximation's relative deviation from the exact value."""
    if not math.isfinite(deviation):
        return Verdict.UNDEFINED
    if abs(deviation) < CLOSE_BELOW:
        return Verdict.CLOSE
    return Verdict.ROUGH if abs(deviation) < ROUGH_BELOW else Verdict.FAR

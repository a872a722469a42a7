"""What a verdict says, and from which threshold on: the only place where that is decided.

Three kinds of comparison have three kinds of verdict:

- *statistical*: an estimate with a standard error against a theory without one. The error is a
  jackknife over independent groups of tracers, so that the deviation in sigmas has Student's
  distribution with one degree of freedom less than there are groups. A row that looks at several
  times or bins takes the worst of them, so that its two-sided p-value is multiplied by the number
  of looks (Bonferroni, which holds under any correlation between them). The thresholds look at the
  Gaussian sigmas of that p-value. A report holds many rows: by chance alone about one row in 80 is
  unclear, while the higher threshold keeps a wrong "differs" out of 99 in 100 reports of 150 rows;
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
    "times or bins looked at; numerical: within the tolerance asked for",
    Verdict.UNCLEAR: f"statistical: between {AGREES_BELOW} and {DIFFERS_ABOVE} sigma after "
    "correction; more samples would decide",
    Verdict.DIFFERS: f"statistical: {DIFFERS_ABOVE} sigma or more after correction; numerical: "
    "outside the tolerance asked for",
    Verdict.CLOSE: f"approximation off by less than {CLOSE_BELOW:.0%}",
    Verdict.ROUGH: f"approximation off by {CLOSE_BELOW:.0%} to {ROUGH_BELOW:.0%}",
    Verdict.FAR: f"approximation off by {ROUGH_BELOW:.0%} or more",
    Verdict.UNDEFINED: "the formula has no real value here",
}

WORDS: dict[Verdict, str] = {
    Verdict.AGREES: "no difference",
    Verdict.UNCLEAR: "unclear",
    Verdict.DIFFERS: "differs",
    Verdict.CLOSE: "off by",
    Verdict.ROUGH: "off by",
    Verdict.FAR: "off by",
    Verdict.UNDEFINED: "no value",
}
"""The words that a page and the terminal show; files have those of `Verdict`."""
EXPLAINED = {
    "no difference": "none was seen. Particles: the number behind “better than” is the "
    "difference that would have been seen, at 95 %, at every time or bin; where it is large, "
    "little was tested. Solver: within the tolerance asked for.",
    "unclear": f"between {AGREES_BELOW} and {DIFFERS_ABOVE:g} standard errors, allowing for the "
    "number of times or bins looked at; more samples would decide.",
    "differs": f"{DIFFERS_ABOVE:g} standard errors or more, allowing for the number of times or "
    "bins; or outside the tolerance asked for.",
}
"""What the three words say, for a reader who meets them first. A printed formula, which claims no
error, is only said to be “off by” so much."""


@dataclass(frozen=True)
class Worst:
    """The look of a row that deviates most: its index, its sigmas, and out of how many looks."""

    index: int
    sigmas: float
    looks: int


def worst(values: ArrayLike, errors: ArrayLike, theory: ArrayLike) -> Worst | None:
    """The most deviating look of one row, None if there is none.

    A look without a positive error (no sample has moved yet), a value or a theory is left out.
    """
    v, s, t = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (values, errors, theory)))
    usable = np.flatnonzero((s > 0) & np.isfinite(s) & np.isfinite(v) & np.isfinite(t))
    if not usable.size:
        return None
    z = (v[usable] - t[usable]) / s[usable]
    k = int(np.argmax(np.abs(z)))
    return Worst(int(usable[k]), float(z[k]), int(usable.size))


def corrected_sigmas(sigmas: float, groups: float, trials: int) -> float:
    """Two-sided Gaussian sigmas of a deviation, the worst of `trials`, with errors from `groups`.

    0 where the corrected p-value reaches 1.
    """
    from scipy.special import betainc

    freedom = groups - 1
    p = float(betainc(freedom / 2, 0.5, freedom / (freedom + sigmas**2)))
    return gaussian_sigmas(p * trials)


def gaussian_sigmas(p_value: float) -> float:
    """Two-sided Gaussian sigmas of a p-value; 0 from 1 on, 37 where doubles end."""
    from scipy.special import ndtri

    return 0.0 if p_value >= 1 else float(-ndtri(max(p_value, 1e-300) / 2))


def chance(sigmas: float) -> float:
    """Two-sided p-value of so many Gaussian sigmas."""
    return math.erfc(sigmas / math.sqrt(2))


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

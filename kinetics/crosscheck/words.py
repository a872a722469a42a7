"""What a verdict says and from which threshold on, and numbers as a reader is shown them.

Three kinds of comparison have three kinds of verdict:

- *statistical*: an estimate against a theory. Its error is a jackknife over independent groups, so
  that the deviation in sigmas has Student's distribution with one degree of freedom less than there
  are groups. A row that looks at several times or bins takes the worst, its p-value multiplied by
  the number of looks (Bonferroni). Thresholds are Gaussian sigmas of that p-value: by chance about
  one row in 80 is unclear, and 99 in 100 reports of 150 rows have no wrong "differs";
- *numerical*: a solver against a closed form, within the tolerance that was asked for;
- *approximation*: a printed formula against the exact value, which claims no error of its own.
"""

import math
import re
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

AGREES_BELOW = 2.5  # corrected sigmas below which data and theory agree (p > 0.012)
DIFFERS_ABOVE = 4.0  # corrected sigmas from which on data and theory differ (p < 6.4e-5)
# relative deviations below which a printed approximation is called close, and rough
CLOSE_BELOW, ROUGH_BELOW = 0.02, 0.10


class Verdict(StrEnum):
    """One word for one row of a comparison, the same in files, on pages and in the terminal."""

    AGREES = "agrees"
    UNCLEAR = "unclear"
    DIFFERS = "differs"
    NOT_TESTED = "not tested"
    CLOSE = "close"
    ROUGH = "rough"
    FAR = "far"
    UNDEFINED = "undefined"


MEANING: dict[Verdict, str] = {
    Verdict.AGREES: f"no difference seen: below {AGREES_BELOW} standard errors, allowing for the "
    "number of times or bins looked at; a solver: within the tolerance asked for",
    Verdict.UNCLEAR: f"between {AGREES_BELOW} and {DIFFERS_ABOVE:g} standard errors, allowing for "
    "the number of looks; more samples would decide",
    Verdict.DIFFERS: f"{DIFFERS_ABOVE:g} standard errors or more, allowing for the number of "
    "looks; a solver: outside the tolerance asked for",
    Verdict.NOT_TESTED: "the errors are so large that a difference of 10 % would not be seen",
    Verdict.CLOSE: f"a formula without an error of its own, off by less than {CLOSE_BELOW:.0%}",
    Verdict.ROUGH: f"off by {CLOSE_BELOW:.0%} to {ROUGH_BELOW:.0%}",
    Verdict.FAR: f"off by {ROUGH_BELOW:.0%} or more",
    Verdict.UNDEFINED: "the formula has no real value here",
}


def worst(values: ArrayLike, errors: ArrayLike, theory: ArrayLike) -> tuple[int, float, int] | None:
    """The look of one row that deviates most: its index, its sigmas, and out of how many looks.

    None where no look has a positive error, a value and a theory.
    """
    v, s, t = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (values, errors, theory)))
    usable = np.flatnonzero((s > 0) & np.isfinite(s) & np.isfinite(v) & np.isfinite(t))
    if not usable.size:
        return None
    z = (v[usable] - t[usable]) / s[usable]
    k = int(np.argmax(np.abs(z)))
    return int(usable[k]), float(z[k]), int(usable.size)


def corrected_sigmas(sigmas: float, groups: float, trials: int) -> float:
    """Two-sided Gaussian sigmas of a deviation, the worst of ``trials``, errors from ``groups``."""
    from scipy.special import betainc

    freedom = groups - 1
    p = float(betainc(freedom / 2, 0.5, freedom / (freedom + sigmas**2)))
    return gaussian_sigmas(p * trials)


def gaussian_sigmas(p_value: float) -> float:
    """Two-sided Gaussian sigmas of a p-value; 0 from 1 on, 37 where doubles end."""
    from scipy.special import ndtri

    return 0.0 if p_value >= 1 else float(-ndtri(max(p_value, 1e-300) / 2))


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


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = range(-4, 6)  # powers of ten that are written out


def numeral(value: float, form: str) -> str:
    """A number in a format of Python's, as print has it: −0.2, 2200 or 2.2·10⁷, not 2.2e+07."""
    text = format(value, form)
    found = re.fullmatch(r"([+-]?)([\d.]+)e([+-]?\d+)(.*)", text, flags=re.DOTALL)
    if found:
        sign, digits, exponent = found[1], found[2], int(found[3])
        if exponent in _PLAIN and "e" not in form:
            decimals = max(0, len(digits.partition(".")[2]) - exponent)
            text = f"{sign}{float(digits) * 10.0**exponent:.{decimals}f}{found[4]}"
        else:
            power = "10" + str(exponent).translate(_SUPERSCRIPTS)
            factor = "" if float(digits) == 1 else f"{digits}·"
            text = f"{sign}{factor}{power}{found[4]}"
    if text.startswith(("-", "+")) and not text.strip("+-0."):
        text = text[1:]  # no sign before a zero
    return text.replace("-", "−")


def number(value: float | None, error: float | None = None, sign: str = "", digits: int = 6) -> str:
    """A number to so many digits, or to the second digit of its error; sign "+" shows a plus."""
    if value is None or math.isnan(value):
        return "–"
    if not error or not math.isfinite(error):
        return numeral(value, f"{sign}.{digits}g") + (" ± ∞" if error else "")
    size, place = max(abs(value), error), math.floor(math.log10(float(f"{error:.1e}"))) - 1
    power = 0 if 1e-4 <= size < 1e6 else math.floor(math.log10(size))
    decimals = max(0, power - place)
    v, s = (round(x, -place) / 10.0**power for x in (value, error))
    text = f"{numeral(v, f'{sign}.{decimals}f')} ± {s:.{decimals}f}"
    return f"({text})·10{str(power).translate(_SUPERSCRIPTS)}" if power else text

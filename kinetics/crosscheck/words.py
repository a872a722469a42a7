"""What a verdict says and from which threshold on, and numbers as a reader is shown them.

Verdicts are *statistical* (an estimate against a theory: sigmas of a jackknife over independent
groups, with Student's distribution, and Bonferroni's correction for the number of looks, so that by
chance one row in 80 is unclear), *numerical* (a solver against a closed form, within the tolerance
asked for) or of an *approximation* (a printed formula, which claims no error of its own).
"""

import math
import re
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

AGREES_BELOW = 2.5  # corrected sigmas below which data and theory agree (p > 0.012)
DIFFERS_ABOVE = 4.0  # corrected sigmas from which on data and theory differ (p < 6.4e-5)
#: Share of the distribution within a limit ("at 95 %"), by convention.
LIMIT_SHARE = 0.95
#: Relative difference that a test must be able to call "differs", or it says "not tested". Chosen:
#: a theory that is wrong by its own value. At 0.1 the fat tails of 2000 tracers fail as well.
LEAST_TESTABLE = 1.0
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
    "number of looks; a solver: within the tolerance asked for",
    Verdict.UNCLEAR: f"{AGREES_BELOW} to {DIFFERS_ABOVE:g} of them; more samples would decide",
    Verdict.DIFFERS: f"{DIFFERS_ABOVE:g} standard errors or more; a solver: outside the tolerance",
    Verdict.NOT_TESTED: "the errors are so large that a difference of 10 % would not be seen; of "
    "data: the groups are so few that not even a theory wrong by its own value would differ",
    Verdict.CLOSE: f"a formula without an error of its own, off by less than {CLOSE_BELOW:.0%}",
    Verdict.ROUGH: f"off by {CLOSE_BELOW:.0%} to {ROUGH_BELOW:.0%}",
    Verdict.FAR: f"off by {ROUGH_BELOW:.0%} or more",
    Verdict.UNDEFINED: "the formula has no real value here",
}


def worst(values: ArrayLike, errors: ArrayLike, theory: ArrayLike) -> tuple[int, float, int] | None:
    """The look of one row that deviates most: its index, its sigmas, and out of how many looks that
    have a positive error, a value and a theory; None without any.
    """
    v, s, t = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (values, errors, theory)))
    z = np.where(s > 0, v - t, np.nan) / np.where(s > 0, s, 1.0)
    usable = np.flatnonzero(np.isfinite(z) & np.isfinite(s))
    if not usable.size:
        return None
    k = int(usable[np.argmax(np.abs(z[usable]))])
    return k, float(z[k]), int(usable.size)


def corrected_sigmas(sigmas: float, groups: float, trials: int) -> float:
    """Two-sided Gaussian sigmas of a deviation, the worst of ``trials``, errors from ``groups``."""
    from scipy.special import betainc

    freedom = groups - 1
    p = float(betainc(freedom / 2, 0.5, freedom / (freedom + sigmas**2)))
    return gaussian_sigmas(p * trials)


def limit_factor(groups: float, share: float = LIMIT_SHARE, numbers: int = 1) -> float:
    """Return how many standard errors from ``groups`` hold this share of a deviation.

    Of one number it is the two-sided quantile of Student's t with ``groups - 1`` degrees of
    freedom: 12.7 for two groups and 95 %, 1.96 for many. Of several ``numbers`` p together it is
    the radius of their ellipsoid, the root of p times the quantile of the F-distribution. Every
    limit and every decision that counts standard errors takes its factor from here.
    """
    from scipy.special import fdtri

    freedom = groups - 1
    if freedom <= 0:
        return math.inf
    return math.sqrt(numbers * float(fdtri(numbers, freedom, share)))


def can_differ(relative_error: float, groups: float) -> bool:
    """Return whether a relative deviation of `LEAST_TESTABLE` would be called different."""
    p_value = math.erfc(DIFFERS_ABOVE / math.sqrt(2))
    return relative_error * limit_factor(groups, 1 - p_value) < LEAST_TESTABLE


def gaussian_sigmas(p_value: float) -> float:
    """Two-sided Gaussian sigmas of a p-value; 0 from 1 on, 37 where doubles end."""
    from scipy.special import ndtri

    return 0.0 if p_value >= 1 else float(-ndtri(max(p_value, 1e-300) / 2))


def judge_sigmas(corrected: float) -> Verdict:
    """Verdict on a statistical comparison from its corrected sigmas."""
    return _graded(corrected, AGREES_BELOW, DIFFERS_ABOVE, "agrees unclear differs")


def judge_numerical(deviation: float, tolerance: float) -> Verdict:
    """Verdict on a solver's relative deviation from a closed form."""
    return Verdict.AGREES if abs(deviation) <= tolerance else Verdict.DIFFERS


def judge_approximation(deviation: float) -> Verdict:
    """Verdict on a printed approximation's relative deviation from the exact value."""
    return _graded(abs(deviation), CLOSE_BELOW, ROUGH_BELOW, "close rough far")


def _graded(size: float, low: float, high: float, words: str) -> Verdict:
    if not math.isfinite(size):
        return Verdict.UNDEFINED
    return Verdict(words.split()[(size >= low) + (size >= high)])


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = range(-4, 6)  # powers of ten that are written out


def numeral(value: float, form: str) -> str:
    """A number in a format of Python's, as print has it: −0.2, 2200 or 2.2·10⁷, not 2.2e+07."""
    text = format(value, form)
    if found := re.fullmatch(r"([+-]?)([\d.]+)e([+-]?\d+)", text):
        sign, digits, exponent = found[1], found[2], int(found[3])
        if exponent in _PLAIN and "e" not in form:
            decimals = max(0, len(digits.partition(".")[2]) - exponent)
            text = f"{sign}{float(digits) * 10.0**exponent:.{decimals}f}"
        else:
            power = "10" + str(exponent).translate(_SUPERSCRIPTS)
            text = f"{sign}{power}" if float(digits) == 1 else f"{sign}{digits}·{power}"
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

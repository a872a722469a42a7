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

#: Corrected sigmas below which data and theory agree (p > 0.012). Chosen: see the module.
AGREES_BELOW = 2.5
#: Corrected sigmas from which on data and theory differ (p < 6.4e-5). Chosen.
DIFFERS_ABOVE = 4.0
#: Share of the distribution within a limit ("at 95 %"), by convention.
LIMIT_SHARE = 0.95
#: Relative difference that a test must be able to call "differs", or it says "not tested". Chosen:
#: a theory that is wrong by its own value. At 0.1 the fat tails of 2000 tracers fail as well.
LEAST_TESTABLE = 1.0
#: Relative deviation below which a printed approximation is called close. Chosen.
CLOSE_BELOW = 0.02
#: Relative deviation below which it is called rough. Chosen.
ROUGH_BELOW = 0.10
#: Smallest p-value that is turned into sigmas: 37 of them, where doubles end.
MIN_P_VALUE = 1e-300


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
    """Return the look of one row that deviates most, or None without any.

    Looks are those that have a positive error, a value and a theory. Returns the index of the
    worst, its sigmas, and how many looks there are.
    """
    value, error, expected = np.broadcast_arrays(
        np.asarray(values, dtype=float),
        np.asarray(errors, dtype=float),
        np.asarray(theory, dtype=float),
    )
    has_error = error > 0
    sigmas = np.where(has_error, value - expected, np.nan) / np.where(has_error, error, 1.0)
    looks = np.flatnonzero(np.isfinite(sigmas) & np.isfinite(error))
    if not looks.size:
        return None
    index = int(looks[np.argmax(np.abs(sigmas[looks]))])
    return index, float(sigmas[index]), int(looks.size)


def corrected_sigmas(sigmas: float, groups: float, trials: int) -> float:
    """Return two-sided Gaussian sigmas of a deviation, the worst of ``trials``.

    Its error is from ``groups``: Student's distribution, and Bonferroni's correction.
    """
    from scipy.special import betainc

    freedom = groups - 1
    p_value = float(betainc(freedom / 2, 0.5, freedom / (freedom + sigmas**2)))
    return gaussian_sigmas(p_value * trials)


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
    """Return two-sided Gaussian sigmas of a p-value; 0 from 1 on, 37 where doubles end."""
    from scipy.special import ndtri

    if p_value >= 1:
        return 0.0
    return float(-ndtri(max(p_value, MIN_P_VALUE) / 2))


def judge_sigmas(corrected: float) -> Verdict:
    """Return the verdict on a statistical comparison from its corrected sigmas."""
    if not math.isfinite(corrected):
        return Verdict.UNDEFINED
    if corrected < AGREES_BELOW:
        return Verdict.AGREES
    if corrected < DIFFERS_ABOVE:
        return Verdict.UNCLEAR
    return Verdict.DIFFERS


def judge_numerical(deviation: float, tolerance: float) -> Verdict:
    """Return the verdict on a solver's relative deviation from a closed form."""
    if abs(deviation) <= tolerance:
        return Verdict.AGREES
    return Verdict.DIFFERS


def judge_approximation(deviation: float) -> Verdict:
    """Return the verdict on a printed approximation's relative deviation from the exact value."""
    size = abs(deviation)
    if not math.isfinite(size):
        return Verdict.UNDEFINED
    if size < CLOSE_BELOW:
        return Verdict.CLOSE
    if size < ROUGH_BELOW:
        return Verdict.ROUGH
    return Verdict.FAR


# -- numbers as a reader is shown them -------------------------------------------------------------
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Powers of ten that are written out.
PLAIN_POWERS = range(-4, 6)
#: Sizes between which a number with an error has no power of ten.
MIN_PLAIN = 1e-4
MAX_PLAIN = 1e6
NO_VALUE = "–"


def numeral(value: float, form: str) -> str:
    """Return a number in a format of Python's, as print has it: −0.2, 2200 or 2.2·10⁷."""
    text = format(value, form)
    scientific = re.fullmatch(r"([+-]?)([\d.]+)e([+-]?\d+)", text)
    if scientific is not None:
        sign, digits, power = scientific.groups()
        text = sign + _with_power(digits, int(power), is_plain="e" not in form)
    is_zero = not text.strip("+-0.")
    if is_zero and text.startswith(("-", "+")):
        text = text[1:]
    return text.replace("-", "−")


def _with_power(digits: str, power: int, is_plain: bool) -> str:
    """Return digits times a power of ten, written out where the power is small."""
    if is_plain and power in PLAIN_POWERS:
        decimals = max(0, len(digits.partition(".")[2]) - power)
        return f"{float(digits) * 10.0**power:.{decimals}f}"
    ten = f"10{_superscript(power)}"
    if float(digits) == 1:
        return ten
    return f"{digits}·{ten}"


def _superscript(power: int) -> str:
    """Return a whole number as a superscript."""
    return str(power).translate(_SUPERSCRIPTS)


def number(value: float | None, error: float | None = None, sign: str = "", digits: int = 6) -> str:
    """Return a number to so many digits, or to the second digit of its error.

    sign : "+" shows a plus
    """
    if value is None or math.isnan(value):
        return NO_VALUE
    if not error:
        return numeral(value, f"{sign}.{digits}g")
    if not math.isfinite(error):
        return numeral(value, f"{sign}.{digits}g") + " ± ?"
    size = max(abs(value), error)
    last_place = math.floor(math.log10(float(f"{error:.1e}"))) - 1
    power = 0
    if not MIN_PLAIN <= size < MAX_PLAIN:
        power = math.floor(math.log10(size))
    decimals = max(0, power - last_place)
    shown_value = round(value, -last_place) / 10.0**power
    shown_error = round(error, -last_place) / 10.0**power
    text = f"{numeral(shown_value, f'{sign}.{decimals}f')} ± {shown_error:.{decimals}f}"
    if power:
        return f"({text})·10{_superscript(power)}"
    return text

"""Numbers as a reader is shown them: true minus signs, powers of ten, and no idle digits."""

import math
import re

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PLAIN = range(-4, 6)
"""Powers of ten that are written out."""


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
    if value is None:
        return "–"
    if not error:
        return numeral(value, f"{sign}.{digits}g")
    if abs(value) >= 1e6 or error < 1e-6:
        return f"{numeral(value, f'{sign}.{digits}g')} ± {numeral(error, '.2g')}"
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{numeral(value, f'{sign}.{decimals}f')} ± {error:.{decimals}f}"

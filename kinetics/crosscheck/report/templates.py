"""The templates of the cross-check: its pages, and the sentences of its results.

Sentences stand in `templates/*.txt.j2`, one block for each; pages in `templates/*.html.j2`.
"""

import math
import re
from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any

from kinetics.crosscheck.numerals import number, numeral
from kinetics.crosscheck.report.citations import cited, number_of

__all__ = ["environment", "number", "numeral", "paragraphs", "span"]

if TYPE_CHECKING:
    from jinja2 import Environment


@cache
def environment() -> "Environment":
    """Jinja's, for the templates of this package: an undefined name is an error.

    Pages are escaped; sentences are not, because a page escapes them when it takes them in.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("kinetics.crosscheck"),
        autoescape=lambda name: name is None or not name.endswith(".txt.j2"),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters |= {"form": numeral, "span": span, "number": number}
    made.filters |= {"cited": cited, "number_of": number_of}
    made.filters |= {"count": count, "off": off, "by_how_much": by_how_much}
    return made


def paragraphs(template: str, block: str, **values: Any) -> list[str]:
    """The paragraphs of one block of a template of sentences, each as one line."""
    found = environment().get_template(template)
    text = "".join(found.blocks[block](found.new_context(values)))
    # Not str.split, which would take out the narrow spaces within numbers.
    return [
        " ".join(re.split(r"[ \n]+", part.strip()))
        for part in re.split(r"\n\s*\n", text)
        if part.strip()
    ]


def count(value: int) -> str:
    """A large whole number in groups of three digits, between thin spaces: 200 000."""
    return f"{value:,}".replace(",", "\u202f")


def off(values: Iterable[float], compared: bool = True) -> str:
    """Relative differences as a range of per cent: "15 to 20 % below", or each with its sign."""
    percents = [100 * value for value in values]
    form = ".0f" if all(abs(p) >= 5 for p in percents) else ".1f"
    if compared and all(p < 0 for p in percents):
        return f"{span([-p for p in percents], form)} % below"
    if compared and all(p > 0 for p in percents):
        return f"{span(percents, form)} % above"
    return f"{span(percents, '+' + form)} %" + (" from" if compared else "")


def by_how_much(percents: Iterable[float]) -> str:
    """What a formula is off by: per cent with their signs, or factors if it is twice the truth."""
    known = [p for p in percents if math.isfinite(p)]
    if max(known, default=0.0) < 100:
        return span(known, "+.0f") + " %"
    return "a factor of " + span([1 + p / 100 for p in known], ".2g")


def span(values: Iterable[float], form: str) -> str:
    """Smallest to largest of some numbers, as a sentence says it; NaN is left out."""
    known = [v for v in values if math.isfinite(v)]
    if not known:
        return "–"
    low, high = (numeral(f(known), form) for f in (min, max))
    return low if low == high else f"{low} to {high}"

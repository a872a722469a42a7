"""The paper's equations by their numbers: readers have those, the labels are of its LaTeX source.

`../templates/equation_numbers.json` has the number of each label, as the printed paper counts its
numbered equations (letters are its appendices). A page shows the label as a tooltip.
"""

import json
import re
from functools import cache
from importlib.resources import files

from markupsafe import Markup, escape

_FILE = files("kinetics.crosscheck") / "templates" / "equation_numbers.json"
_WORDS = ("if", "L", "N", "ab", "eta", "tn", "mup", "msd", "impact", "rewrite", "collision")
"""Labels that are words or symbols too: they are labels only after "eq."."""


@cache
def equation_numbers() -> dict[str, str]:
    """The number of each label of the paper; a label used twice has #2 at its second equation."""
    numbers: dict[str, str] = json.loads(_FILE.read_text(encoding="utf-8"))
    return numbers


def number_of(label: str) -> str:
    """As "eq. (22)"; empty for a label that is no numbered equation of the paper."""
    found = equation_numbers().get(label)
    return "" if found is None else f"eq. ({found})"


@cache
def _labels() -> "tuple[re.Pattern[str], re.Pattern[str]]":
    known = sorted(equation_numbers(), key=len, reverse=True)
    every = "|".join(map(re.escape, known))
    clear = "|".join(re.escape(label) for label in known if label not in _WORDS)
    end = r"(?![\w#]|\.\d)"
    return re.compile(rf"\b(?:eq\. |label )({every}){end}"), re.compile(
        rf"(?<![\w:])({clear}){end}"
    )


def with_numbers(text: str) -> str:
    """A text with the numbers of equations in place of their labels."""
    for pattern in _labels():
        text = pattern.sub(lambda match: number_of(match[1]), text)
    return text


def cited(text: str) -> Markup:
    """The same for a page, escaped; each number has its label as a tooltip."""
    labels = {number: label for label, number in equation_numbers().items()}

    def tooltip(match: "re.Match[str]") -> str:
        label = labels.get(match[1])
        if label is None:
            return match[0]
        return f'<abbr title="label {label} of the paper">{match[0]}</abbr>'

    # Only what stands in the table of this package is put in unescaped.
    text = re.sub(r"eq\. \(([A-D]?\d+)\)", tooltip, str(escape(with_numbers(text))))
    return Markup(text)

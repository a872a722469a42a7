"""Labels and titles of figures: plain symbols and units in matplotlib's mathtext."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

#: What stands in plain symbols and units, as a regular expression, and what mathtext writes for it.
#: The order matters: spaces come first, as what is written for others may end in one.
REPLACEMENTS = (
    (r"(?<=\S) (?=\S)", r"\\,"),
    (r"\bsqrt\(([^()]*)\)", r"\\sqrt{\1}"),
    (r"\^\(([^()]*)\)", r"^{\1}"),
    (r"\bln\b", r"\\ln"),
    (r"\b(cov|Re|Im|rad)\b", r"\\mathrm{\1}"),
    (r"\bphi\b", r"\\phi"),
    (r"\b([a-zA-Z])(\d)", r"\1_\2"),
    (r"<", r"\\langle "),
    (r">", r"\\rangle"),
    (r"\.", r"\\cdot "),
)
#: Symbols that are words are left as they are: lower-case letters, so many of them at least.
WORD = re.compile(r"[a-z_ ]{4,}")


def typeset(symbol: str) -> str:
    r"""Return a symbol or a unit in mathtext: ``<r^2>`` is ``$\langle r^2\rangle$``.

    Words, such as "collisions", are returned as they are, with spaces for underscores.
    """
    if WORD.fullmatch(symbol):
        return symbol.replace("_", " ")
    text = symbol
    for pattern, replacement in REPLACEMENTS:
        text = re.sub(pattern, replacement, text)
    return f"${text}$"


def axis_label(symbol: str, unit: str) -> str:
    """Return the label of an axis: a symbol, with its unit in brackets unless that is 1."""
    if unit in ("", "1"):
        return typeset(symbol)
    return f"{typeset(symbol)} [{typeset(unit)}]"


#: Arguments of a system, in the order of a title: the symbol of each.
SYMBOLS_OF_ARGUMENTS = {
    "restitution": "e",
    "tangential_restitution": "e_t",
    "mass_ratio": "M/m",
    "number_density": "n",
    "field": "field",
    "bath_speed": "bath speed",
    "heating": "heating",
    "drag": "drag",
    "capture_speed": "capture speed",
}
#: Values of arguments that a title leaves out, as they change nothing.
WITHOUT_EFFECT = {
    "tangential_restitution": (1.0, None),
    "mass_ratio": (math.inf,),
    "number_density": (None,),
    "field": (0.0,),
    "bath_speed": (0.0,),
    "heating": (0.0,),
    "drag": (0.0,),
    "capture_speed": (0.0,),
}
#: Units of a number density, by the dimension.
UNITS_OF_DENSITY = {2: "d⁻²", 3: "d⁻³"}
#: Significant digits of a number in a title.
DIGITS_IN_TITLE = 4


def system_items(
    arguments: Mapping[str, object], scatterers: str, dimension: int
) -> tuple[str, ...]:
    """Return what a figure's title says of a system: "e = 0.7", "n = 0.04 d⁻²", "dilute".

    Parameters
    ----------
    arguments : by name; those that are not in `SYMBOLS_OF_ARGUMENTS` are left out
    scatterers : in words; empty where there is nothing to say
    dimension : 2 or 3
    """
    items = []
    for name, symbol in SYMBOLS_OF_ARGUMENTS.items():
        if name not in arguments or arguments[name] in WITHOUT_EFFECT.get(name, ()):
            continue
        value = arguments[name]
        text = f"{value:.{DIGITS_IN_TITLE}g}" if isinstance(value, float) else str(value)
        unit = f" {UNITS_OF_DENSITY[dimension]}" if name == "number_density" else ""
        items.append(f"{symbol} = {text}{unit}")
    if scatterers:
        items.append(scatterers)
    if dimension == 3:
        items.append("in space")
    return tuple(items)

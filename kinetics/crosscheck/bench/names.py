"""Names of the problems: their families, and how they are set in figures and summaries."""

from __future__ import annotations

import re

_RAISED = str.maketrans("0123456789+-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻")
_START = re.compile(r",? ?(gaussian|monoenergetic),")
_RESTITUTION = re.compile(r",? e = [0-9.e-]+$")
_POWER_OF_TEN = re.compile(r"\b1e([+-]?)0*(\d+)\b")
_EXPONENT = re.compile(r"\^(-?\d+)")
_SIGNS = {"<r": "⟨r", "²>": "²⟩", "<=": "≤", "v0": "v₀", "a2": "a₂"}


def family(problem: str) -> str:
    """The name of a problem without its start and its restitution."""
    return _RESTITUTION.sub("", _START.sub(",", problem))


def typeset(text: str) -> str:
    """Powers raised, indices lowered, averages in brackets."""
    text = _POWER_OF_TEN.sub(lambda m: "10" + (m[1].strip("+") + m[2]).translate(_RAISED), text)
    text = _EXPONENT.sub(lambda m: m[1].translate(_RAISED), text)
    for plain, sign in _SIGNS.items():
        text = text.replace(plain, sign)
    return text

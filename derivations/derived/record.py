"""What a derivation leaves, and the register of derivations by label.

A derivation is a function without arguments under ``@derives(label)`` that returns
``result(formula, step, ..., note=...)``. A label with nothing to derive has a note alone: it
stands in a table under ``defines``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, partial
from typing import SupportsFloat

import sympy as sp

RESTITUTIONS = (0.4, 0.6, 0.7, 0.9)
"""The restitutions of the paper's figures, at which numbers stand beside its formulas."""


class Status(StrEnum):
    """The verdict on one labelled equation."""

    VERIFIED = "verified"
    ERRATUM = "erratum"
    DEFINITION = "definition"
    ASSUMPTION = "assumption"
    FIT = "fit"
    FIGURE = "figure"
    NOT_DERIVED = "not derived"


@dataclass(frozen=True)
class Step:
    """One step of a derivation: what is done, and the formula that it gives."""

    text: str
    formula: sp.Basic | None = None


@dataclass(frozen=True)
class Number:
    """One named value: ``value`` is dimensionless unless the name says otherwise."""

    name: str
    value: float


@dataclass(frozen=True)
class Derived:
    """What a derivation returns.

    ``formula`` is built from premises; ``status`` is the kind that the row has when nothing is to
    be compared (definition, assumption, fit, figure), None when printed and derived are compared;
    ``holds`` says for an assumption whether it holds in the exact theory; ``note`` states what
    follows from it, or what is wrong with it.
    """

    formula: sp.Basic | None
    steps: tuple[Step, ...] = ()
    note: str = ""
    status: Status | None = None
    holds: bool | None = None
    numbers: tuple[Number, ...] = ()


def result(
    formula: sp.Basic | None,
    *steps: Step,
    note: str = "",
    status: Status | None = None,
    holds: bool | None = None,
    numbers: Iterable[Number] = (),
) -> Derived:
    """A derived formula with its steps; a row that says whether it ``holds`` is an assumption."""
    if holds is not None:
        status = Status.ASSUMPTION
    return Derived(formula, steps, note, status, holds, tuple(numbers))


def numbers_at(
    restitutions: Iterable[float], values: Mapping[str, Callable[[float], SupportsFloat]]
) -> tuple[Number, ...]:
    """Each of the functions of e at each restitution; ``{e}`` in a name stands for its value."""
    return tuple(
        Number(name.format(e=e), float(value(e)))
        for e in restitutions
        for name, value in values.items()
    )


Derivation = Callable[[], Derived]
REGISTRY: dict[str, Derivation] = {}


def derives(*labels: str) -> Callable[[Derivation], Derivation]:
    """Register a derivation for one or more labels (the paper repeats some formulas).

    It runs at most once in a process. Raises ValueError for a label that has a derivation.
    """

    def register(function: Derivation) -> Derivation:
        once = cache(function)
        for label in labels:
            if label in REGISTRY:
                raise ValueError(f"label {label!r} is derived twice")
            REGISTRY[label] = once
        return function

    return register


def defines(notes: Mapping[str, str], status: Status = Status.DEFINITION) -> None:
    """Register labels with nothing to derive, each with its note: definitions, or sketches."""
    for label, note in notes.items():
        derives(label)(partial(Derived, None, note=note, status=status))

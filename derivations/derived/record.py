"""What a derivation leaves, and the register of derivations by label.

``row(label, lambda: formula, step, ..., note=...)`` states a derivation of one line; a longer one
is a function without arguments under ``@derives(label)`` that returns ``result(...)``. A label
with nothing to derive has a note alone: it stands in a table under ``defines``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Any

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
    *steps: str | tuple[str, sp.Basic],
    note: str = "",
    status: Status | None = None,
    holds: bool | None = None,
    numbers: Mapping[str, Any] | None = None,
    at: Iterable[float] = RESTITUTIONS,
) -> Derived:
    """A derived formula with its steps; a row that says whether it ``holds`` is an assumption.

    ``numbers`` are values by name, or functions that give them; a function whose name holds
    ``{e}`` is called with each restitution of ``at``.
    """
    found: list[Number] = []
    of_restitution = {name: value for name, value in (numbers or {}).items() if "{e}" in name}
    for name, value in (numbers or {}).items():
        if name not in of_restitution:
            found.append(Number(name, float(value() if callable(value) else value)))
        elif name == next(iter(of_restitution)):
            found += [
                Number(each.format(e=e), float(function(e)))
                for e in at
                for each, function in of_restitution.items()
            ]
    taken = (Step(step) if isinstance(step, str) else Step(*step) for step in steps)
    status = status if holds is None else Status.ASSUMPTION
    return Derived(formula, tuple(taken), note, status, holds, tuple(found))


def zero(expression: sp.Expr, else_: str) -> None:
    """What a derivation relies on: ArithmeticError with the other case unless this is zero."""
    if all(way(expression) != 0 for way in (sp.expand, sp.cancel, sp.simplify)):
        raise ArithmeticError(else_)


REGISTRY: dict[str, Callable[[], Derived]] = {}


def derives(*labels: str) -> Callable[[Callable[[], Derived]], Callable[[], Derived]]:
    """Register a derivation for one or more labels (the paper repeats some formulas).

    It runs at most once in a process. Raises ValueError for a label that has a derivation.
    """

    def register(function: Callable[[], Derived]) -> Callable[[], Derived]:
        once = cache(function)
        for label in labels:
            if label in REGISTRY:
                raise ValueError(f"label {label!r} is derived twice")
            REGISTRY[label] = once
        return function

    return register


def row(label: str, derivation: Callable[[], Any] = lambda: None, *steps: str, **said: Any) -> None:
    """Register a derivation that gives the formula, or a tuple of it and steps with formulas.

    ``said`` is what else :func:`result` takes.
    """

    def derived() -> Derived:
        found = derivation()
        return result(*(found if isinstance(found, tuple) else (found,)), *steps, **said)

    derives(label)(derived)


def defines(notes: Mapping[str, str], status: Status = Status.DEFINITION) -> None:
    """Register labels with nothing to derive, each with its note: definitions, or sketches."""
    for label, note in notes.items():
        row(label, note=note, status=status)

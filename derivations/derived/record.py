"""What a derivation leaves, and the register of derivations by label.

``row(label, lambda: formula, step, ..., note=...)`` states a derivation of one line; a longer one
is a function without arguments under ``@derives(label)`` that returns ``result(...)``. A label
with nothing to derive has a note alone: it stands in a table under ``defines``. What the paper says
in words is judged by ``statement``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import SupportsFloat

import sympy as sp

#: The restitutions of the paper's figures, rising, at which numbers stand beside its formulas.
RESTITUTIONS = (0.4, 0.6, 0.7, 0.9)


class Status(StrEnum):
    """What kind of row it is: how the printed formula stands to the derived one."""

    VERIFIED = "verified"
    ERRATUM = "erratum"
    DEFINITION = "definition"
    ASSUMPTION = "assumption"
    STATEMENT = "statement"
    FIT = "fit"
    FIGURE = "figure"
    NOT_DERIVED = "not derived"

    @property
    def meaning(self) -> str:
        """What the status says, in one sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    Status.VERIFIED: "The formula, derived from the collision rule, is the one that is printed.",
    Status.ERRATUM: "The derived formula is another one: the printed one does not follow.",
    Status.DEFINITION: "A name is given to something; there is nothing to derive.",
    Status.ASSUMPTION: "The paper assumes it; the note says whether the exact theory bears it out.",
    Status.STATEMENT: "The paper says it in words; the verdict is that of the exact theory.",
    Status.FIT: "Numbers were fitted to the simulation; the exact ones stand beside them.",
    Status.FIGURE: "A figure or a sketch; the note says what it shows.",
    Status.NOT_DERIVED: "It could not be decided whether printed and derived are the same.",
}


class Verdict(StrEnum):
    """What the exact theory says of an assumption, or of a statement in words."""

    HOLDS = "holds"
    IN_PART = "holds in part"
    FAILS = "does not hold"


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
    be compared (definition, assumption, statement, fit, figure), None when printed and derived are
    compared; ``verdict`` says of an assumption or a statement whether it holds in the exact theory;
    ``note`` states what follows from it, or what is wrong with it.
    """

    formula: sp.Basic | None
    steps: tuple[Step, ...] = ()
    note: str = ""
    status: Status | None = None
    verdict: Verdict | None = None
    numbers: tuple[Number, ...] = ()


Value = SupportsFloat | Callable[..., SupportsFloat]
"""A number, or a function that gives it: of nothing, or of the restitution."""
StepLike = str | tuple[str, sp.Basic]
"""The text of a step, or its text and its formula."""


def result(
    formula: sp.Basic | None,
    *steps: StepLike,
    note: str = "",
    status: Status | None = None,
    verdict: Verdict | None = None,
    numbers: Mapping[str, Value] | None = None,
    restitutions: Iterable[float] = RESTITUTIONS,
) -> Derived:
    """Return a derived formula with its steps; with a verdict and no status it is an assumption.

    ``numbers`` are values by name, or functions that give them; a function whose name holds
    ``{e}`` is called with each restitution of ``restitutions``.
    """
    if verdict is not None and status is None:
        status = Status.ASSUMPTION
    return Derived(
        formula,
        steps=tuple(_step(step) for step in steps),
        note=note,
        status=status,
        verdict=verdict,
        numbers=_evaluate_numbers(numbers or {}, restitutions),
    )


def _step(step: StepLike) -> Step:
    if isinstance(step, str):
        return Step(step)
    text, formula = step
    return Step(text, formula)


def _evaluate_numbers(
    numbers: Mapping[str, Value], restitutions: Iterable[float]
) -> tuple[Number, ...]:
    """Return the numbers in their order; all that depend on e stand where the first of them does.

    They are sorted by restitution, so that numbers of one gas stand beside each other.
    """
    of_restitution = {name: value for name, value in numbers.items() if "{e}" in name}
    evaluated: list[Number] = []
    is_first_of_restitution = True
    for name, value in numbers.items():
        if name not in of_restitution:
            evaluated.append(Number(name, float(value() if callable(value) else value)))
        elif is_first_of_restitution:
            evaluated.extend(_evaluate_at_restitutions(of_restitution, restitutions))
            is_first_of_restitution = False
    return tuple(evaluated)


def _evaluate_at_restitutions(
    functions: Mapping[str, Value], restitutions: Iterable[float]
) -> Iterable[Number]:
    for e in restitutions:
        for name, function in functions.items():
            assert callable(function), name
            yield Number(name.format(e=e), float(function(e)))


def zero(expression: sp.Expr, otherwise: str) -> None:
    """Raise ArithmeticError, which says what is so otherwise, unless an expression is zero."""
    for simplification in (sp.expand, sp.cancel, sp.simplify):
        if simplification(expression) == 0:
            return
    raise ArithmeticError(otherwise)


Derivation = Callable[[], Derived]

REGISTRY: dict[str, Derivation] = {}
"""The derivation of each label; it runs at most once in a process."""


def derives(*labels: str) -> Callable[[Derivation], Derivation]:
    """Register a derivation for one or more labels (the paper repeats some formulas).

    Raises ValueError for a label that has a derivation.
    """

    def register(function: Derivation) -> Derivation:
        once = cache(function)
        for label in labels:
            if label in REGISTRY:
                raise ValueError(f"label {label!r} is derived twice")
            REGISTRY[label] = once
        return function

    return register


def _nothing() -> None:
    """Give no formula: the row is a note alone."""


def row(
    label: str,
    derivation: Callable[[], sp.Basic | tuple | None] = _nothing,
    *steps: StepLike,
    note: str = "",
    status: Status | None = None,
    verdict: Verdict | None = None,
    numbers: Mapping[str, Value] | None = None,
    restitutions: Iterable[float] = RESTITUTIONS,
) -> None:
    """Register a derivation that gives the formula, or a tuple of it and steps with formulas.

    All else is as :func:`result` takes it.
    """

    @derives(label)
    def derive_row() -> Derived:
        formula = derivation()
        leading_steps: tuple[StepLike, ...] = ()
        if isinstance(formula, tuple):
            formula, *leading = formula
            leading_steps = tuple(leading)
        return result(
            formula,
            *leading_steps,
            *steps,
            note=note,
            status=status,
            verdict=verdict,
            numbers=numbers,
            restitutions=restitutions,
        )


def statement(
    label: str,
    verdict: Verdict,
    note: str,
    numbers: Mapping[str, Value] | None = None,
    restitutions: Iterable[float] = RESTITUTIONS,
) -> None:
    """Register the verdict on what the paper says in words, with what it rests on."""
    row(
        label,
        note=note,
        status=Status.STATEMENT,
        verdict=verdict,
        numbers=numbers,
        restitutions=restitutions,
    )


def defines(notes: Mapping[str, str], status: Status = Status.DEFINITION) -> None:
    """Register labels with nothing to derive, each with its note: definitions, or sketches."""
    for label, note in notes.items():
        row(label, note=note, status=status)

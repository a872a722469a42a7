"""The verdict on every labelled equation: derived against printed."""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from ..derived import (  # noqa: F401  (they register their derivations)
    chapman_enskog,
    cooling,
    figures,
    flux,
    kinetic_equation,
    position,
    random_walk,
    scaling_state,
    sonine,
    speed_resolved,
    stability,
    statements,
    steepest_descent,
)
from ..derived.record import Check, Status
from ..derived.registry import REGISTRY
from ..printed import ROWS, printed_equation
from .difference import Difference, compare

report_subset: tuple[str, ...] = (
    "sonine9",
    "sonine10",
    "sonine7",
    "sonine11",
    "sonine12",
    "ac3",
    "ac5",
    "ac7",
    "compare1",
    "compare3",
    "compare3#2",
    "ad6",
    "diffuse21",
    "ad7",
    "ad8",
    "ad8#2",
)


VERDICTS: dict[Difference, tuple[Status, str]] = {
    Difference.NONE: (Status.VERIFIED, "exact"),
    Difference.NONE_NUMERICALLY: (
        Status.VERIFIED,
        "numerical: sympy does not simplify the difference to zero; it vanishes at 50 digits at "
        "20 random points",
    ),
    Difference.UNDECIDED: (Status.NOT_DERIVED, ""),
    Difference.PRESENT: (Status.ERRATUM, ""),
}


def check(label: str, printed: sp.Basic | None = None) -> Check:
    """Derive one label and judge the printed formula.

    ``printed`` replaces the formula of :mod:`derivations.printed` (the mutation test uses it).
    Raises ValueError for a label that does not exist.
    """
    entry = printed_equation(label)
    formula = entry.formula if printed is None else printed
    derived = REGISTRY[label]()
    status, proof = derived.status, ""
    if status is None:
        if formula is None or derived.formula is None:
            raise ValueError(f"label {label!r} has nothing to compare and no status of its own")
        status, proof = VERDICTS[compare(formula, derived.formula)]
    return Check(
        label=label,
        title=entry.title,
        section=entry.section,
        printed=formula,
        derived=derived.formula,
        status=status,
        note=derived.note,
        source=entry.source,
        proof=proof,
        holds=derived.holds,
        numbers=derived.numbers,
        steps=derived.steps,
    )


def verify(labels: Iterable[str] | None = None) -> tuple[Check, ...]:
    """One :class:`Check` per label, in the paper's order; all labels when ``labels`` is None.

    Raises ValueError naming the label that does not exist.
    """
    chosen = tuple(ROWS) if labels is None else tuple(labels)
    return tuple(check(label) for label in chosen)

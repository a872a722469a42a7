"""The verdict on every labelled equation: derived against printed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from html import escape

import sympy as sp

from ..derived import (  # noqa: F401  (they register their derivations)
    any_dimension,
    any_law,
    chapman_enskog,
    closed_forms,
    cooling,
    figures,
    finite_density,
    flux,
    isotropic_scattering,
    kinetic_equation,
    position,
    random_walk,
    scaling_state,
    sonine,
    speed_resolved,
    stability,
    statements,
    steepest_descent,
    uniform_field,
)
from ..derived.record import REGISTRY, Number, Status, Step
from ..printed import ROWS, printed_equation
from ..typesetting import latex, mathml, plain
from .difference import Difference, compare

report_subset: tuple[str, ...] = (
    *("sonine9", "sonine10", "sonine7", "sonine11", "sonine12", "ac3", "ac5", "ac7"),
    *("compare1", "compare3", "compare3#2", "ad6", "diffuse21", "ad7", "ad8", "ad8#2"),
)
"""The labels that the report shows: those of the Sonine expansion."""

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
"""Status and proof of a row whose printed and derived formulas are compared."""


@dataclass(frozen=True, repr=False)
class Check:
    """One row of the verdict: a labelled equation, as printed and as derived.

    ``printed`` and ``derived`` are sympy objects (an equation, a relation, or a Tuple of them for
    a chain of equalities), None where there is nothing to compare. ``proof`` says how a verified
    row was proved: ``exact`` (the difference is a symbolic zero) or ``numerical: <why>`` (it holds
    at 50 digits at 20 random points). ``holds`` is, for an assumption, whether the exact theory
    bears it out. The quantities are those of :mod:`derivations.symbols`.
    """

    label: str
    title: str
    section: str
    printed: sp.Basic | None
    derived: sp.Basic | None
    status: Status
    note: str
    source: str = ""
    proof: str = ""
    holds: bool | None = None
    numbers: tuple[Number, ...] = ()
    steps: tuple[Step, ...] = field(default=())

    @property
    def printed_latex(self) -> str:
        """The printed formula as LaTeX (no delimiters); empty if there is none."""
        return latex(self.printed)

    @property
    def derived_latex(self) -> str:
        """The derived formula as LaTeX (no delimiters); empty if there is none."""
        return latex(self.derived)

    @property
    def printed_mathml(self) -> str:
        """The printed formula as MathML; empty if there is none."""
        return mathml(self.printed)

    @property
    def derived_mathml(self) -> str:
        """The derived formula as MathML; empty if there is none."""
        return mathml(self.derived)

    def __repr__(self) -> str:
        lines = [f"Check {self.label!r}: {self.title}: {self.status}"]
        for name, formula in (("printed", self.printed), ("derived", self.derived)):
            if formula is not None:
                lines.append(f"  {name}: {plain(formula)}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        head = f"<b>{escape(self.label)}</b>: {escape(self.title)}: <i>{self.status}</i>"
        formulas = (("printed", self.printed_mathml), ("derived", self.derived_mathml))
        rows = [f"<div>{name}: {formula}</div>" for name, formula in formulas if formula]
        return f"<div>{head}{''.join(rows)}<div>{escape(self.note)}</div></div>"


def check(label: str, printed: sp.Basic | None = None) -> Check:
    """Derive one label and judge the printed formula.

    ``printed`` replaces the formula of :mod:`derivations.printed` (the mutation test uses it).
    Raises ValueError for a label that does not exist.
    """
    equation = printed_equation(label)
    formula = equation.formula if printed is None else printed
    derived = REGISTRY[label]()
    status, proof = derived.status, ""
    if status is None:
        if formula is None or derived.formula is None:
            raise ValueError(f"label {label!r} has nothing to compare and no status of its own")
        status, proof = VERDICTS[compare(formula, derived.formula)]
    return Check(
        label=label,
        title=equation.title,
        section=equation.section,
        printed=formula,
        derived=derived.formula,
        status=status,
        note=derived.note,
        source=equation.source,
        proof=proof,
        holds=derived.holds,
        numbers=derived.numbers,
        steps=derived.steps,
    )


def verify(labels: Iterable[str] | None = None) -> tuple[Check, ...]:
    """One :class:`Check` per label, in the paper's order; all labels when ``labels`` is None.

    Raises ValueError naming the label that does not exist.
    """
    if labels is None:
        return tuple(check(label) for label in ROWS)
    try:
        wanted = None if isinstance(labels, str | bytes) else list(labels)
    except TypeError:
        wanted = None
    if wanted is None:
        kind = type(labels).__name__
        raise ValueError(f"labels: got a {kind}; it must be several labels, such as ['sonine9']")
    return tuple(check(label) for label in wanted)

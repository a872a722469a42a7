"""The records that a derivation leaves: a step, a derived formula, a check with its verdict."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import sympy as sp

from ..typesetting import latex


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


def definition(note: str) -> Derived:
    """A row that defines: nothing to derive."""
    return Derived(None, status=Status.DEFINITION, note=note)


@dataclass(frozen=True)
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
    steps: tuple[Step, ...] = field(default=(), repr=False)

    @property
    def printed_latex(self) -> str:
        """The printed formula as LaTeX (no delimiters); empty if there is none."""
        return latex(self.printed)

    @property
    def derived_latex(self) -> str:
        """The derived formula as LaTeX (no delimiters); empty if there is none."""
        return latex(self.derived)

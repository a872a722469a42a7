"""The verdict on every labelled equation: derived against printed.

A difference that sympy cannot simplify to zero is not held against the paper for that: it counts
as different only where it has a value that is not zero, and as zero, with the reason stated, where
it vanishes at 50 digits at 20 random points. What cannot be decided is called that.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from html import escape

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational

from . import symbols as s
from .derived import REGISTRY
from .derived.record import Number, Status, Step, Verdict
from .formal import Formal, linear
from .printed import ROWS, printed_equation
from .printers import latex, mathml, plain

#: Random points at which a difference that sympy cannot simplify is evaluated. Chosen: a difference
#: that is not identically zero vanishes at one of them by chance only, to 50 digits at none.
POINTS = 20
#: Digits to which such a difference must vanish. Chosen, far beyond the 15 of floating point.
DIGITS = 50
#: Digits that are evaluated beyond those that are judged. Chosen.
GUARD_DIGITS = 10
#: A value above this at one point shows a difference, evaluated to 30 digits. Chosen: far above
#: the rounding of 30 digits; it only spares slow simplifications.
CLEAR_DIFFERENCE = 1e-15
#: Start of the random numbers, so that every run evaluates at the same points. Chosen.
SEED = 20240607
#: Formal parts of a formula, which count as independent variables where it is evaluated.
OPAQUE = (sp.Symbol, sp.Derivative, sp.Integral, sp.Sum, sp.KroneckerDelta, Formal, AppliedUndef)


class Difference(IntEnum):
    """How two formulas differ; the order is that of the worst member of several."""

    NONE = 0
    NONE_NUMERICALLY = 1
    UNDECIDED = 2
    PRESENT = 3


def residuals(formula: sp.Basic) -> list[sp.Expr]:
    """The expressions that a formula states to be zero; of an inequality its two sides."""
    if isinstance(formula, sp.Tuple):
        expressions: list[sp.Expr] = []
        for member in formula:
            expressions.extend(residuals(member))
        return expressions
    if isinstance(formula, sp.Eq):
        return [formula.lhs - formula.rhs]
    if isinstance(formula, Relational):
        return [formula.lhs, formula.rhs]
    return [formula]


def judge(expression: sp.Expr) -> Difference:
    """Whether an expression is zero; the cheap simplifications come first."""
    if expression == 0:
        return Difference.NONE
    if s.pm in expression.free_symbols:
        return max(judge(expression.subs(s.pm, branch)) for branch in (1, -1))
    expanded = sp.expand(linear(expression))
    if expanded == 0:
        return Difference.NONE
    # a value far from zero at one generic point spares the slow simplifications
    if any(_exceeds(value, CLEAR_DIFFERENCE) for value in _values(expanded, points=1, digits=30)):
        return Difference.PRESENT
    for simplification in (sp.cancel, sp.radsimp, sp.simplify):
        if simplification(expanded) == 0:
            return Difference.NONE
    values = _values(expanded, POINTS, DIGITS + GUARD_DIGITS)
    if len(values) < POINTS:
        return Difference.UNDECIDED
    limit = sp.Float(10, DIGITS) ** -DIGITS
    if any(_exceeds(value, limit) for value in values):
        return Difference.PRESENT
    return Difference.NONE_NUMERICALLY


def _exceeds(value: sp.Expr, limit: float | sp.Float) -> bool:
    return value.is_infinite or bool(abs(value) > limit)


def _values(expression: sp.Expr, points: int, digits: int) -> list[sp.Expr]:
    """The expression at random points; its formal parts count as independent variables.

    Infinite where it diverges; fewer values where it has none. Kronecker's delta, which vanishes
    almost everywhere, counts as a formal part.
    """
    variables = sorted(expression.atoms(*OPAQUE), key=_outermost_first)
    stream = random.Random(SEED)
    values = []
    for _ in range(points):
        number = _value_at_random_point(expression, variables, stream, digits)
        real_and_imaginary = number.as_real_imag()
        is_number = all(term.is_Float or term.is_Integer for term in real_and_imaginary)
        if number.is_infinite or is_number:
            values.append(number)
    return values


def _outermost_first(formal_part: sp.Expr) -> tuple:
    return (-formal_part.count_ops(), sp.default_sort_key(formal_part))


def _value_at_random_point(
    expression: sp.Expr, variables: list[sp.Expr], stream: random.Random, digits: int
) -> sp.Expr:
    for variable in variables:
        point = sp.Rational(stream.randint(100, 899), 1000)
        expression = expression.xreplace({variable: point})
    return expression.evalf(digits)


@lru_cache(maxsize=512)
def compare(printed: sp.Basic, derived: sp.Basic) -> Difference:
    """How far two formulas state the same: same kind, and zero difference of every residual."""
    if isinstance(printed, Relational) and printed.func is not derived.func:
        return Difference.PRESENT
    printed_residuals = residuals(printed)
    derived_residuals = residuals(derived)
    if len(derived_residuals) != len(printed_residuals):
        return Difference.PRESENT
    pairs = zip(derived_residuals, printed_residuals, strict=True)
    return max(judge(derived_side - printed_side) for derived_side, printed_side in pairs)


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
"""The labels that the report shows: those of the Sonine expansion."""

COMPARED: dict[Difference, tuple[Status, str]] = {
    Difference.NONE: (Status.VERIFIED, "exact"),
    Difference.NONE_NUMERICALLY: (
        Status.VERIFIED,
        "numerical: sympy does not simplify the difference to zero; it vanishes at 50 digits at "
        "20 random points",
    ),
    Difference.UNDECIDED: (Status.NOT_DERIVED, ""),
    Difference.PRESENT: (Status.ERRATUM, ""),
}
"""The status and the proof of a row whose printed and derived formulas are compared."""


@dataclass(frozen=True, repr=False)
class Check:
    """One row of the verdict: a labelled equation, as printed and as derived.

    ``printed`` and ``derived`` are sympy objects (an equation, a relation, or a Tuple of them for
    a chain of equalities), None where there is nothing to compare. ``proof`` says how a verified
    row was proved: ``exact`` (the difference is a symbolic zero) or ``numerical: <why>`` (it holds
    at 50 digits at 20 random points). ``verdict`` is what the exact theory says of an assumption or
    of a statement in words; ``holds`` is True where that is "holds", False where it holds in part
    or not at all, None where there is no verdict. ``number`` is the paper's, such as "B15", empty
    where it has none. ``printed_latex`` and so on are the formulas as LaTeX (no delimiters) and
    MathML, empty if there is none.
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
    verdict: Verdict | None = None
    numbers: tuple[Number, ...] = ()
    steps: tuple[Step, ...] = ()
    number: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the exact theory bears out an assumption or a statement, as a whole."""
        if self.verdict is None:
            return None
        return self.verdict is Verdict.HOLDS

    @property
    def printed_latex(self) -> str:
        """The printed formula as LaTeX, without delimiters."""
        return latex(self.printed)

    @property
    def derived_latex(self) -> str:
        """The derived formula as LaTeX, without delimiters."""
        return latex(self.derived)

    @property
    def printed_mathml(self) -> str:
        """The printed formula as MathML."""
        return mathml(self.printed)

    @property
    def derived_mathml(self) -> str:
        """The derived formula as MathML."""
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
    """Derive one label, or number such as "B15", and judge the printed formula.

    ``printed`` replaces the formula of :mod:`derivations.printed` (the mutation test uses it).
    Raises ValueError for a label that does not exist.
    """
    equation = printed_equation(label)
    label = equation.label
    formula = equation.formula if printed is None else printed
    derived = REGISTRY[label]()
    status = derived.status
    proof = ""
    if status is None:
        if formula is None or derived.formula is None:
            raise ValueError(f"label {label!r} has nothing to compare and no status of its own")
        status, proof = COMPARED[compare(formula, derived.formula)]
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
        verdict=derived.verdict,
        numbers=derived.numbers,
        steps=derived.steps,
        number=equation.number,
    )


def verify(labels: Iterable[str] | None = None) -> tuple[Check, ...]:
    """One :class:`Check` per label or number, in their order; all labels when ``labels`` is None.

    Raises ValueError naming the label that does not exist.
    """
    if isinstance(labels, str | bytes) or not isinstance(labels, Iterable | None):
        kind = type(labels).__name__
        raise ValueError(f"labels: got a {kind}; it must be several labels, such as ['sonine9']")
    if labels is None:
        labels = ROWS
    return tuple(check(label) for label in labels)

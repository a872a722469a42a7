"""A verified row says something: change any one coefficient of the printed formula and it turns.

The same for the results beyond the paper, whose stated form plays the part of the printed one.
"""

from collections.abc import Callable, Iterator

import pytest
import sympy as sp

from derivations import Check, Status
from derivations.printed import ROWS
from derivations.verdicts.checks import check

Mutants = Callable[[sp.Basic], Iterator[sp.Basic]]


def test_the_mutants_are_those_of_every_number_and_term(mutants: Mutants) -> None:
    a, b = sp.symbols("a b")
    formula = sp.Eq(a, 3 * a**2 + b, evaluate=False)
    found = {str(mutant) for mutant in mutants(formula)}
    assert found == {
        "Eq(2*a, 3*a**2 + b)",
        "Eq(a, 6*a**2 + 2*b)",
        "Eq(a, 4*a**2 + b)",
        "Eq(a, 3*a**3 + b)",
        "Eq(a, 6*a**2 + b)",
        "Eq(a, 3*a**2 + 2*b)",
    }


@pytest.mark.parametrize("tried", [2, pytest.param(None, marks=pytest.mark.slow, id="all")])
def test_a_changed_coefficient_turns_a_verified_row_to_erratum(
    checks: tuple[Check, ...], mutants: Mutants, tried: int | None
) -> None:
    for label in (row.label for row in checks if row.status is Status.VERIFIED):
        formula = ROWS[label].formula
        assert formula is not None
        changed = [mutant for mutant in mutants(formula) if mutant != formula]
        assert len(changed) >= 2
        accepted = [m for m in changed[:tried] if check(label, m).status is not Status.ERRATUM]
        assert not accepted, label

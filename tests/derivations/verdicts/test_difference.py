"""The comparison itself: exact zero, zero by numbers, a difference, or no decision."""

import pytest
import sympy as sp

from derivations import Status
from derivations import symbols as sy
from derivations.derived.record import REGISTRY, Derived
from derivations.formal import Int, eq
from derivations.verdicts.checks import check
from derivations.verdicts.difference import Difference, compare, is_zero, judge

E = sy.e


class Valueless(sp.Function):
    """A function of which nothing is known, not even its value at a number."""


NO_VALUE = Valueless(E)
# one to one with 0 = 0, but beyond sympy's simplification
HARD_ZERO = sp.asinh(sp.sqrt(1 - E**2) / E) - sp.atanh(sp.sqrt(1 - E**2))


def test_an_exact_zero() -> None:
    assert judge((1 - E**2) / (1 - E) - 1 - E) is Difference.NONE
    assert is_zero(
        Int(2 * sy.d * sy.F(sy.bc) + sy.e, sy.bc)
        - 2 * sy.d * Int(sy.F(sy.bc), sy.bc)
        - sy.e * Int(sp.Integer(1), sy.bc)
    )


def test_both_branches_of_a_sign_count() -> None:
    assert judge(sy.pm**2 - 1) is Difference.NONE
    assert judge(sy.pm - 1) is Difference.PRESENT


def test_a_difference_is_present_however_small_its_coefficient() -> None:
    assert judge(E / 10**12) is Difference.PRESENT


def test_a_zero_that_is_not_simplified_is_numerical(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("cancel", "radsimp", "simplify"):
        monkeypatch.setattr(sp, name, lambda expression: expression)
    assert judge(HARD_ZERO) is Difference.NONE_NUMERICALLY
    almost = HARD_ZERO + E * sp.Rational(1, 10**40)
    assert judge(almost) is Difference.PRESENT


def test_what_has_no_value_is_undecided_and_what_diverges_is_not_zero() -> None:
    assert judge(NO_VALUE) is Difference.UNDECIDED
    assert judge(1 / E - sp.oo / (1 + E)) is Difference.PRESENT


def test_a_delta_does_not_vanish_by_being_evaluated_elsewhere() -> None:
    other = sp.KroneckerDelta(sy.p, 2 * sy.pprime)
    assert judge(sp.KroneckerDelta(sy.p, sy.pprime) - other) is Difference.PRESENT


def test_the_worst_member_decides() -> None:
    good, bad = eq(E, E), eq(E, 2 * E)
    assert compare(sp.Tuple(good, bad), sp.Tuple(good, good)) is Difference.PRESENT
    assert compare(sp.Tuple(good), sp.Tuple(good, good)) is Difference.PRESENT
    assert compare(sp.Le(E, 1, evaluate=False), eq(E, sp.Integer(1))) is Difference.PRESENT


@pytest.mark.parametrize(
    ("difference", "status", "proof"),
    [
        (sp.Integer(0), Status.VERIFIED, "exact"),
        (HARD_ZERO, Status.VERIFIED, "numerical"),
        (E, Status.ERRATUM, ""),
        (NO_VALUE, Status.NOT_DERIVED, ""),
    ],
)
def test_the_verdict_follows_the_comparison(
    monkeypatch: pytest.MonkeyPatch, difference: sp.Expr, status: Status, proof: str
) -> None:
    monkeypatch.setattr(sp, "simplify", lambda expression: expression)
    monkeypatch.setitem(REGISTRY, "compare2", lambda: Derived(eq(sy.h, sy.M2 / 2 + difference)))
    row = check("compare2")
    assert row.status is status
    assert row.proof.split(":")[0] == proof

"""The verdicts: which rows stand; exact zero, zero by numbers, a difference, or no decision."""

from collections.abc import Iterator

import pytest
import sympy as sp

from derivations import ERRATA, Check, Status, Verdict, verify
from derivations import symbols as sy
from derivations.checks import Difference, check, compare, judge
from derivations.derived import REGISTRY
from derivations.derived.record import result
from derivations.formal import eq
from derivations.printed import ROWS

E = sy.e
# one to one with 0 = 0, but beyond sympy's simplification
HARD_ZERO = sp.asinh(sp.sqrt(1 - E**2) / E) - sp.atanh(sp.sqrt(1 - E**2))
Rows = dict[str, Check]


class Valueless(sp.Function):
    """A function of which nothing is known, not even its value at a number."""


NO_VALUE = Valueless(E)


def labels(rows: Rows, status: Status, verdict: Verdict | None = None) -> set[str]:
    return {x for x, row in rows.items() if row.status is status and row.verdict is verdict}


def test_every_row_is_printed_and_derived(rows: Rows) -> None:
    assert list(rows) == list(ROWS)
    assert set(REGISTRY) == set(ROWS)


def test_how_many_rows_are_verified_or_not_to_be_compared(rows: Rows) -> None:
    assert len(labels(rows, Status.VERIFIED)) == 145
    assert len(labels(rows, Status.DEFINITION)) == 23
    assert len(labels(rows, Status.FIGURE)) == 9
    assert labels(rows, Status.FIT) == {"hsimu", "gammatailg", "peakg"}


def test_the_errata_are_the_rows_that_do_not_follow(rows: Rows) -> None:
    assert [erratum.label for erratum in ERRATA] == [
        "diffuse7",
        "normg",
        "tailg",
        "semig",
        "ad5",
        "ad8",
        "ap1",
        "ap4",
        "ap7",
    ]
    assert {erratum.label for erratum in ERRATA} == labels(rows, Status.ERRATUM)
    for erratum in ERRATA:
        assert erratum.number == ROWS[erratum.label].number


def test_the_verdicts_on_what_the_paper_assumes(rows: Rows) -> None:
    assert labels(rows, Status.ASSUMPTION, Verdict.FAILS) == {
        "taun",
        "msd",
        "ddif",
        "sonine1",
        "ad3",
        "ad4",
        "ap11",
        "ap14",
        "ap20",
        "ap21",
    }
    assert labels(rows, Status.ASSUMPTION, Verdict.HOLDS) == {
        "gtilde",
        "tdiff",
        "tdepend",
        "diffuse5",
        "diffuse14",
    }
    assert not labels(rows, Status.ASSUMPTION, Verdict.IN_PART)


def test_the_verdicts_on_what_the_paper_says_in_words(rows: Rows) -> None:
    assert labels(rows, Status.STATEMENT, Verdict.FAILS) == {
        "statement:a2-missing",
        "statement:sonine-a2",
        "statement:gaussian-f",
        "statement:universal-g",
    }
    assert labels(rows, Status.STATEMENT, Verdict.IN_PART) == {
        "statement:h-linear",
        "statement:exponential-g",
    }
    assert labels(rows, Status.STATEMENT, Verdict.HOLDS) == {
        "statement:h-not-haff",
        "statement:exponential-f",
        "statement:log-msd",
    }


def test_only_a_verdict_without_reserve_holds(rows: Rows) -> None:
    for row in rows.values():
        if row.verdict is None:
            assert row.holds is None
        else:
            assert row.holds is (row.verdict is Verdict.HOLDS)


def test_a_row_says_what_its_status_promises(rows: Rows) -> None:
    for label, row in rows.items():
        assert row.title, label
        assert row.section, label
        assert all(isinstance(number.value, float) for number in row.numbers), label
        is_judged = row.status in (Status.ASSUMPTION, Status.STATEMENT)
        assert (row.verdict is not None) == is_judged, label
        if row.status is Status.VERIFIED:
            assert row.proof == "exact", label
            assert row.derived is not None, label
        else:
            assert row.note, label
        if row.status in (Status.ERRATUM, Status.FIT):
            assert row.numbers, label


@pytest.mark.parametrize(
    ("label", "name", "value"),
    [
        ("compare1", "threshold restitution", 0.58157),
        ("beyond:a2", "restitution at which a_2 = 0", 0.5929352),
        ("statement:h-linear", "largest h/(1 - e)", 1.42968),
        ("beyond:slope", "slope at e = 0.5", 4.435),
        ("beyond:space-cooling", "h at e = 0.9", 0.09994),
        ("sonine12", "Sonine a_2 at e = 0.9", -0.181),
        ("ad7", "their ratio", 0.8488),
        ("msd", "slope at e = 0.4, with the paper's l = 13.5 d (l^2)", 3.0286),
    ],
)
def test_numbers_that_were_known_before(label: str, name: str, value: float, rows: Rows) -> None:
    numbers = {number.name: number.value for number in rows[label].numbers}
    assert numbers[name] == pytest.approx(value, abs=5.1e-4)  # half of the last digit of most


@pytest.mark.parametrize("labels", [["sonine99"], "sonine9", 3])
def test_an_unknown_label_is_refused(labels) -> None:
    with pytest.raises(ValueError, match="label"):
        verify(labels)


# -- the comparison ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ((1 - E**2) / (1 - E) - 1 - E, Difference.NONE),
        (sy.pm**2 - 1, Difference.NONE),
        (sy.pm - 1, Difference.PRESENT),
        (E / 10**12, Difference.PRESENT),
        (NO_VALUE, Difference.UNDECIDED),
        (1 / E - sp.oo / (1 + E), Difference.PRESENT),
        # a delta does not vanish by being evaluated elsewhere
        (
            sp.KroneckerDelta(sy.p, sy.pprime) - sp.KroneckerDelta(sy.p, 2 * sy.pprime),
            Difference.PRESENT,
        ),
    ],
)
def test_how_an_expression_is_judged(expression: sp.Expr, expected: Difference) -> None:
    assert judge(expression) is expected


def test_the_worst_member_decides() -> None:
    good = eq(E, E)
    bad = eq(E, 2 * E)
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
    monkeypatch.setitem(REGISTRY, "compare2", lambda: result(eq(sy.h, sy.M2 / 2 + difference)))
    row = check("compare2")
    assert row.status is status
    assert row.proof.split(":")[0] == proof


# -- a verified row says something: change a coefficient of what is stated and it turns ------------


def every_mutant(node: sp.Basic) -> Iterator[sp.Basic]:
    """Every formula with one number changed, or with one term (coefficient 1) doubled."""
    if isinstance(node, sp.Number):
        yield node + 1
        return
    for index, argument in enumerate(node.args):
        changed = list(every_mutant(argument))
        if isinstance(node, sp.Add | sp.Eq | sp.Le) and argument != 0:
            changed.append(2 * argument)
        for mutant in changed:
            arguments = list(node.args)
            arguments[index] = mutant
            options = {"evaluate": False} if isinstance(node, sp.Eq | sp.Le) else {}
            yield node.func(*arguments, **options)


@pytest.mark.parametrize("tried", [1, pytest.param(None, marks=pytest.mark.slow, id="all")])
def test_a_changed_coefficient_turns_a_verified_row_to_erratum(
    rows: Rows, tried: int | None
) -> None:
    for label in labels(rows, Status.VERIFIED):
        formula = ROWS[label].formula
        changed = [mutant for mutant in every_mutant(formula) if mutant != formula]
        assert len(changed) >= 2
        accepted = [m for m in changed[:tried] if check(label, m).status is not Status.ERRATUM]
        assert not accepted, label

"""The verdicts: which rows stand, which do not, and what each of them has to say."""

import subprocess
import sys

import pytest

import derivations
from derivations import Check, Status, report_subset, verify
from derivations.printed import ROWS
from derivations.verdicts.checks import check

Rows = dict[str, Check]


@pytest.fixture(scope="module")
def rows(checks: tuple[Check, ...]) -> Rows:
    return {row.label: row for row in checks}


def labels(rows: Rows, status: Status) -> set[str]:
    return {label for label, row in rows.items() if row.status is status}


def test_the_errata_are_these(rows: Rows) -> None:
    assert labels(rows, Status.ERRATUM) == {
        "diffuse7",  # drops lower fluxes under higher gradients; harmless at the orders used
        "normg",  # 8 int D dt for 4 int D dt
        "tailg",  # half of the Gaussian integral
        "semig",  # the same
        "ad5",  # the density n is missing
        "ad8",  # integrand at the upper limit
        "ap1",  # 2 pi too many; harmless
        "ap4",  # collisions exchange speeds
        "ap7",  # as diffuse7
    }


def test_the_assumptions_say_whether_they_hold(rows: Rows) -> None:
    fails = {label for label in labels(rows, Status.ASSUMPTION) if rows[label].holds is False}
    holds = {label for label in labels(rows, Status.ASSUMPTION) if rows[label].holds is True}
    assert fails | holds == labels(rows, Status.ASSUMPTION)
    assert {label for label in fails if ":" not in label} == {
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
    assert {label for label in holds if ":" not in label} == {
        "gtilde",
        "tdiff",
        "tdepend",
        "diffuse5",
        "diffuse14",
    }


def test_which_statements_of_the_paper_survive(rows: Rows) -> None:
    said = {label[10:]: row for label, row in rows.items() if label.startswith("statement:")}
    survive = {name for name, row in said.items() if row.holds}
    fall = set(said) - survive
    assert survive == {"h-not-haff", "exponential-f", "log-msd"}
    assert fall == {
        "h-linear",
        "a2-missing",
        "sonine-a2",
        "gaussian-f",
        "universal-g",
        "exponential-g",
    }


def test_fits_and_figures(rows: Rows) -> None:
    assert labels(rows, Status.FIT) == {"hsimu", "gammatailg", "peakg"}
    assert len(labels(rows, Status.FIGURE)) == 9
    assert labels(rows, Status.NOT_DERIVED) == set()


@pytest.mark.parametrize("label", list(ROWS))
def test_a_row_says_what_its_status_promises(label: str, rows: Rows) -> None:
    row = rows[label]
    assert row.title
    assert row.section
    if row.status is Status.VERIFIED:
        assert row.proof == "exact"
        assert row.steps
        assert row.derived is not None
    elif row.status is Status.ERRATUM:
        assert row.note
        assert row.numbers
        assert row.steps
    elif row.status is Status.FIT:
        assert row.note
        assert row.numbers
    elif ":" not in label or row.status is not Status.VERIFIED:
        assert row.note
    assert all(isinstance(number.value, float) for number in row.numbers)


@pytest.mark.parametrize(
    ("label", "name", "value"),
    [
        ("compare1", "threshold restitution", 0.58157),
        ("beyond:a2", "restitution at which a_2 = 0", 0.5929352),
        ("statement:h-linear", "largest h/(1 - e)", 1.42968),
        ("statement:h-linear", "restitution at which it is largest", 0.1464),
        ("beyond:slope", "slope at e = 0.9", 22.294),
        ("beyond:slope", "slope at e = 0.5", 4.435),
        ("beyond:slope", "slope at e = 0.2", 3.080),
        ("sonine12", "exact a_2 at e = 0.9", -0.412),
        ("sonine12", "Sonine a_2 at e = 0.9", -0.181),
        ("ad7", "their ratio", 0.8488),
        ("beyond:position", "flatness of the K_0 form", 4.0),
    ],
)
def test_numbers_that_were_known_before(label: str, name: str, value: float, rows: Rows) -> None:
    found = {number.name: number.value for number in rows[label].numbers}
    assert found[name] == pytest.approx(value, abs=5.1e-4)  # half of the last digit of most


def test_the_report_subset_is_judged_as_the_whole_is(rows: Rows) -> None:
    for row in verify(report_subset):
        assert row.status is rows[row.label].status
        assert row.printed_latex
        assert row.derived_latex


def test_an_unknown_label_is_refused() -> None:
    with pytest.raises(ValueError, match="label: got 'sonine99'; it must be one of"):
        verify(["sonine99"])
    with pytest.raises(ValueError, match="'sonine99'"):
        check("sonine99")


def test_public_names_exist() -> None:
    for name in derivations.__all__:
        assert getattr(derivations, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = derivations.no_such_name


def test_importing_the_package_loads_no_sympy() -> None:
    code = "import sys, derivations; print('sympy' in sys.modules, 'mpmath' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False", "False"]

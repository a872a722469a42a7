"""Checks and printed equations are values: they compare, hash, travel between processes, print."""

import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError

import pytest

import derivations
from derivations import Check, printed_equation, verify
from derivations.derived.record import REGISTRY
from derivations.printed import ROWS


def test_checks_survive_pickling(checks: tuple[Check, ...]) -> None:
    checks = checks[::8]
    again = pickle.loads(pickle.dumps(checks))
    assert again == checks
    assert set(again) == set(checks)
    assert len(set(checks)) == len(checks)


def test_a_check_from_another_process_is_equal() -> None:
    labels = ["vchange", "diffuse20", "collision"]
    code = (
        "import pickle, sys; from derivations import verify; "
        f"sys.stdout.buffer.write(pickle.dumps(verify({labels})))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert pickle.loads(run.stdout) == verify(labels)


def test_a_check_is_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        verify(["sonine9"])[0].note = "another"  # type: ignore[misc]


def test_equal_checks_come_from_equal_formulas(checks: tuple[Check, ...]) -> None:
    (again,) = verify(["sonine9"])
    (other,) = verify(["sonine10"])
    assert again == next(check for check in checks if check.label == "sonine9")
    assert again != other


def test_the_representation_is_short(checks: tuple[Check, ...]) -> None:
    for check in checks[::4]:
        lines = repr(check).splitlines()
        assert len(lines) <= 10, check.label
        assert check.label in lines[0]
        assert str(check.status) in lines[0]
        assert check.label in check._repr_html_()
        assert check.derived_mathml in check._repr_html_()


def test_a_printed_equation_is_a_value_that_derives_nothing() -> None:
    equation = printed_equation("vchange")
    assert pickle.loads(pickle.dumps(equation)) == equation
    assert equation.source.startswith(r"{\bf v}=")
    assert equation.latex.startswith(r"\mathbf{v} =")
    assert equation.mathml.startswith("<math>")
    assert "vchange" in repr(equation)
    code = (
        "import sys; from derivations import printed_equation; printed_equation('vchange'); "
        "print([name for name in sys.modules if name.startswith('derivations.derived')])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_an_unknown_equation_is_refused() -> None:
    with pytest.raises(ValueError, match="label: got 'sonine99'"):
        printed_equation("sonine99")


def test_every_row_has_a_derivation_and_every_derivation_a_row() -> None:
    assert set(REGISTRY) == set(ROWS)


def test_the_package_shows_its_public_names() -> None:
    assert set(derivations.__all__) <= set(dir(derivations))
    assert "__version__" in dir(derivations)
    assert derivations.__version__[0].isdigit()

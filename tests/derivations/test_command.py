"""What `lorentz derive` prints after the rows, and what it writes of one equation."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from derivations import ERRATA, Check, Status
from kinetics.crosscheck.cli.derive import derive, show_summary


def test_the_summary_explains_every_status_that_occurs(
    checks: tuple[Check, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    show_summary(checks)
    lines = capsys.readouterr().out.splitlines()
    counted = {tuple(line.split()[:2]) for line in lines}
    for status in {check.status for check in checks}:
        count = sum(check.status is status for check in checks)
        assert (str(count), status.value) in counted
        assert status.meaning
    assert not any(Status.NOT_DERIVED.value in line for line in lines)


def test_the_summary_lists_every_erratum_and_what_it_changes(
    checks: tuple[Check, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    show_summary(checks)
    text = " ".join(capsys.readouterr().out.split())
    for erratum in ERRATA:
        entry = text.partition(f"({erratum.number}) {erratum.label}")[2]
        assert erratum.printed in entry
        assert erratum.correct in entry
        assert erratum.changes in entry


def test_latex_of_one_equation_is_of_that_equation_alone(tmp_path: Path) -> None:
    file = tmp_path / "one.tex"
    outcome = CliRunner().invoke(derive, ["--only", "eq. 6", "--latex", str(file)])
    assert outcome.exit_code == 0, outcome.output
    document = file.read_text(encoding="utf-8")
    assert document.count(r"\paragraph") == 1
    assert "vdiff" in document
    assert "mean square displacement" not in document

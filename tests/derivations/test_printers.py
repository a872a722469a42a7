"""Formulas, equations and checks for readers: LaTeX, MathML, text, JSON, a LaTeX document."""

import json
import pickle
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import pytest

from derivations import (
    Check,
    Status,
    printed_equation,
    to_json,
    to_latex_document,
    to_text,
    verify,
)
from derivations.documents import counts
from derivations.printed import ROWS
from derivations.printers import mathml
from derivations.symbols import LATEX


def test_the_mathml_of_a_row_is_well_formed_and_shows_no_name_of_python() -> None:
    names = {name for name in LATEX if len(name) > 2}
    hidden = ("Int", "Dot", "Partial", "Lam", "Avg", "Measure", "Second", "_vec", "_hat")
    for label, row in ROWS.items():
        text = mathml(row.formula)
        ElementTree.fromstring(f"<div>{unescape(text)}</div>")
        assert not any(f">{name}<" in text for name in names), label
        assert not any(name in text for name in hidden), label


def test_the_latex_document(checks: tuple[Check, ...], tmp_path: Path) -> None:
    checks = checks[::3]
    document = to_latex_document(checks)
    assert document.isascii()
    unescaped = re.sub(r"\\[{}]", "", document)
    assert unescaped.count("{") == unescaped.count("}")
    titles = re.findall(r"\\paragraph\{(?:Eq. \(\w+\), )?\\texttt\{(.*?)\}: ", document)
    assert [title.replace(r"\_", "_").replace(r"\#", "#") for title in titles] == [
        check.label for check in checks
    ]
    numbers = re.findall(r"\\paragraph\{Eq. \((\w+)\)", document)
    assert numbers == [check.number for check in checks if check.number]
    if shutil.which("pdflatex") is None:
        return
    (tmp_path / "all.tex").write_text(document, encoding="utf-8")
    run = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "all.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        errors="replace",
    )
    assert run.returncode == 0, run.stdout[-2000:]


def test_json_survives_a_round_trip(checks: tuple[Check, ...], rows: dict) -> None:
    checks = (*checks[::4], rows["sonine9"])
    data = to_json(checks)
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert [row["label"] for row in data["checks"]] == [check.label for check in checks]
    assert sum(data["counts"].values()) == len(checks)
    row = data["checks"][-1]
    assert row["status"] == "verified"
    assert row["number"] == "B15"
    assert row["printed"] == "M_2 = sqrt(pi)*(1 - e**2)*(3*a_2/8 + 1)"
    assert row["source_latex"].startswith("M_{2}")
    assert row["steps"]
    assert set(row) == {
        "label",
        "number",
        "title",
        "section",
        "status",
        "proof",
        "holds",
        "verdict",
        "note",
        "printed",
        "derived",
        "printed_latex",
        "derived_latex",
        "source_latex",
        "numbers",
        "steps",
    }
    assert list(counts([])) == [status.value for status in Status]


def test_json_gives_the_verdict_in_words(rows: dict) -> None:
    (row,) = to_json([rows["statement:h-linear"]])["checks"]
    assert row["status"] == "statement"
    assert row["verdict"] == "holds in part"
    assert row["holds"] is False
    (row,) = to_json([rows["sonine9"]])["checks"]
    assert row["verdict"] is None


def test_a_latex_document_explains_its_own_symbols_alone(rows: dict) -> None:
    document = to_latex_document([rows["vdiff"]])
    symbols = document.partition("longtable}{")[2]
    assert "thermal velocity" in symbols
    assert "coefficient of restitution" not in symbols
    assert document.count(r"\paragraph") == 1


def test_text_shows_the_steps_and_the_verdict() -> None:
    text = to_text(verify(["ad8"])[0])
    assert "erratum" in text
    assert "msd_e(t) = 4*Integral(D_e(t), (t', 0, t))" in text
    assert "msd_e(t) = 4*Integral(D_e(t'), (t', 0, t))" in text
    assert re.search(r"1\. .*: 4\n", text)


def test_checks_and_equations_are_values(checks: tuple[Check, ...]) -> None:
    some = checks[::8]
    again = pickle.loads(pickle.dumps(some))
    assert again == some
    assert len(set(again)) == len(some)
    equation = printed_equation("vchange")
    assert pickle.loads(pickle.dumps(equation)) == equation
    with pytest.raises(ValueError, match="sonine99"):
        printed_equation("sonine99")

"""Checks as a LaTeX document, as data and as text."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from derivations import Check, to_json, to_latex_document, to_text, verify
from derivations import symbols as sy
from derivations.output.text import counts


@pytest.fixture(scope="module")
def document(checks: tuple[Check, ...]) -> str:
    return to_latex_document(checks)


def test_the_document_is_balanced_and_plain(document: str) -> None:
    assert document.isascii()
    assert document.startswith(r"\documentclass")
    assert document.rstrip().endswith(r"\end{document}")
    unescaped = re.sub(r"\\[{}]", "", document)
    assert unescaped.count("{") == unescaped.count("}")
    opened = re.findall(r"\\begin\{([a-z]+\*?)\}", document)
    closed = re.findall(r"\\end\{([a-z]+\*?)\}", document)
    assert sorted(opened) == sorted(closed)
    assert len(re.findall(r"\\left", document)) == len(re.findall(r"\\right(?!arrow)", document))


def test_the_document_has_every_row(document: str, checks: tuple[Check, ...]) -> None:
    titles = re.findall(r"\\paragraph\{\\texttt\{(.*?)\}: ", document)
    assert [title.replace(r"\_", "_").replace(r"\#", "#") for title in titles] == [
        check.label for check in checks
    ]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_the_document_compiles(document: str, tmp_path: Path) -> None:
    (tmp_path / "all.tex").write_text(document, encoding="utf-8")
    run = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "all.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        errors="replace",
    )
    assert run.returncode == 0, run.stdout[-2000:]
    assert (tmp_path / "all.pdf").stat().st_size > 10_000


def test_json_holds_every_row_and_survives_a_round_trip(checks: tuple[Check, ...]) -> None:
    data = to_json(checks)
    again = json.loads(json.dumps(data, allow_nan=False))
    assert again == data
    assert [row["label"] for row in data["checks"]] == [check.label for check in checks]
    assert sum(data["counts"].values()) == len(checks)
    (row,) = (row for row in data["checks"] if row["label"] == "sonine9")
    assert row["status"] == "verified"
    assert row["printed"] == "M_2 = sqrt(pi)*(1 - e**2)*(3*a_2/8 + 1)"
    assert row["source_latex"].startswith("M_{2}")
    assert row["steps"]


def test_counts_name_every_status() -> None:
    assert counts([]) == {
        "verified": 0,
        "erratum": 0,
        "definition": 0,
        "assumption": 0,
        "fit": 0,
        "figure": 0,
        "not derived": 0,
    }


def test_text_shows_the_steps_and_the_verdict() -> None:
    (check,) = verify(["ad8"])
    text = to_text(check)
    assert "status: erratum" in text
    assert "printed: msd_e(t) = 4*Integral(D_e(t), (t', 0, t))" in text
    assert "derived: msd_e(t) = 4*Integral(D_e(t'), (t', 0, t))" in text
    assert "  1. Laplacian of r^2 in the plane: 4" in text
    assert "holds in the exact theory: no" in to_text(verify(["ap20"])[0])


def test_every_symbol_has_a_meaning() -> None:
    names = [name for name, _ in sy.table()]
    assert len(names) > 100
    assert all(sy.meaning(name) for name in names)
    with pytest.raises(KeyError):
        sy.meaning("no such symbol")

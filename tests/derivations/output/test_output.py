"""Checks as a LaTeX document, as data and as text."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import sympy as sp

from derivations import symbols as sy
from derivations import to_json, to_latex_document, to_text, verify
from derivations.output.text import counts
from derivations.typesetting import latex

CHECKS = verify()
DOCUMENT = to_latex_document(CHECKS)


def test_the_document_is_balanced_and_plain() -> None:
    assert DOCUMENT.isascii()
    assert DOCUMENT.startswith(r"\documentclass")
    assert DOCUMENT.rstrip().endswith(r"\end{document}")
    unescaped = re.sub(r"\\[{}]", "", DOCUMENT)
    assert unescaped.count("{") == unescaped.count("}")
    opened = re.findall(r"\\begin\{([a-z]+\*?)\}", DOCUMENT)
    closed = re.findall(r"\\end\{([a-z]+\*?)\}", DOCUMENT)
    assert sorted(opened) == sorted(closed)
    assert len(re.findall(r"\\left", DOCUMENT)) == len(re.findall(r"\\right(?!arrow)", DOCUMENT))


def test_the_document_has_every_row() -> None:
    titles = re.findall(r"\\paragraph\{\\texttt\{(.*?)\}: ", DOCUMENT)
    assert [title.replace(r"\_", "_").replace(r"\#", "#") for title in titles] == [
        check.label for check in CHECKS
    ]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_the_document_compiles(tmp_path: Path) -> None:
    (tmp_path / "all.tex").write_text(DOCUMENT, encoding="utf-8")
    run = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "all.tex"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        errors="replace",
    )
    assert run.returncode == 0, run.stdout[-2000:]
    assert (tmp_path / "all.pdf").stat().st_size > 10_000


def test_json_holds_every_row_and_survives_a_round_trip() -> None:
    data = to_json(CHECKS)
    again = json.loads(json.dumps(data, allow_nan=False))
    assert again == data
    assert [row["label"] for row in data["checks"]] == [check.label for check in CHECKS]
    assert sum(data["counts"].values()) == len(CHECKS)
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


def test_latex_of_names_that_sympy_would_not_typeset() -> None:
    assert latex(sy.bv) == r"\mathbf{v}"
    assert latex(sy.msd(sy.t)) == r"\langle r^{2}\rangle_{e}{\left(t \right)}"
    assert latex(sp.Tuple(sy.a2, sy.h)) == r"a_{2},\quad h"
    assert latex(None) == ""


def test_every_symbol_has_a_meaning() -> None:
    names = [name for name, _ in sy.table()]
    assert len(names) > 100
    assert all(sy.meaning(name) for name in names)
    with pytest.raises(KeyError):
        sy.meaning("no such symbol")

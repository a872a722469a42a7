"""Every label of the paper is there, and the transcriptions are those that were read again."""

import re
from hashlib import sha256
from importlib.resources import files

import pytest

from derivations import printed_equation
from derivations.printed import PRINTED, ROWS, appendices, main_text

FIGURES = {
    "collision",
    "v0re",
    "hetomu2",
    "msdtheory",
    "inelasticposi",
    "scalev",
    "impact",
    "sign",
    "soninediffuse",
}


def test_every_label_of_the_paper_has_one_row(rows) -> None:
    assert len(PRINTED) == 133
    assert [label for label in rows if ":" not in label] == list(PRINTED)
    without_formula = {label for label, row in PRINTED.items() if row.formula is None}
    without_latex = {label for label, row in PRINTED.items() if not row.source}
    assert without_formula == FIGURES
    assert without_latex == FIGURES


def test_a_transcription_has_the_number_of_its_latex() -> None:
    for row in (*main_text.EQUATIONS, *appendices.EQUATIONS):
        assert row.number == ROWS[row.label].number, row.label


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("B15", "sonine9"),
        ("b15", "sonine9"),
        ("(B15)", "sonine9"),
        ("eq. 22", "msd"),
        ("Eq. (22)", "msd"),
        ("equation 22", "msd"),
        ("sonine9", "sonine9"),
        ("if", "if"),
    ],
)
def test_an_equation_is_found_by_label_and_by_number_however_written(name: str, label: str) -> None:
    assert printed_equation(name).label == label


@pytest.mark.parametrize("name", ["B99", "eq. 21", "eq.", "", "SONINE9"])
def test_what_is_neither_label_nor_number_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="label"):
        printed_equation(name)


def test_the_transcriptions_are_those_that_were_read_again() -> None:
    """A reader of the paper's LaTeX, part of these tests up to version 0.3.0, agreed with each.

    Whoever changes the LaTeX or a transcription holds one against the other again, and gives the
    new sum here. Most of the rows would also turn from verified to erratum.
    """
    room = files("derivations.printed")
    names = ("paper.tex", "main_text.py", "appendices.py")
    texts = [room.joinpath(name).read_text("utf-8") for name in names]
    digest = sha256(re.sub(r"\s", "", "".join(texts)).encode()).hexdigest()
    assert digest == "db0b3eabe90e7e08c8f8aac395e4e658b7ae53f3dcda3358ce8875f54ad9afc6"

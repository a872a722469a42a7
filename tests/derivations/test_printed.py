"""Every label of the paper is there, and the transcriptions are those that were read again."""

import re
from hashlib import sha256
from importlib.resources import files

from derivations.printed import PRINTED

_FIGURES = "collision v0re hetomu2 msdtheory inelasticposi scalev impact sign soninediffuse"


def test_every_label_of_the_paper_has_one_row(rows) -> None:
    assert len(PRINTED) == 133
    assert [label for label in rows if ":" not in label] == list(PRINTED)
    without = {label for label, row in PRINTED.items() if row.formula is None}
    assert (
        without
        == {label for label, row in PRINTED.items() if not row.source}
        == set(_FIGURES.split())
    )


def test_the_transcriptions_are_those_that_were_read_again() -> None:
    """A reader of the paper's LaTeX, part of these tests up to version 0.3.0, agreed with each.

    Whoever changes the LaTeX or a transcription holds one against the other again, and gives the
    new sum here. Most of the rows would also turn from verified to erratum.
    """
    texts = (files("derivations.printed").joinpath(name).read_text("utf-8")
             for name in ("paper.tex", "main_text.py", "appendices.py"))  # fmt: skip
    found = sha256(re.sub(r"\s", "", "".join(texts)).encode()).hexdigest()
    assert found == "69a4250284a8c682249f4d0db479af8f47cdfe0a4a53a125d110c43d2c67eb2a"

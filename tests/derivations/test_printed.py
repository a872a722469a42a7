"""Every label of the paper is there, and every transcription says what its LaTeX source says."""

from collections.abc import Callable, Iterator
from itertools import pairwise

import pytest
import sympy as sp
from latex_reader import read
from marking import slow_but

from derivations import symbols as sy
from derivations.checks import is_zero
from derivations.printed import PRINTED, read_equations

Mutants = Callable[[sp.Basic], Iterator[sp.Basic]]
_LABELS = """
vchange gtilde v0defi thermo tdiff vdiff veq hsimu inelaslorentz2 tdepend if mup tdiff2 compare2
compare3 ab taun taun tn N msd scaledposi diffuse1 diffuse1.5 diffuse2 diffuse3 diffuse4 diffuse5
diffuse6 diffuse7 diffuse8 diffuse9 diffuse10 diffuse11 diffuse12 diffuse13 diffuse14 diffuse15
diffuse16 diffuse17 diffuse18 diffuse19 diffuse20 diffuse21 diffuse22 normg ddif L eta etadif
posivel gdefi pdefi csolu tailg semig gammatailg peakg dtchange gammaflow gamma- gamma+ ftdiff
rewrite bexpress bexpress2 inelaslorentz rearramu2 ifmu2 mueq sonine1 sonine1.5 sonine2 sonine3
sonine4 sonine4.5 sonine5 sonine6 sonine7 sonine8 sonine9 sonine10 sonine11 sonine12 ac1 ac2 ac3
ac4 ac5 ac6 ac7 compare1 compare3 ad1 ad2 ad3 ad4 ad5 ad6 ad7 ad8 ad8 ap1 ap2 ap3 ap4 ap6 ap7 ap8
ap11 ap11.5 ap11.6 ap12 ap12.5 ap13 ap14 ap15 ap16 ap17 ap18 ap19 ap20 ap21 ap21.5
"""
_FIGURES = "collision v0re hetomu2 msdtheory inelasticposi scalev impact sign soninediffuse"
_SEEN, FIGURES = _LABELS.split(), _FIGURES.split()
# the second occurrence of a label is ``label#2``
LABELS = [f"{x}#2" if x in _SEEN[:i] else x for i, x in enumerate(_SEEN)]


def test_every_label_of_the_paper_has_one_row(rows) -> None:
    assert list(PRINTED) == LABELS + FIGURES
    assert len(PRINTED) == 133
    assert [label for label in rows if ":" not in label] == list(PRINTED)
    for label in FIGURES:
        assert PRINTED[label].formula is None
        assert PRINTED[label].source == ""


def disagreements(source: str, formula: sp.Basic) -> list[str]:
    """The sides on which a formula does not say what its source says."""
    theirs = [pair for statement in read(source) for pair in pairwise(statement)]
    members = formula if isinstance(formula, sp.Tuple) else (formula,)
    if len(theirs) != len(members):
        return [f"{len(theirs)} equations are transcribed as {len(members)}"]
    return [
        f"{side} is transcribed as {ours}"
        for pair, member in zip(theirs, members, strict=True)
        for side, ours in zip(pair, member.args, strict=True)
        if not is_zero(side - ours)
    ]


@pytest.mark.parametrize("label", LABELS)
def test_a_transcription_says_what_its_source_says(label: str) -> None:
    assert disagreements(PRINTED[label].source, PRINTED[label].formula) == []


@pytest.mark.parametrize("label", slow_but(LABELS[::3], LABELS))
def test_a_changed_transcription_is_noticed(label: str, mutants: Mutants) -> None:
    for mutant in mutants(PRINTED[label].formula):
        if mutant != PRINTED[label].formula:
            assert disagreements(PRINTED[label].source, mutant), f"{label} accepts {mutant}"


@pytest.mark.parametrize("formulas", [{}, {"energy": sy.h, "picture": sy.h}])
def test_latex_and_transcription_must_both_be_there(formulas: dict[str, sp.Expr]) -> None:
    text = "% a remark\n\n%% Section\n\n% energy: of all\nE = m\n\n% picture: a sketch\n"
    with pytest.raises(ValueError, match="energy" if not formulas else "picture"):
        list(read_equations(text, formulas))
    energy, picture = read_equations(text, {"energy": sy.h})
    assert (energy.source, energy.title, energy.section) == ("E = m", "of all", "Section")
    assert picture.formula is None

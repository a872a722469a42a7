"""Formulas as LaTeX and MathML: every symbol keeps its letter, every formal piece its sign."""

from html import unescape
from xml.etree import ElementTree

import pytest
import sympy as sp

from derivations import symbols as sy
from derivations.formal import Avg, Dt, Int, Partial, Second, dot, eq
from derivations.printed import ROWS
from derivations.typesetting import LETTERS, latex, mathml, plain


def content(formula: sp.Basic) -> str:
    """The letters and signs of the MathML in their order, without the invisible ones."""
    root = ElementTree.fromstring(unescape(mathml(formula)))
    return "".join(root.itertext()).replace("\N{INVISIBLE TIMES}", "")


def test_latex_of_names_that_sympy_would_not_typeset() -> None:
    assert latex(sy.bv) == r"\mathbf{v}"
    assert latex(sy.msd(sy.t)) == r"\langle r^{2}\rangle_{e}{\left(t \right)}"
    assert latex(sp.Tuple(sy.a2, sy.h)) == r"a_{2},\quad h"
    assert latex(None) == ""


def test_plain_text() -> None:
    assert plain(sp.Tuple(eq(sy.h, sy.M2), sy.a2)) == "h = M_2; a_2"
    assert plain(sp.Le(sy.e, 1, evaluate=False)) == "e <= 1"
    assert plain(None) == ""


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        (sy.T(sy.t), "T(t)"),
        (sy.bvs, "𝐯*"),
        (sy.a2bar + sy.pm, "ā2+±"),
        (dot(sy.bv, sy.sigma), "σ̂·𝐯"),
        (Int(sy.f(sy.bv, sy.t), sy.sigma, sy.hemi), "∫𝐯·σ̂ > 0f(𝐯,t)dσ̂"),
        (Int(1 + sy.v, sy.bv), "∫[v+1]d𝐯"),
        (Partial(sy.T(sy.t), sy.t), "∂T(t)∂t"),
        (Second(sy.f(sy.v), sy.v, sy.c), "∂2f(v)∂v2|v=c"),
        (Dt(1, sy.T(sy.t)), "∂t(1)T(t)"),
        (Avg(sy.c**2), "⟨c2⟩"),
        (sp.log(sy.t), "ln(t)"),
        (sp.Derivative(sy.T(sy.t), sy.t), "ddtT(t)"),
    ],
)
def test_mathml_of_formal_pieces(formula: sp.Basic, expected: str) -> None:
    assert content(formula) == expected


def test_several_equations_are_several_elements() -> None:
    assert mathml(sp.Tuple(sy.a2, sy.h)).count("<math>") == 2
    assert mathml(None) == ""


@pytest.mark.parametrize("label", [label for label, row in ROWS.items() if row.formula is not None])
def test_the_mathml_of_a_row_is_well_formed_and_shows_no_name_of_python(label: str) -> None:
    text = mathml(ROWS[label].formula)
    ElementTree.fromstring(f"<div>{unescape(text)}</div>")
    assert not any(f">{name}<" in text for name in LETTERS if len(name) > 2)
    for name in ("Int", "Dot", "Partial", "Lam", "Avg", "Measure", "Second", "_vec", "_hat"):
        assert name not in text


def test_two_numbers_side_by_side_are_not_read_as_one() -> None:
    x = sp.Symbol("x")
    text = mathml(2 * sp.Integer(3) ** sp.Rational(3, 4) * sp.sqrt(5) * x)
    assert "<mn>2</mn><mo>·</mo><msup><mn>3</mn>" in text
    assert "<mo>&InvisibleTimes;</mo><msup><mn>" not in text

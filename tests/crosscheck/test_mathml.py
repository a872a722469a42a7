"""Formulas keep their letters on the page."""

import re
from html import unescape
from xml.etree import ElementTree

import pytest
import sympy as sp

from derivations import report_subset, verify
from kinetics.crosscheck.mathml import mathml
from kinetics.crosscheck.report.equations import report_equations


def letters(element: str) -> list[str]:
    return [unescape(found) for found in re.findall(r"<mi[^>]*>([^<]*)</mi>", element)]


def test_an_unknown_function_keeps_its_case() -> None:
    t = sp.Symbol("t")
    assert letters(mathml(sp.Function("T")(t))) == ["T", "t"]
    assert letters(mathml(sp.Function("D_e")(t))) == ["D", "e", "t"]


def test_names_in_latex_are_set_as_what_they_stand_for() -> None:
    assert letters(mathml(sp.Symbol(r"\bar{a}_2")))[0] == "ā"
    assert letters(mathml(sp.Symbol("pm"))) == ["±"]


def test_a_chain_has_one_element_per_link_and_nothing_has_none() -> None:
    x = sp.Symbol("x")
    assert mathml(sp.Tuple(x, 2 * x)).count("<math>") == 2
    assert mathml(None) == ""


@pytest.mark.parametrize("label", report_subset)
def test_no_latex_is_left_in_the_reports_formulas(label: str) -> None:
    check = verify([label])[0]
    for element in (mathml(check.printed), mathml(check.derived)):
        assert "\\" not in element
        assert "{" not in element


def test_the_reports_equations_are_well_formed() -> None:
    for equation in report_equations():
        root = ElementTree.fromstring(equation.mathml)
        assert root.tag == "math"
        assert equation.text.endswith(".")

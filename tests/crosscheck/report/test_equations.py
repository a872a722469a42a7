"""The equations of the pages are those that the derivations print."""

from html import unescape
from xml.etree import ElementTree

import pytest

from kinetics.crosscheck.report.equations import (
    FORMULAS,
    OF_ANY_LAW,
    Equation,
    comparison_equations,
    printed,
    report_equations,
)


def test_the_stored_equations_are_the_derivations_own() -> None:
    # after a change of the derivations: python -m kinetics.crosscheck.report.equations
    found = {name: "".join(formulas) for name, formulas in printed().items()}
    assert [equation.mathml for equation in report_equations()] == [found[n] for n in FORMULAS]
    stored = [{e.mathml for e in report_equations(dimension)} for dimension in (2, 3)]
    assert stored[0] | stored[1] == {found[name] for name in OF_ANY_LAW}
    # the measure of the other dimension, and in the plane the averages over spheres
    assert stored[0] - stored[1] == {found["measure_plane"]}
    assert stored[1] - stored[0] == {found["measure_space"], found["averages_space"]}


@pytest.mark.parametrize(
    "equation",
    [*report_equations(), *report_equations(2), *report_equations(3), *comparison_equations()],
)
def test_equations_are_well_formed_and_introduced(equation: Equation) -> None:
    root = ElementTree.fromstring(f"<p>{unescape(equation.mathml)}</p>".replace(" > ", " &gt; "))
    assert {element.tag for element in root} == {"math"}
    assert equation.text.endswith(".")
    assert "\\" not in equation.mathml


def test_a_comparison_states_the_equation_and_its_chi_square() -> None:
    names = [equation.text.split()[0] for equation in comparison_equations()]
    assert names == ["A", "Between", "Differences"]
    assert "⊤" in comparison_equations()[-1].mathml

"""The page of a comparison, which needs nothing beside it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from kinetics.crosscheck.compare.figures import picture
from kinetics.crosscheck.compare.result import OUTCOMES, Comparison
from kinetics.crosscheck.compare.tables import (
    MEANING_OF_COLUMNS,
    MEANING_OF_EXPLANATIONS,
    table_of_rows,
    table_of_tests,
)
from kinetics.crosscheck.compare.text import (
    Statement,
    explanation_text,
    statements,
    verdict_sentence,
)
from kinetics.crosscheck.files import rendered

if TYPE_CHECKING:
    from markupsafe import Markup

#: Where an SVG names one of its elements, or refers to it.
NAME_OF_ELEMENT = re.compile(r'(\bid="|href="#|url\(#)')


def render(comparison: Comparison, json_name: str) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    json_name : name of the file beside it that has every number
    """
    return rendered(
        "comparison.html.j2",
        result=comparison,
        verdict=verdict_sentence(comparison),
        statements=statements(comparison),
        explanations=[
            Statement(f"{item.name}: {OUTCOMES[item.outcome]}", explanation_text(item))
            for item in comparison.explanations
        ],
        tests=table_of_tests(comparison.tests),
        rows=table_of_rows(comparison.numbers, comparison.numbers),
        meaning=MEANING_OF_COLUMNS,
        meaning_of_explanations=MEANING_OF_EXPLANATIONS,
        figures=[_svg_element(comparison, name) for name in comparison.figures],
        json_name=json_name,
    )


def _svg_element(comparison: Comparison, name: str) -> Markup:
    """Return a figure as an element of a page, in which no other figure has names of its elements.

    Matplotlib gives the same glyph the same name in all figures.
    """
    from markupsafe import Markup

    drawing = picture(comparison, [name]).decode()
    element = drawing[drawing.index("<svg") :]  # without the declaration of XML
    return Markup(NAME_OF_ELEMENT.sub(rf"\1{name}-", element))

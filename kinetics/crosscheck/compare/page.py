"""The page of a comparison, which needs nothing beside it."""

from __future__ import annotations

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


def render(comparison: Comparison, json_name: str) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    json_name : name of the file beside it that has every number
    """
    from markupsafe import Markup

    svg = ""
    if comparison.figures:
        drawing = picture(comparison, comparison.figures).decode()
        svg = drawing[drawing.find("<svg") :]  # without the declaration of XML
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
        svg=Markup(svg),
        json_name=json_name,
    )

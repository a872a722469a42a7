"""The directive ``paper-figures``: the paper's nine figures, made again by the report's own code.

The pictures, what the paper shows and the verdicts are those of
``lorentz report --figures-of-the-paper``.
"""

from base64 import b64encode
from html import escape

from docutils import nodes
from docutils.parsers.rst import Directive


def _section(entry) -> nodes.section:
    """A heading, the picture, and two sentences."""
    title = f"Figure {entry.number}: {entry.title}"
    section = nodes.section(ids=[f"figure-{entry.number}"])
    section += nodes.title("", title)
    data = b64encode(entry.drawn.file("svg")).decode()
    picture = f'<p><img alt="{escape(title)}" src="data:image/svg+xml;base64,{data}"></p>'
    section += nodes.raw("", picture, format="html")
    words = f"<p><strong>In the paper:</strong> {escape(entry.in_the_paper)}</p>"
    words += f"<p><strong>Here:</strong> {escape(entry.verdict)}</p>"
    section += nodes.raw("", words, format="html")
    return section


class PaperFigures(Directive):
    """A section for each figure."""

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        from kinetics.crosscheck.report.paper_figures import draw_paper_figures
        from kinetics.crosscheck.report.systems import Cooling

        return [_section(entry) for entry in draw_paper_figures(Cooling().quick()).figures]


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("paper-figures", PaperFigures)
    return {"parallel_read_safe": True}

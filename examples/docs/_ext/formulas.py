"""Formulas as MathML, which browsers show without a script or a font.

The LaTeX of the pages is translated by docutils; a formula that it cannot translate is an error.
"""

import re

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

_DIGITS = re.compile(r"frac(\d)(\d)")  # one digit over another, as TeX reads it
_FUNCTION = re.compile(r"\\(ln|cos|sin|exp)(?= |\\[a-z])")  # before a letter: ln n


def _mathml(node, **options) -> str:
    text = _DIGITS.sub(r"frac{\1}{\2}", node.astext())
    return tex2mathml(_FUNCTION.sub(r"\\\1\\,", text), **options)


def _inline(translator, node) -> None:
    translator.body.append(_mathml(node))
    raise nodes.SkipNode


def _block(translator, node) -> None:
    translator.body.append(f'<div class="formula">{_mathml(node, as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True}

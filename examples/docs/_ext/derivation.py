"""The directive ``derivation``: a result and how it is derived, from `derivations` itself.

```{derivation} beyond:cooling-rate beyond:a2
```

Nothing is typed again: title, formula, steps and verdict are those of ``lorentz derive``. A result
whose verdict is not "verified" is an error.
"""

from functools import cache
from html import escape
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive

_BLOCK = '<math display="block"'


@cache
def _html(label: str) -> str:
    from derivations import Status, verify

    (check,) = verify([label])
    if check.status is not Status.VERIFIED:
        raise ValueError(f"{label}: {check.status}, not verified")
    steps = "".join(f"<li>{escape(step.text)}{_shown(step.formula)}</li>" for step in check.steps)
    numbers = "".join(f"<li>{escape(n.name)} = {n.value:.7g}</li>" for n in check.numbers)
    note = f"<p>{escape(check.note)}</p>" if check.note else ""
    return (
        f'<div class="derivation"><p class="title">{escape(check.title)}</p>'
        f"{_shown(check.printed)}"
        f"<details><summary>Derivation <code>{escape(label)}</code></summary>"
        f"<ol>{steps}</ol>{f'<ul>{numbers}</ul>' if numbers else ''}{note}</details></div>"
    )


def _shown(formula: Any) -> str:
    """A formula; the members of a Tuple on lines of their own."""
    from derivations.typesetting import mathml

    parts = (
        () if formula is None else formula.args if formula.func.__name__ == "Tuple" else [formula]
    )
    elements = (mathml(part, "rev-lex").replace("<math", _BLOCK, 1) for part in parts)
    return "".join(f'<div class="formula">{element}</div>' for element in elements)


class Derivation(Directive):
    """One or more labels of `derivations`, each with its formula and its steps."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        labels = self.arguments[0].split()
        return [nodes.raw("", _html(label), format="html") for label in labels]


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("derivation", Derivation)
    return {"parallel_read_safe": True}

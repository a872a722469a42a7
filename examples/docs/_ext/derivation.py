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


@cache
def _check(label: str) -> Any:
    from derivations import Status, verify

    (check,) = verify([label])
    if check.status is not Status.VERIFIED:
        raise ValueError(f"{label}: {check.status}, not verified")
    return check


def _html(label: str, known: set[str]) -> str:
    """Formula, its symbols that are not yet known on this page, and the folded steps."""
    check = _check(label)
    steps = "".join(f"<li>{escape(step.text)}{_shown(step.formula)}</li>" for step in check.steps)
    steps = f"<ol>{steps}</ol>" if steps else ""
    numbers = "".join(f"<li>{escape(n.name)} = {n.value:.7g}</li>" for n in check.numbers)
    note = f"<p>{escape(check.note)}</p>" if check.note else ""
    return (
        f'<div class="derivation"><p class="title">{escape(check.title)}</p>'
        f"{_shown(check.printed)}{_symbols(check.printed, known)}"
        f"<details><summary>Derivation <code>{escape(label)}</code></summary>"
        f"{steps}{f'<ul>{numbers}</ul>' if numbers else ''}{note}</details></div>"
    )


def _shown(formula: Any) -> str:
    """A formula; the members of a Tuple on lines of their own."""
    from derivations.printers import mathml

    parts = (
        () if formula is None else formula.args if formula.func.__name__ == "Tuple" else [formula]
    )
    return "".join(f'<div class="formula">{mathml(p, "rev-lex", "block")}</div>' for p in parts)


def _symbols(formula: Any, known: set[str]) -> str:
    """What the symbols of a formula mean, from the table of `derivations`."""
    import sympy as sp
    from sympy.core.function import AppliedUndef

    from derivations.printers import mathml
    from derivations.symbols import table

    names = {symbol.name for symbol in formula.atoms(sp.Symbol)}
    names |= {applied.func.__name__ for applied in formula.atoms(AppliedUndef)}
    new = [(name, meaning) for name, meaning in table() if name in names - known]
    known |= names
    meanings = (f"{mathml(sp.Symbol(name))}: {escape(meaning)}" for name, meaning in new)
    return f'<p class="symbols">{"; ".join(meanings)}.</p>' if new else ""


class Derivation(Directive):
    """One or more labels of `derivations`, each with its formula and its steps."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        known = self.state.document.settings.env.current_document.setdefault("symbols", set("eptv"))
        labels = self.arguments[0].split()
        return [nodes.raw("", _html(label, known), format="html") for label in labels]


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("derivation", Derivation)
    return {"parallel_read_safe": True}

"""The directives ``derivation`` and ``errata``: results and misprints, from `derivations` itself.

```{derivation} beyond:cooling-rate beyond:a2
```

A result and how it is derived. Nothing is typed again: title, formula, steps and verdict are those
of ``lorentz derive``. A result whose verdict is not "verified" is an error.

```{errata}
```

The errata of the paper as a list: what is printed, what is right, what it changes.
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
    from derivations.printers import mathml, members

    lines = (mathml(member, "rev-lex", "block") for member in members(formula))
    return "".join(f'<div class="formula">{line}</div>' for line in lines)


def _symbols(formula: Any, known: set[str]) -> str:
    """What the symbols of a formula mean, from the table of `derivations`."""
    import sympy as sp

    from derivations.printers import mathml, symbol_meanings

    meanings = [
        f"{mathml(sp.Symbol(name))}: {escape(meaning)}"
        for name, meaning in symbol_meanings([formula])
        if name not in known
    ]
    known |= {name for name, _ in symbol_meanings([formula])}
    return f'<p class="symbols">{"; ".join(meanings)}.</p>' if meanings else ""


class Derivation(Directive):
    """One or more labels of `derivations`, each with its formula and its steps."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        known = self.state.document.settings.env.current_document.setdefault("symbols", set("eptv"))
        labels = self.arguments[0].split()
        return [nodes.raw("", _html(label, known), format="html") for label in labels]


class Errata(Directive):
    """The errata of the paper, as ``lorentz derive`` lists them."""

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        from derivations import ERRATA

        items = "".join(
            f"<li>Eq. ({erratum.number}), <code>{escape(erratum.label)}</code>. "
            f"Printed: {escape(erratum.printed)} Right: {escape(erratum.correct)} "
            f"What changes: {escape(erratum.changes)}</li>"
            for erratum in ERRATA
        )
        return [nodes.raw("", f'<ul class="errata">{items}</ul>', format="html")]


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("derivation", Derivation)
    app.add_directive("errata", Errata)
    return {"parallel_read_safe": True}

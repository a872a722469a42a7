"""The command `derive`: re-derives the paper's equations with sympy."""

from collections import Counter
from pathlib import Path
from typing import Any

import click

from kinetics.crosscheck.cli import options
from kinetics.crosscheck.cli.options import Output, json_option, print_json, progress, refuse_given
from kinetics.errors import InputError


@click.command(
    short_help="Re-derive the paper's equations with sympy.",
    epilog=options.example("lorentz derive --only B15", "The option --search finds labels."),
)
@click.option(
    "--only", metavar="LABEL", help="One equation, by label or number, with all steps: B15."
)
@click.option("--list", "listed", is_flag=True, help="List the equations and derive nothing.")
@click.option("--search", metavar="WORD", help="List those whose label, title or LaTeX has this.")
@click.option("--latex", type=Output(""), metavar="FILE", help="Write a LaTeX document.")
@json_option
def derive(
    only: str | None, listed: bool, search: str | None, latex: Path | None, as_json: bool
) -> None:
    """Re-derive the paper's equations with sympy and compare each with the printed formula."""
    from derivations.printed import ROWS

    if listed or search is not None:
        refuse_given(["only", "latex"], "--list and --search")
        word = (search or "").casefold()
        parts = ("number", "label", "title", "section", "source")
        rows = [r for r in ROWS.values() if any(word in getattr(r, p).casefold() for p in parts)]
        if not rows:
            raise InputError(f"search: got {search!r}; it is in none of the {len(ROWS)} equations")
        if as_json:
            names = ("number", "label", "title", "section")
            print_json({"equations": [{n: getattr(row, n) for n in names} for row in rows]})
        else:
            _show([(row.label, row.title) for row in rows])
        return

    from derivations import to_json, to_latex_document, to_text, verify
    from kinetics.crosscheck.files import write_together

    labels = ROWS if only is None else [only]
    with progress(len(labels)) as tell:
        checks: list[Any] = []
        for label in labels:
            checks += verify([label])
            tell(label)
    if latex is not None:
        write_together(latex.parent, {latex.name: to_latex_document(checks)})
    if as_json:
        print_json(to_json(checks))
    elif only is not None:
        click.echo(to_text(checks[0]))
    else:
        colours = {"verified": "green"}
        statuses = [click.style(f"{c.status:12}", colours.get(c.status, "yellow")) for c in checks]
        _show([(c.label, f"{s} {c.title}") for c, s in zip(checks, statuses, strict=True)])
        counts = Counter(check.status for check in checks)
        click.echo(", ".join(f"{n} {status}" for status, n in counts.items()))


def _show(rows: list[tuple[str, str]]) -> None:
    """One line for each equation: number, label, and what is said of it."""
    from derivations.printed import ROWS

    width = max(len(label) for label, _ in rows)
    for label, text in rows:
        click.echo(f"{ROWS[label].number:4}{label:{width}} {text}")

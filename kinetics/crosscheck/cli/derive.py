"""The command `derive`: re-derives the paper's equations with sympy."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinetics.crosscheck.cli import options
from kinetics.crosscheck.cli.options import Output, json_option, print_json, progress, refuse_given
from kinetics.errors import InputError

if TYPE_CHECKING:
    from derivations import Check, PrintedEquation

#: Columns of the summary's text. Chosen: a terminal of the usual 80 columns shows it unbroken.
SUMMARY_WIDTH = 79
#: Columns of the longest status, "not derived", and a space.
STATUS_WIDTH = 12
#: What a search looks at in each equation.
SEARCHED_FIELDS = ("number", "label", "title", "section", "source")
#: What a list in JSON gives of each equation.
LISTED_FIELDS = ("number", "label", "title", "section")


@click.command(
    short_help="Re-derive the paper's equations with sympy.",
    epilog=options.example("lorentz derive --only B15"),
)
@click.option(
    "--only",
    metavar="LABEL",
    help="One equation with all steps, by label or number: B15, b15, 'eq. 22'.",
)
@click.option("--list", "listed", is_flag=True, help="List the equations and derive nothing.")
@click.option("--search", metavar="WORD", help="List equations with WORD in label, title or LaTeX.")
@click.option(
    "--latex",
    type=Output(""),
    metavar="FILE",
    help="Write a LaTeX document of all equations; with --only, of that one and its symbols.",
)
@json_option
def derive(
    only: str | None, listed: bool, search: str | None, latex: Path | None, as_json: bool
) -> None:
    """Re-derive the paper's equations with sympy and compare each with the printed formula."""
    if listed or search is not None:
        refuse_given(["only", "latex"], "--list and --search")
        list_equations(search or "", as_json)
        return

    from derivations import to_json, to_latex_document, to_text
    from kinetics.crosscheck.files import write_together

    checks = derive_checks(only)
    if latex is not None:
        write_together(latex.parent, {latex.name: to_latex_document(checks)})
    if as_json:
        print_json(to_json(checks))
    elif only is not None:
        click.echo(to_text(checks[0]))
    else:
        show_checks(checks)
        show_summary(checks)
    if latex is not None and not as_json:
        click.echo(f"wrote {latex}")


def list_equations(search: str, as_json: bool) -> None:
    """Print the equations that have a text in one of their fields; nothing is derived."""
    from derivations.printed import ROWS

    text = search.casefold()
    equations = [row for row in ROWS.values() if contains(row, text)]
    if not equations:
        raise InputError(f"search: got {search!r}; it is in none of the {len(ROWS)} equations")
    if as_json:
        records = [{name: getattr(row, name) for name in LISTED_FIELDS} for row in equations]
        print_json({"equations": records})
    else:
        show_rows([(row.label, row.title) for row in equations])


def contains(equation: PrintedEquation, text: str) -> bool:
    """Whether one of the searched fields has the text, capitals aside."""
    fields = (getattr(equation, name) for name in SEARCHED_FIELDS)
    return any(text in field.casefold() for field in fields)


def derive_checks(only: str | None) -> list[Check]:
    """Derive one equation, or all of them with a progress bar."""
    from derivations import verify
    from derivations.printed import ROWS

    labels = list(ROWS) if only is None else [only]
    checks: list[Check] = []
    with progress(len(labels)) as report_progress:
        for label in labels:
            checks += verify([label])
            report_progress(label)
    return checks


def show_checks(checks: Iterable[Check]) -> None:
    """Print one line for each equation: its status, its verdict if it has one, its title."""
    rows = []
    for check in checks:
        colour = "green" if check.status == "verified" else "yellow"
        status = click.style(f"{check.status:{STATUS_WIDTH}}", colour)
        verdict = f"{check.verdict}: " if check.verdict else ""
        rows.append((check.label, f"{status} {verdict}{check.title}"))
    show_rows(rows)


def show_rows(rows: Sequence[tuple[str, str]]) -> None:
    """Print one line for each equation: number, label, and a text."""
    from derivations.printed import ROWS

    label_width = max(len(label) for label, _ in rows)
    for label, text in rows:
        click.echo(f"{ROWS[label].number:4}{label:{label_width}} {text}")


def show_summary(checks: Iterable[Check]) -> None:
    """Print how many rows have each status and what it means, then every erratum."""
    from derivations import ERRATA, Status

    counts = Counter(check.status for check in checks)
    click.echo("\nWhat the rows are, and how many:")
    for status in Status:
        if counts[status]:
            show_paragraph(f"{counts[status]:4} {status:{STATUS_WIDTH}}", status.meaning)

    click.echo("\nErrata, with what is printed, what is right, and what changes:")
    for erratum in ERRATA:
        click.echo(f"eq. ({erratum.number}) {erratum.label}")
        show_paragraph("    printed:  ", erratum.printed)
        show_paragraph("    right:    ", erratum.correct)
        show_paragraph("    changes:  ", erratum.changes)


def show_paragraph(head: str, text: str) -> None:
    """Print a text after a head, its further lines indented as wide as that."""
    indent = " " * len(head)
    lines = textwrap.fill(
        text, SUMMARY_WIDTH, initial_indent=head, subsequent_indent=indent, break_on_hyphens=False
    )
    click.echo(lines)

"""The command `derive`: re-derives the paper's equations with sympy."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import click

from kinetics.crosscheck.cli.options import json_option, output_path, print_json


@click.command(short_help="Re-derive the paper's equations with sympy.")
@click.option("--only", metavar="LABEL", help="One equation, with the steps of its derivation.")
@click.option("--latex", type=output_path, metavar="FILE", help="Write a LaTeX document.")
@json_option
def derive(only: str | None, latex: Path | None, as_json: bool) -> None:
    """Re-derive the paper's equations with sympy and compare each with the printed formula."""
    from kinetics.crosscheck.files import require_file, write_together

    if latex is not None:
        require_file("latex", latex)

    from derivations import to_json, to_latex_document, to_text, verify

    checks = verify(None if only is None else [only])
    if latex is not None:
        write_together(latex.parent, {latex.name: to_latex_document(checks)})
    if as_json:
        print_json(to_json(checks))
    elif only is not None:
        click.echo(to_text(checks[0]))
    else:
        width = max(len(check.label) for check in checks)
        for check in checks:
            status = click.style(
                f"{check.status:12}", fg="green" if check.status == "verified" else "yellow"
            )
            click.echo(f"{check.label:{width}} {status} {check.title}")
        counts = Counter(check.status for check in checks)
        click.echo(", ".join(f"{n} {status}" for status, n in counts.items()))

"""The command `derive`: re-derives the paper's equations with sympy."""

from collections import Counter
from pathlib import Path

import click

from kinetics.crosscheck.cli.options import Output, json_option, print_json


@click.command(short_help="Re-derive the paper's equations with sympy.")
@click.option("--only", metavar="LABEL", help="One equation, with the steps of its derivation.")
@click.option("--latex", type=Output(""), metavar="FILE", help="Write a LaTeX document.")
@json_option
def derive(only: str | None, latex: Path | None, as_json: bool) -> None:
    """Re-derive the paper's equations with sympy and compare each with the printed formula."""
    from derivations import to_json, to_latex_document, to_text, verify
    from kinetics.crosscheck.files import write_together

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

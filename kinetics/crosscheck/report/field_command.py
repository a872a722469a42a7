"""What `lorentz report --field` does."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from kinetics.crosscheck.commands.options import print_json

_MEANT = ("restitutions", "dimension", "rtol", "seed", "workers")
"""Options of the report on the system that the report in a field has too."""


def report_in_field(
    output: Path, quick: bool, figures: Sequence[str], as_json: bool, system: dict[str, Any]
) -> None:
    """Make the report and write it; options that it does not have are refused."""
    given = _given(system)
    from kinetics.crosscheck.files import require_writable_folder
    from kinetics.crosscheck.report.field_settings import FieldSettings

    if "dimension" in given:
        given["dimensions"] = (given.pop("dimension"),)
    settings = FieldSettings(**given)
    if quick:
        settings = settings.quick()
    require_writable_folder(output)

    from tqdm import tqdm

    from kinetics.crosscheck.report import field_report as work
    from kinetics.crosscheck.report.field_page import verdict_table

    with tqdm(total=work.stages(settings), file=sys.stderr, disable=None, leave=False) as bar:

        def tell(stage: str) -> None:
            bar.set_description(stage, refresh=False)
            bar.update(1)

        document = work.make_field_report(settings, tell)
    written = work.write_field_report(document, output, figures)
    if as_json:
        print_json(document)
    else:
        for finding in document["findings"]:
            click.echo(finding)
        click.echo(verdict_table(document))
        click.echo(f"wrote {' and '.join(str(path) for path in written)}")


def _given(system: dict[str, Any]) -> dict[str, Any]:
    """The options that the user gave. click.UsageError for those that have no meaning here."""
    context = click.get_current_context()
    given = {
        name: value
        for name, value in system.items()
        if context.get_parameter_source(name) is not ParameterSource.DEFAULT
    }
    for parameter in context.command.params:
        if parameter.name in given and parameter.name not in _MEANT:
            raise click.UsageError(f"{parameter.opts[-1]}: not with --field")
    return given

"""The command `lorentz fit`; what it needs is imported when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from kinetics.crosscheck.cli import options
from kinetics.crosscheck.cli.comparison_output import ComparisonOutput, output_options
from kinetics.crosscheck.cli.track_options import (
    DATA_HELP,
    data_argument,
    reading_options,
    system_options,
    with_frame_interval,
)


@click.command(
    epilog=options.example("lorentz fit data.csv -o fitted.html", DATA_HELP),
    short_help="Fit restitution and density to particle data.",
)
@data_argument
@system_options
@reading_options
@output_options
def fit(
    data: tuple[Path, ...],
    output: Path | None,
    figures: tuple[str, ...],
    rows: bool,
    as_json: bool,
    **arguments: Any,
) -> None:
    """Fit the restitution and the density of scatterers to particle data from any program.

    Prints both with their errors, in d and U and in the data's units, the medium that fits best,
    and the chi-square of its theory. The page of --output shows their joint confidence region.
    """
    from kinetics import fit as fit_data

    destination = ComparisonOutput(output, figures, rows, as_json)
    destination.check(data)
    settings = with_frame_interval(arguments)
    with options.progress(name="fitting"):
        comparison = fit_data(list(data), **settings)
    destination.show(comparison)

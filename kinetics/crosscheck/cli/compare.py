"""The command `lorentz compare`; what it needs is imported when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from click import option

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
    epilog=options.example("lorentz compare data.csv -e 0.7 -o compared.html", DATA_HELP),
    short_help="Compare anybody's particle data with the kinetic equation.",
)
@data_argument
@option(
    "-e",
    "--restitution",
    type=float,
    help="Coefficient of restitution, 0 to 1. [default: an Ensemble's own, or fitted]",
)
@option(
    "--number-density",
    type=float,
    help="Scatterers per area (volume), in the data's unit of length. [default: as of -e]",
)
@system_options
@option(
    "--field",
    type=float,
    default=0.0,
    help="Uniform acceleration along +x in U^2/d: drift, speed and variances are compared.",
)
@options.mass_option
@options.drive_options
@reading_options
@output_options
@option(
    "--fail-on",
    type=click.Choice(["differs", "unclear"]),
    help="End with exit status 1 where data and equation differ (or may: unclear).",
)
def compare(
    data: tuple[Path, ...],
    restitution: float | None,
    viscoelastic: float | None,
    output: Path | None,
    figures: tuple[str, ...],
    rows: bool,
    as_json: bool,
    fail_on: str | None,
    **arguments: Any,
) -> int:
    """Compare particle data, from any code, with the kinetic equation.

    Restitution, density and start are found in the data where they are not specified. Prints the
    verdict, the numbers of the theory, the clearest deviation and what explains it; with --rows
    also data, theory and differences over time, and a chi-square for each observable.
    """
    from kinetics import compare as compare_data

    law = options.impact_law(viscoelastic, "kinetics", restitution)
    destination = ComparisonOutput(output, figures, rows, as_json)
    destination.check(data)
    settings = with_frame_interval(arguments)
    with options.progress(name="comparing"):
        comparison = compare_data(list(data), restitution=law, **settings)
    destination.show(comparison)
    is_failure = fail_on is not None and comparison.verdict in ("differs", fail_on)
    return int(is_failure)

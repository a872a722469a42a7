"""The command `lorentz compare`; what it needs is imported when it runs.

In help texts d is the diameter of a scatterer and of the tracer, U the standard deviation of one
component of the initial velocity.
"""

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
    short_help="Compare particle data from any program with the kinetic equation.",
)
@data_argument
@option(
    "-e",
    "--restitution",
    type=float,
    help="Coefficient of restitution, 0 to 1. [default: from a saved run, else fitted]",
)
@option(
    "--number-density",
    type=float,
    help="Scatterers per area (in space per volume), in the data's unit of length. "
    "[default: from a saved run, else fitted]",
)
@system_options
@option(
    "--field",
    type=float,
    default=0.0,
    help="Uniform acceleration along +x, in U^2/d. Drift, speed and variances are compared.",
)
@options.mass_option
@options.drive_options
@reading_options
@output_options
@option(
    "--fail-on",
    type=options.Word(["differs", "unclear"]),
    help="End with exit status 1 if data and theory differ; with unclear, also if the data cannot "
    "decide.",
)
def compare(
    data: tuple[Path, ...],
    restitution: float | None,
    viscoelastic: float | None,  # of `options.drive_options`
    output: Path | None,
    figures: tuple[str, ...],  # formats of their files, "pdf", "png" or "svg"
    rows: bool,
    as_json: bool,
    fail_on: str | None,
    **arguments: Any,
) -> int:
    """Compare particle data from any program with the kinetic equation.

    Restitution, density and initial speeds are estimated from the data unless you specify them.
    Prints the verdict, the parameters of the theory, the largest deviation and its likeliest cause.
    With --rows it also prints data, theory and differences over time, and the chi-square of each
    observable. Several files are several independent runs of the same system.
    """
    from kinetics import compare as compare_data

    # the class `kinetics.Viscoelastic`: `particles` has one of this name too
    law = options.impact_law(viscoelastic, "kinetics", restitution)
    destination = ComparisonOutput(output, figures, rows, as_json)
    destination.check(data)  # before the work: files can be written, and are none of the data
    settings = with_frame_interval(arguments)
    with options.progress(name="comparing"):
        comparison = compare_data(list(data), restitution=law, **settings)
    destination.show(comparison)
    # the verdict is "agrees", "unclear", "differs" or "not tested"; "differs" fails in either case
    is_failure = fail_on is not None and comparison.verdict in ("differs", fail_on)
    return int(is_failure)  # the status with which `kinetics.cli.main` ends

"""The command `stress`. What it needs is imported when it runs: --help stays quick."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinetics.crosscheck.commands.options import json_option
from kinetics.crosscheck.commands.sweeps import output_option, run_and_write, show

if TYPE_CHECKING:
    from kinetics.crosscheck.stress.report import StressReport


@click.command(short_help="Drive solvers and particles to their limits; a verdict for each case.")
@click.option("--quick", is_flag=True, help="Fewer cases, in one to two minutes.")
@click.option(
    "--group", "groups", multiple=True, help="Run this group alone; may be repeated. [default: all]"
)
@output_option("stress.json and stress.md")
@json_option
@click.pass_context
def stress(
    context: click.Context,
    quick: bool,
    groups: tuple[str, ...],
    output: Path | None,
    as_json: bool,
) -> None:
    """Drive solvers and particles to their limits, and give each case a verdict.

    Restitution to within 1e-10 of 0 and 1, times to 1e300, speeds from 1e-150 to 1e150, rough
    starts, dense media, grazing and corner starts: error reached against error asked, invariants,
    and the worst case of each group. Ends with status 1 if a case ended as it must not. All of it
    takes about half an hour; Ctrl-C or SIGTERM reports what has been run by then.
    """
    from kinetics.crosscheck.stress.run import run_stress

    def interrupted(report: StressReport) -> None:
        show(report, output, as_json)
        click.echo(f"lorentz: interrupted: {report.not_run} cases were not run", err=True)

    report = run_and_write(
        lambda tell: run_stress(quick, groups or None, tell, interrupted), output, as_json
    )
    if report.rejected:
        context.exit(1)

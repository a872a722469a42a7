"""The commands `bench` and `stress`: measure, print the tables, and write them."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import click

from kinetics.crosscheck.cli.options import Command, Output, Word, example, json_option, progress
from kinetics.errors import printable

if TYPE_CHECKING:
    from kinetics.crosscheck.stress import StressReport

#: Cases of the benchmark: those of `kinetics.crosscheck.bench_problems`, which is slow to import.
CASES = ("scaled", "cooling", "position", "field", "driven", "particles")


class WritableReport(Protocol):
    """A report of either command."""

    def to_json(self) -> str:
        """Return one JSON document."""

    def markdown(self) -> str:
        """Return its tables in Markdown."""


def _output_option(names: str) -> Callable[[Command], Command]:
    """Return the option of the folder for these files."""
    return click.option(
        "-o", "--output", type=Output(), help=f"Folder for {names}. [default: none is written]"
    )


@click.command(
    epilog=example("lorentz bench --quick --case scaled", "Nothing else should run meanwhile."),
    short_help="Measure run time against error.",
)
@click.option("--quick", is_flag=True, help="Fewer cases, about a minute; else about ten.")
@click.option(
    "--case",
    "cases",
    multiple=True,
    type=Word(CASES),
    help="Measure this alone; may be repeated. [default: all]",
)
@_output_option("bench.json and bench.md")
@json_option
def bench(quick: bool, cases: tuple[str, ...], output: Path | None, as_json: bool) -> None:
    """Measure the solver against references of 1e-12 or better, and the particles.

    Prints Markdown tables: run time for an error, collisions per second, and what failed.
    """
    from kinetics.crosscheck.bench import run_bench

    with progress() as tell:
        report = run_bench(quick, cases or None, tell)
    _show(report, output, as_json)


@click.command(
    epilog=example("lorentz stress --quick --group driven", "A wrong --group names the groups."),
    short_help="Drive solvers and particles to their limits; a verdict for each case.",
)
@click.option("--quick", is_flag=True, help="Fewer cases, in one to two minutes.")
@click.option(
    "--group", "groups", multiple=True, help="Run this group alone; may be repeated. [default: all]"
)
@_output_option("stress.json and stress.md")
@json_option
def stress(quick: bool, groups: tuple[str, ...], output: Path | None, as_json: bool) -> int:
    """Drive solvers and particles to their limits, and give each case a verdict.

    Restitution to within 1e-10 of 0 and 1, times to 1e300, speeds from 1e-150 to 1e150, rough
    starts, dense media: error reached against error asked, invariants, and the longest time of each
    group. Ends with status 1 if a case ended as it must not. All of it takes five to fifteen
    minutes; Ctrl-C or SIGTERM reports what has been run by then.
    """
    from kinetics.crosscheck.stress import run_stress

    # `run_stress` calls it and lets the interruption go on, which ends the command.
    def interrupted(report: "StressReport") -> None:
        _show(report, output, as_json)
        click.echo(f"lorentz: interrupted: {report.not_run} cases were not run", err=True)

    with progress() as tell:
        report = run_stress(quick, groups or None, tell, interrupted)
    _show(report, output, as_json)
    return int(bool(report.rejected))  # the status with which `kinetics.cli.main` ends


def _show(report: WritableReport, output: Path | None, as_json: bool) -> None:
    """Print what a run gave, Markdown with its tables drawn on a terminal, and write its files."""
    from kinetics.crosscheck.files import write_together

    if as_json:
        click.echo(report.to_json(), nl=False)
    elif sys.stdout.isatty():
        from rich.console import Console
        from rich.markdown import Markdown

        Console().print(Markdown(report.markdown()))
    else:
        click.echo(report.markdown(), nl=False)
    if output is not None:
        name = click.get_current_context().command.name
        contents = {f"{name}.json": report.to_json(), f"{name}.md": report.markdown()}
        for path in write_together(output, contents):
            if not as_json:
                click.echo(f"wrote {printable(path)}")

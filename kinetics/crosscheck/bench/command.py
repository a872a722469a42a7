"""The command `bench`. What it needs is imported when it runs: --help stays quick."""

from __future__ import annotations

from pathlib import Path

import click

from kinetics.crosscheck.commands.options import json_option
from kinetics.crosscheck.commands.sweeps import output_option, run_and_write

CASES = ("scaled", "cooling", "position", "field", "accuracy", "skipping", "cost", "particles")


@click.command(short_help="Measure run time against error, and what skipping saves.")
@click.option("--quick", is_flag=True, help="Fewer cases, about a minute; else about ten.")
@click.option(
    "--case", "cases", multiple=True, type=click.Choice(CASES),
    help="Measure this alone; may be repeated. [default: all]",
)  # fmt: skip
@output_option("bench.json, bench.md and work-precision.svg")
@json_option
def bench(quick: bool, cases: tuple[str, ...], output: Path | None, as_json: bool) -> None:
    """Measure every method on the same problems, against references of 1e-13 or better.

    Prints Markdown tables: run time for an error, error asked against error reached, what skipping
    saves, run time against the amount of work, collisions per second, and what failed.
    """
    from kinetics.crosscheck.bench.run import run_bench

    run_and_write(lambda tell: run_bench(quick, cases or None, tell), output, as_json)

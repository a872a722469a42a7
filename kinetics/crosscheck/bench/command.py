"""The command `bench`. What it needs is imported when it runs: --help stays quick."""

from __future__ import annotations

import sys
from pathlib import Path

import click

CASES = ("scaled", "cooling", "position", "accuracy", "skipping", "cost", "particles")


@click.command(short_help="Measure run time against error, and what skipping saves.")
@click.option("--quick", is_flag=True, help="Fewer cases, about a minute; else about ten.")
@click.option(
    "--case", "cases", multiple=True, type=click.Choice(CASES),
    help="Measure this alone; may be repeated. [default: all]",
)  # fmt: skip
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=None,
    help="Folder for bench.json, bench.md and work-precision.svg. [default: none is written]",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")
def bench(quick: bool, cases: tuple[str, ...], output: Path | None, as_json: bool) -> None:
    """Measure every method on the same problems, against references of 1e-13 or better.

    Prints Markdown tables: run time for an error, error asked against error reached, what skipping
    saves, run time against the amount of work, collisions per second, and what failed.
    """
    from kinetics.crosscheck.files import require_writable_folder, write_together

    if output is not None:
        require_writable_folder(output)

    from tqdm import tqdm

    from kinetics.crosscheck.bench.run import run_bench

    with tqdm(total=len(cases or CASES), file=sys.stderr, disable=None, leave=False) as bar:

        def tell(name: str) -> None:
            bar.set_description(name, refresh=False)
            bar.update(1)

        report = run_bench(quick, cases or None, tell)
    click.echo(report.to_json() if as_json else report.markdown(), nl=False)
    if output is not None:
        for path in write_together(output, report.files()):
            if not as_json:
                click.echo(f"wrote {path}")


if __name__ == "__main__":
    bench()

"""The command `bench`. What it needs is imported when it runs: --help stays quick."""

from __future__ import annotations

import sys
from pathlib import Path

import click

CASES = (
    "scaled", "cooling", "position", "accuracy", "skipping", "cost", "floors", "particles",
    "cores", "first-use",
)  # fmt: skip


@click.command(short_help="Measure run time against error, and what skipping saves.")
@click.option("--quick", is_flag=True, help="Fewer cases, within a minute; else within ten.")
@click.option(
    "--case", "cases", multiple=True, type=click.Choice(CASES),
    help="Measure this alone; may be repeated. [default: all]",
)  # fmt: skip
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=None,
    help="Folder for bench.json, bench.md and the figures. [default: none is written]",
)  # fmt: skip
@click.option(
    "--compare", type=click.Path(exists=True, dir_okay=False, path_type=Path), default=None,
    metavar="OLD.json",
    help="Print ratios to this earlier run, and mark what got slower by more than the spread.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")
def bench(
    quick: bool,
    cases: tuple[str, ...],
    output: Path | None,
    compare: Path | None,
    as_json: bool,
) -> None:
    """Measure every method on the same problems, against references of 1e-13 or better.

    Prints Markdown tables: run time for an error, error asked against error reached, what skipping
    saves, cost against work, the slowest pieces of work and their floors, collisions per second,
    one core and two, and what failed.
    """
    from kinetics.crosscheck.bench.comparison import check_comparable, compare_bench
    from kinetics.crosscheck.bench.report import BenchReport
    from kinetics.crosscheck.files import require_writable_folder, write_together

    old = None
    if compare is not None:
        old = BenchReport.from_json(compare.read_text(encoding="utf-8", errors="replace"))
        check_comparable(quick, old)
    if output is not None:
        require_writable_folder(output)

    from tqdm import tqdm

    from kinetics.crosscheck.bench.run import count_stages, run_bench

    total = count_stages(cases or None)
    with tqdm(total=total, file=sys.stderr, disable=None, leave=False) as bar:

        def tell(name: str) -> None:
            bar.set_description(name, refresh=False)
            bar.update(1)

        report = run_bench(quick, cases or None, tell)
    text = report.markdown()
    if old is not None:
        text += "\n" + compare_bench(report, old).markdown()
    if as_json:
        click.echo(report.to_json(), nl=False)
    else:
        click.echo(text, nl=False)
    if output is not None:
        files = {"bench.json": report.to_json(), "bench.md": text, **report.figures()}
        for path in write_together(output, files):
            if not as_json:
                click.echo(f"wrote {path}")


if __name__ == "__main__":
    bench()

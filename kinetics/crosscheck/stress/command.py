"""The command `stress`. What it needs is imported when it runs: --help stays quick."""

from __future__ import annotations

import sys
from pathlib import Path

import click


@click.command(short_help="Drive solvers and particles to their limits; a verdict for each case.")
@click.option("--quick", is_flag=True, help="Fewer cases, within a minute.")
@click.option(
    "--group", "groups", multiple=True, help="Run this group alone; may be repeated. [default: all]"
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=None,
    help="Folder for stress.json and stress.md. [default: none is written]",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")
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
    and the worst case of each group. Ends with status 1 if a case ended as it must not.
    """
    from kinetics.crosscheck.files import require_writable_folder, write_together

    if output is not None:
        require_writable_folder(output)

    from tqdm import tqdm

    from kinetics.crosscheck.stress.run import run_stress

    with tqdm(file=sys.stderr, disable=None, leave=False) as bar:

        def tell(group: str, total: int) -> None:
            bar.total = total
            bar.set_description(group, refresh=False)
            bar.update(1)

        report = run_stress(quick, groups or None, tell)
    click.echo(report.to_json() if as_json else report.markdown(), nl=False)
    if output is not None:
        files = {
            "stress.json": report.to_json(),
            "stress.md": report.markdown(every_case=True),
        }
        for path in write_together(output, files):
            if not as_json:
                click.echo(f"wrote {path}")
    if report.rejected:
        context.exit(1)


if __name__ == "__main__":
    stress()

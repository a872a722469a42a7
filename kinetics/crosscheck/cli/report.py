"""The command `report`. What it needs is imported when it runs: --help stays quick."""

import os
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click import option

from kinetics.crosscheck.cli import options
from kinetics.errors import printable

if TYPE_CHECKING:
    from kinetics.crosscheck.report.systems import Driven

# The matrices are small: BLAS threads wait more than they work. NumPy reads this when it is first
# imported, which the option --output does.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

#: Options of the report on the system that the paper's figures have too.
OPTIONS_OF_PAPER_FIGURES = ("rtol", "seed", "workers", "media", "tracers", "free_tracers", "count")
#: Options of the report on the system that the driven ones have too.
OPTIONS_OF_DRIVEN = ("restitutions", "dimension", "rtol", "seed", "workers")


@click.command(
    epilog=options.example("lorentz report --quick -e 0.7 --until 300 -o report-of-0.7"),
    short_help="Compare the three methods on one system: HTML, JSON, verdicts.",
)
@option(
    "-o",
    "--output",
    type=options.Output(),
    default=Path("lorentz-report"),
    help="Folder for report.html, report.json and its tables as CSV.",
)
@option("--quick", is_flag=True, help="A tenth of the samples, and fewer digits of G(R).")
@option(
    "--system",
    "kind",
    default="disks",
    type=options.Word(("disks", "field", "bath", "heated", "viscoelastic")),
    help="Other tracers of the dilute limit instead: in a uniform field, among scatterers that "
    "move (w = 1), heated (noise of strength 1), or with the restitution of viscoelastic "
    "impacts. Takes only -e (b of the viscoelastic), --dimension, --rtol, --quick, --figures, "
    "--seed and --workers. The page is then named after the system, such as field.html.",
)
@option("--field", "kind", flag_value="field", help="The same as --system field.")
@option(
    "--figures-of-the-paper",
    is_flag=True,
    help="Instead of the report, make the paper's nine figures again, each with a verdict, in "
    "figures-of-the-paper.html. Has the samples of --quick.",
)
@option(
    "-e",
    "--restitution",
    "restitutions",
    type=float,
    multiple=True,
    help="Restitution, 0 to 1; may be repeated. [default: the paper's 0.4 0.6 0.7 0.9]",
)
@option(
    "-t",
    "--until",
    "final_times",
    type=float,
    multiple=True,
    help="Last time in d/U: once for all, or once per restitution. "
    "[default: the paper's 3000 300 500 1000; 1000 for other restitutions]",
)
@options.tangential_option
@options.dimension_option
@options.density_option
@option("--count", type=int, default=40_000, help="Hard disks, or spheres, in the box.")
@option("--media", type=int, default=100, help="Configurations of scatterers.")
@option("--tracers", type=int, default=100, help="Tracers in each configuration.")
@option("--free-tracers", type=int, default=1_000_000, help="Tracers of each Boltzmann-Grad run.")
@option("--rtol", type=float, default=1e-10, help="Relative tolerance asked of the solver.")
@option(
    "--figures",
    multiple=True,
    type=options.Word(("pdf", "png", "svg")),
    help="Write each figure as a file beside the page; may be repeated.",
)
@options.seed_option
@options.workers_option
@options.json_option
def report(
    output: Path,
    quick: bool,
    kind: str,
    figures_of_the_paper: bool,
    figures: tuple[str, ...],
    as_json: bool,
    **arguments: Any,
) -> None:
    """Compare the kinetic equation, the particles and the algebra on the paper's system.

    The paper's formulas hold for smooth disks: they are omitted for spheres, and with a tangential
    restitution.

    Writes report.html, which needs nothing beside it, report.json with every number in it, and its
    tables as CSV, and prints the findings.
    """
    from kinetics.crosscheck.report import make_report
    from kinetics.crosscheck.report.systems import Cooling

    if figures_of_the_paper:
        write_figures_of_the_paper(output, figures, arguments)
        return
    system: Cooling | Driven
    if kind == "disks":
        system = Cooling(**arguments)
    else:
        system = driven_system(kind, arguments)
    if quick:
        system = system.quick()
    with options.progress(system.stages) as tell:
        result = make_report(system, tell, shlex.join(["lorentz", *sys.argv[1:]]))
        tell("writing")
        written = result.write(output, figures)
    if as_json:
        options.print_json(result.document)
        return
    click.echo(result.text())
    click.echo(f"wrote {printable(written[0])} and {len(written) - 1} files beside it")


def write_figures_of_the_paper(
    output: Path, formats: tuple[str, ...], arguments: dict[str, Any]
) -> None:
    """Make the paper's figures again, write their page, and print the verdicts."""
    from kinetics.crosscheck.report.paper_figures import draw_paper_figures
    from kinetics.crosscheck.report.systems import Cooling

    options.refuse_given(
        [*(set(arguments) - set(OPTIONS_OF_PAPER_FIGURES)), "kind", "as_json"],
        "--figures-of-the-paper",
    )
    chosen = {name: arguments[name] for name in OPTIONS_OF_PAPER_FIGURES}
    system = Cooling(**chosen).quick()
    with options.progress(system.stages) as tell:
        made = draw_paper_figures(system, tell)
        tell("writing")
        written = made.write(output, formats)
    click.echo(made.text)
    click.echo(f"wrote {written[0]}")


def driven_system(kind: str, arguments: dict[str, Any]) -> "Driven":
    """Return the driven system of this name; other options than `OPTIONS_OF_DRIVEN` are refused."""
    from kinetics.crosscheck.report.systems import VISCOELASTIC, Driven

    options.refuse_given(set(arguments) - set(OPTIONS_OF_DRIVEN), f"--system {kind}")
    chosen = {name: arguments[name] for name in OPTIONS_OF_DRIVEN if options.is_given(name)}
    if kind == VISCOELASTIC and "restitutions" in chosen:
        chosen["viscoelastic"] = chosen.pop("restitutions")
    return Driven(name=kind, **chosen)

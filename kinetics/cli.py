"""The command `lorentz`. What a subcommand needs is imported when it runs: --help stays quick."""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from kinetics.crosscheck.bench.command import bench
from kinetics.crosscheck.comparison.command import compare
from kinetics.crosscheck.stress.command import stress

UNITS = (
    "Lengths are in d (diameter of a scatterer and of the tracer), speeds in U (standard deviation "
    "of one component of the initial velocity), times in d/U, densities in d^-2."
)
CONTEXT = {"help_option_names": ["-h", "--help"], "show_default": True, "max_content_width": 100}
BAD_INPUT, INTERRUPTED, TERMINATED = 2, 130, 143


class Numbers(click.ParamType):
    """Numbers separated by commas, "1,10,100": a tuple of floats, perhaps empty."""

    name = "numbers"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        """The numbers, or click's complaint that names the option and the text."""
        if isinstance(value, tuple):
            return value
        try:
            return tuple(float(part) for part in value.split(",") if part.strip())
        except ValueError:
            self.fail(f"{value!r}: it must be numbers separated by commas", param, ctx)


restitution_option = click.option(
    "-e", "--restitution", type=float, default=0.7, help="Coefficient of restitution, 0 to 1."
)
density_option = click.option(
    "--number-density", type=float, default=0.04, help="Scatterers per d^2."
)
times_option = click.option(
    "--times",
    type=Numbers(),
    default="1,3,10,30,100,300,1000",
    help="Output times in d/U, increasing, separated by commas.",
)
initial_option = click.option(
    "--initial",
    type=click.Choice(["gaussian", "monoenergetic"]),
    default="gaussian",
    help="Initial velocities: Gaussian, or all of speed U.",
)
seed_option = click.option("--seed", type=int, default=1, help="Seed of every random number.")
workers_option = click.option(
    "--workers", type=int, default=None, help="Threads. [default: one per processor]"
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON document and nothing else."
)


@click.group(
    context_settings=CONTEXT,
    invoke_without_command=True,
    epilog=UNITS,
)
@click.version_option(package_name="inelastic-lorentz", prog_name="lorentz")
@click.pass_context
def cli(context: click.Context) -> None:
    """The inelastic Lorentz gas: a kinetic solver, an event-driven simulator, sympy derivations,
    and a report that compares the three.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@cli.command(epilog=UNITS, short_help="Compare the three on one system: HTML, JSON, verdicts.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("lorentz-report"),
    help="Folder for report.html and report.json.",
)
@click.option("--quick", is_flag=True, help="A tenth of the samples.")
@click.option(
    "-e",
    "--restitution",
    "restitutions",
    type=float,
    multiple=True,
    help="Restitution, 0 to 1; may be repeated. [default: the paper's 0.4 0.6 0.7 0.9]",
)
@click.option(
    "-t",
    "--until",
    "final_times",
    type=float,
    multiple=True,
    help="Last time in d/U: once for all, or once per restitution. "
    "[default: the paper's 3000 300 500 1000; 1000 for other restitutions]",
)
@density_option
@click.option("--count", type=int, default=40_000, help="Hard disks in the periodic box.")
@click.option("--media", type=int, default=100, help="Configurations of hard disks.")
@click.option("--tracers", type=int, default=100, help="Tracers in each configuration.")
@click.option(
    "--free-tracers", type=int, default=200_000, help="Tracers of each Boltzmann-Grad run."
)
@click.option("--rtol", type=float, default=1e-10, help="Relative tolerance asked of the solver.")
@click.option(
    "--figures",
    multiple=True,
    type=click.Choice(("pdf", "png", "svg")),
    help="Write each figure as a file beside the page; may be repeated.",
)
@seed_option
@workers_option
@json_option
def report(
    output: Path,
    quick: bool,
    figures: tuple[str, ...],
    restitutions: tuple[float, ...],
    final_times: tuple[float, ...],
    as_json: bool,
    **system: Any,
) -> None:
    """Compare the kinetic equation, the particles and the algebra on the paper's system.

    Writes report.html, which needs nothing beside it, and report.json with every number in it, and
    prints a verdict per comparison.
    """
    # The matrices are small: BLAS threads wait more than they work. NumPy reads this when imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from kinetics.crosscheck.files import require_writable_folder
    from kinetics.crosscheck.report.settings import ReportSettings, final_time

    restitutions = restitutions or ReportSettings().restitutions
    if not final_times:
        final_times = tuple(final_time(e) for e in restitutions)
    elif len(final_times) == 1:
        final_times *= len(restitutions)
    settings = ReportSettings(restitutions, final_times, **system)
    if quick:
        settings = settings.quick()
    require_writable_folder(output)

    from kinetics.crosscheck.plain import dumps
    from kinetics.crosscheck.report import report as crosscheck
    from kinetics.crosscheck.report.page import verdict_table

    with _Bar(crosscheck.stages(settings)) as tell:
        document = crosscheck.make_report(settings, tell)
        written = crosscheck.write_report(document, output, tell, figures)
    if as_json:
        click.echo(dumps(document), nl=False)
    else:
        click.echo(verdict_table(document))
        click.echo(f"wrote {' and '.join(str(path) for path in written)}")


@cli.command(epilog=UNITS, short_help="Solve the kinetic equation.")
@restitution_option
@density_option
@initial_option
@times_option
@click.option(
    "--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c)."
)
@click.option(
    "--outputs",
    default="thermal_speed,a2,msd",
    help="Averages, separated by commas; also temperature, collisions, kurtosis, "
    "velocity_autocorrelation, diffusion_coefficient.",
)
@click.option("--radii", type=Numbers(), default="", help="R at which to print G(R), commas.")
@click.option("--wave-numbers", type=Numbers(), default="", help="k in 1/d at which to print F.")
@click.option("--rtol", type=float, default=1e-10, help="Relative tolerance asked for.")
@json_option
def solve(
    restitution: float,
    number_density: float,
    initial: str,
    times: tuple[float, ...],
    scaled: bool,
    outputs: str,
    radii: tuple[float, ...],
    wave_numbers: tuple[float, ...],
    rtol: float,
    as_json: bool,
) -> None:
    """Solve the kinetic equation: averages over time, G(R) and F(k, t)."""
    from kinetics.crosscheck.solve_command import solve_document, solve_text

    if scaled:
        from kinetics import solve_scaled

        state = solve_scaled(restitution=restitution, rtol=rtol)
        figures: dict[str, Any] = {
            "restitution": restitution,
            "cooling_rate": state.cooling_rate,
            "a2": state.a2,
            "moments": {str(p): state.moment(p) for p in range(1, 7)},
            "error_estimate": state.error_estimate,
            "nodes": state.nodes,
            "status": state.status.name.lower(),
        }
        if as_json:
            _print_json(figures)
            return
        moments = figures.pop("moments")
        for name, value in figures.items():
            click.echo(f"{name:15} {value}")
        for p, value in moments.items():
            click.echo(f"<c^{p}>{'':11}{value}")
        return

    system = {
        "restitution": restitution,
        "number_density": number_density,
        "initial": initial,
        "times": times,
    }
    found = solve_document(system, outputs, radii, wave_numbers, rtol)
    if as_json:
        _print_json(found)
    else:
        click.echo(solve_text(found))


@cli.command(epilog=UNITS, short_help="Follow particles from collision to collision.")
@click.option(
    "--medium",
    type=click.Choice(["hard-disks", "poisson", "boltzmann-grad"]),
    default="hard-disks",
    help="Disks that do not overlap, disks that may, or none: random free paths.",
)
@restitution_option
@density_option
@click.option("--count", type=int, default=40_000, help="Scatterers in the periodic box.")
@click.option(
    "--box",
    type=click.Choice(["periodic", "none"]),
    default="periodic",
    help="A periodic box, or the unbounded plane, made where a tracer goes.",
)
@click.option(
    "--positions",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="CSV",
    help="Scatterers where this file says: columns x and y. Needs --box-side.",
)
@click.option("--box-side", type=float, help="Side of the periodic box of --positions.")
@click.option("--media", type=int, default=100, help="Configurations of scatterers.")
@click.option("--tracers", type=int, default=100, help="Tracers in each configuration.")
@click.option(
    "--max-collisions", type=int, default=None, help="Stop a tracer after so many collisions."
)
@initial_option
@times_option
@click.option(
    "--observables",
    default="",
    metavar="NAMES",
    help="What to save beside the averages, separated by commas: speed_histogram, "
    "velocity_component_histogram, displacement_histogram, free_path_histogram, positions, "
    "velocities, finals.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="HDF5",
    help="Save here, configuration by configuration.",
)
@click.option("--resume", is_flag=True, help="Go on from --output if it is there.")
@seed_option
@workers_option
@json_option
def simulate(**arguments: Any) -> None:
    """Follow particles from collision to collision; every estimate with its standard error.

    With --output, a run that was stopped in whatever way goes on with --resume to the same bits.
    """
    from kinetics.crosscheck.simulate_command import run_simulation

    run_simulation(**arguments)


@cli.command(short_help="Re-derive the paper's equations with sympy.")
@click.option("--only", metavar="LABEL", help="One equation, with the steps of its derivation.")
@click.option(
    "--latex", type=click.Path(path_type=Path), metavar="FILE", help="Write a LaTeX document."
)
@json_option
def derive(only: str | None, latex: Path | None, as_json: bool) -> None:
    """Re-derive the paper's equations with sympy and hold each against the printed formula."""
    from kinetics.crosscheck.files import require_writable_folder, write_together

    if latex is not None:
        require_writable_folder(latex.parent)

    from derivations import to_json, to_latex_document, to_text, verify

    checks = verify(None if only is None else [only])
    if latex is not None:
        write_together(latex.parent, {latex.name: to_latex_document(checks)})
    if as_json:
        _print_json(to_json(checks))
    elif only is not None:
        click.echo(to_text(checks[0]))
    else:
        for check in checks:
            click.echo(f"{check.label:18} {check.status:12} {check.title}")
        counts: dict[str, int] = {}
        for check in checks:
            counts[check.status] = counts.get(check.status, 0) + 1
        click.echo(", ".join(f"{n} {status}" for status, n in counts.items()))


def _print_json(document: Any) -> None:
    """One strict JSON document on standard output."""
    from kinetics.crosscheck.plain import dumps

    click.echo(dumps(document), nl=False)


class _Bar:
    """A progress bar on standard error if that is a terminal; gives a function that moves it on."""

    def __init__(self, total: int) -> None:
        from tqdm import tqdm

        self._bar = tqdm(total=total, file=sys.stderr, disable=None, leave=False)

    def __enter__(self) -> Callable[[str], None]:
        return self._tell

    def _tell(self, stage: str) -> None:
        self._bar.set_description(stage, refresh=False)
        self._bar.update(1)

    def __exit__(self, *exception: object) -> None:
        self._bar.close()


cli.add_command(bench)
cli.add_command(compare)
cli.add_command(stress)


def main(arguments: list[str] | None = None) -> int:
    """Run the command: 0, or 2 for bad input (one line on standard error), 130 after Ctrl-C."""
    signal.signal(signal.SIGTERM, _terminate)
    if hasattr(sys.stdout, "reconfigure"):  # a terminal that lacks a sign shows ? for it
        sys.stdout.reconfigure(errors="replace")
    try:
        cli.main(arguments, prog_name="lorentz", standalone_mode=False)
    except click.ClickException as error:
        return _complain(error.format_message())
    except ValueError as error:
        return _complain(str(error))
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read our output has gone; nothing is left to flush to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return 0


def _complain(message: str) -> int:
    click.echo(f"lorentz: {' '.join(message.split())}", err=True)
    return BAD_INPUT


def _terminate(number: int, frame: Any) -> None:
    """End as after Ctrl-C: unwinding removes what is half written and ends the child process."""
    sys.exit(TERMINATED)


if __name__ == "__main__":
    sys.exit(main())

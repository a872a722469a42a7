"""The command `simulate`: follows particles and prints estimates with their errors."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinetics.crosscheck.commands import options
from kinetics.crosscheck.commands.run_files import (
    check_files,
    saying_how_to_go_on,
    write_picture,
)

if TYPE_CHECKING:
    from particles import Ensemble, Medium

# name in the result -> head of its column
_ESTIMATES = {
    "thermal_speed": "v0 [U]",
    "a2": "a2",
    "msd": "<r^2> [d^2]",
    "kurtosis": "kurtosis",
    "collisions": "collisions",
}
_IN_FIELD = {
    "drift": "<v_x> [U]",
    "thermal_speed": "v0 [U]",
    "dispersion_parallel": "var x [d^2]",
    "dispersion_perpendicular": "var y [d^2]",
    "collisions": "collisions",
}
_ENDS = ("finished", "collision_cap", "trapped", "escaped")
_ARGUMENTS = ("initial", "media", "tracers", "max_collisions", "seed")
_OF_THE_MEDIUM = ("medium", "count", "box", "positions", "box_side", "dimension")


@click.command(epilog=options.UNITS, short_help="Follow particles from collision to collision.")
@click.option(
    "--medium",
    type=click.Choice(
        ["hard-disks", "poisson", "hard-spheres", "poisson-spheres", "boltzmann-grad"]
    ),
    default="hard-disks",
    help="Disks or spheres that do not overlap, that may, or none: random free paths.",
)  # fmt: skip
@options.restitution_option
@options.tangential_option
@options.density_option
@click.option("--count", type=int, default=40_000, help="Scatterers in the periodic box.")
@click.option(
    "--box", type=click.Choice(["periodic", "none"]), default="periodic",
    help="A periodic box, or the unbounded plane, made where a tracer goes (or space, of "
    "poisson-spheres).",
)  # fmt: skip
@click.option(
    "--positions", type=click.Path(exists=True, dir_okay=False, path_type=Path), metavar="CSV",
    help="Scatterers where this file says: columns x and y. Needs --box-side.",
)  # fmt: skip
@click.option("--box-side", type=float, help="Side of the periodic box of --positions.")
@click.option(
    "--dimension", type=int,
    help="Of --medium boltzmann-grad: 2 for disks, as it is if not given, 3 for spheres. Other "
    "media have their own. Densities of spheres are in d^-3.",
)  # fmt: skip
@click.option("--media", type=int, default=100, help="Configurations of scatterers.")
@click.option("--tracers", type=int, default=100, help="Tracers in each configuration.")
@click.option("--max-collisions", type=int, help="Stop a tracer after so many collisions.")
@click.option(
    "--initial", type=click.Choice(["gaussian", "monoenergetic", "rest"]), default="gaussian",
    help="Initial velocities: Gaussian, all of speed U, or none (in a field).",
)  # fmt: skip
@click.option(
    "--field", type=float, default=0.0,
    help="Uniform acceleration along +x in U^2/d; not among spheres.",
)  # fmt: skip
@click.option("--depth", type=float, help="In a field, record when x = DEPTH [d] is first reached.")
@options.times_option
@options.until_option
@click.option(
    "--observables", default="", metavar="NAMES",
    help="What to save beside the averages, separated by commas: speed_histogram, "
    "velocity_component_histogram, displacement_histogram, free_path_histogram, positions, "
    "velocities, finals.",
)  # fmt: skip
@click.option(
    "-o", "--output", type=options.output_path, metavar="HDF5",
    help="Save here, configuration by configuration; FILE.h5md: positions and velocities as H5MD, "
    "for other programs, written at the end.",
)  # fmt: skip
@click.option(
    "--picture", type=options.output_path, metavar="FILE",
    help="Draw the paths of the first 8 tracers among the scatterers, coloured by speed: .png, "
    ".svg or .pdf.",
)  # fmt: skip
@click.option("--resume", is_flag=True, help="Go on from --output if it is there.")
@options.seed_option
@options.workers_option
@options.json_option
def simulate(
    until: float | None,
    picture: Path | None,
    number_density: float,
    times: tuple[float, ...],
    observables: str,
    output: Path | None,
    as_json: bool,
    **arguments: Any,
) -> None:
    """Follow particles from collision to collision; every estimate with its standard error.

    With --output, a run that was stopped in whatever way goes on with --resume to the same bits.
    """
    from tqdm import tqdm

    import particles

    times = options.times_until(times, until)
    check_files()
    h5md = output if output is not None and output.suffix.lower() == ".h5md" else None
    names = options.names_in(observables)
    if h5md is not None:
        names = _for_h5md(h5md, names, arguments)
    described = {name: arguments.pop(name) for name in _OF_THE_MEDIUM}
    scatterers = make_medium(number_density, **described)

    def show(done: int, total: int) -> None:
        bar.update(done - bar.n)

    bar = tqdm(
        total=arguments["media"], desc="configurations", file=sys.stderr, disable=None, leave=False
    )
    with saying_how_to_go_on(), bar:
        run = particles.simulate(
            scatterers,
            times=times or None,
            observables=names or None,
            output=output if h5md is None else None,
            progress=show,
            **arguments,
        )
    if picture is not None:
        write_picture(run, picture)
    if h5md is not None:
        run.write_h5md(h5md)
    if as_json:
        kind = described["medium"] if described["positions"] is None else "positions"
        options.print_json(_document(run, kind, arguments))
    else:
        click.echo(_table(run))
        ends = _ends_of(run).items()
        click.echo("tracers: " + ", ".join(f"{n} {name}" for name, n in ends))


def _ends_of(run: Ensemble) -> dict[str, int]:
    return {name: getattr(run.statuses, name) for name in _ENDS}


def _document(run: Ensemble, kind: str, arguments: dict[str, Any]) -> dict[str, Any]:
    """What --json prints; kind: of the medium, arguments: those of `simulate`."""
    estimates = ["mean_free_path", *_ESTIMATES]
    if run.field:
        estimates += ["drift_of_moving", "trapped_fraction"]
        estimates += ["drift", "mean_velocity", "velocity_tensor", "mean_displacement"]
        estimates += ["dispersion", "dispersion_parallel", "dispersion_perpendicular"]
    if run.plan.depth is not None:
        estimates += ["passed", "mean_passage_time"]
    return {
        "medium": kind,
        "restitution": run.restitution,
        "tangential_restitution": run.tangential_restitution,
        "number_density": run.number_density,
        "field": run.field,
        "dimension": run.medium.dimension,
        **{name: arguments[name] for name in _ARGUMENTS},
        "statuses": _ends_of(run),
        **{name: getattr(run, name) for name in ("times", "samples", "missing", "trapped")},
        **{name: _value_and_error(getattr(run, name)) for name in estimates},
    }


def _for_h5md(output: Path, names: tuple[str, ...], arguments: dict[str, Any]) -> tuple[str, ...]:
    """The observables, with those of an H5MD file. ValueError where it cannot be written."""
    if arguments["resume"]:
        raise ValueError("--resume: an H5MD file is written at the end; give --output FILE.h5")
    if output.exists():
        raise ValueError(f"output: got {str(output)!r}; it exists, and nothing is overwritten")
    return tuple(dict.fromkeys((*names, "positions", "velocities")))


def make_medium(
    number_density: float,
    medium: str,
    count: int,
    box: str,
    positions: Path | None,
    box_side: float | None,
    dimension: int | None,
) -> Medium:
    """The medium that the options describe. Raises ValueError where they do not fit."""
    from particles import (
        BoltzmannGrad,
        HardDisks,
        HardSpheres,
        Poisson,
        PoissonSpheres,
        Positions,
    )

    if (positions is None) != (box_side is None):
        raise ValueError("--positions and --box-side: give both or neither")
    if medium == "boltzmann-grad" and positions is None:
        chosen = 2 if dimension is None else dimension
        return BoltzmannGrad(number_density, dimension=chosen)  # type: ignore[arg-type]
    spheres = medium.endswith("spheres") and positions is None
    if dimension not in (None, 3 if spheres else 2):
        others = "boltzmann-grad" if spheres else "boltzmann-grad, hard-spheres or poisson-spheres"
        raise ValueError(
            f"dimension = {dimension}: must be {3 if spheres else 2} unless the medium is {others}"
        )
    if medium == "hard-spheres" and spheres:
        if box == "none":
            raise ValueError("box = 'none': hard-spheres need a periodic box")
        return HardSpheres(number_density, count=count)
    if spheres:
        return PoissonSpheres(number_density, count=None if box == "none" else count)
    if positions is not None and box_side is not None:
        return Positions.from_csv(positions, box_side)
    disks = HardDisks if medium == "hard-disks" else Poisson
    return disks(number_density, count, box=None if box == "none" else "periodic")


def _table(run: Ensemble) -> str:
    """The estimates as a table, one row for each time, and the mean free path."""
    from kinetics.crosscheck.text_tables import columns

    path = run.mean_free_path
    line = f"mean free path: {path.value:.6g} +- {path.error:.2g} d"
    if not run.times.size:
        return line
    heads, values = ["t [d/U]"], [run.times]
    shown = dict(_IN_FIELD if run.field else _ESTIMATES)
    if run.plan.depth is not None:
        shown["passed"] = f"passed {run.plan.depth:g} d"
        first = run.mean_passage_time
        line += f"\nmean time of the first passage: {first.value:.6g} +- {first.error:.2g} d/U"
    for name, head in shown.items():
        heads += [head, "+-"]
        values += _value_and_error(getattr(run, name)).values()
    return f"{columns(heads, values)}\n{line}"


def _value_and_error(estimate: Any) -> dict[str, Any]:
    return {"value": estimate.value, "error": estimate.error}

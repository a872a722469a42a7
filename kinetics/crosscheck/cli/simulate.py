"""The command `simulate`, which prints estimates with their errors; `merge`, of parts of a run."""

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from glob import glob
from pathlib import Path
from typing import Any

import click
from click import Choice, option

from kinetics.crosscheck.cli import options
from kinetics.errors import InputError

# name in the result -> head of its column
ESTIMATES = {
    "thermal_speed": "v0 [U]", "a2": "a2", "msd": "<r^2> [d^2]", "kurtosis": "kurtosis",
    "collisions": "collisions",
}  # fmt: skip
IN_FIELD = {
    "drift": "<v_x> [U]", "thermal_speed": "v0 [U]", "dispersion_parallel": "var x [d^2]",
    "dispersion_perpendicular": "var y [d^2]", "collisions": "collisions",
}  # fmt: skip
# those that a document has beside ESTIMATES
OF_A_FIELD = (
    "drift_of_moving", "trapped_fraction", "drift", "mean_velocity", "velocity_tensor",
    "mean_displacement", "dispersion", "dispersion_parallel", "dispersion_perpendicular",
)  # fmt: skip
ENDS = ("finished", "collision_cap", "trapped", "escaped", "captured")
MEDIA = ("hard disks", "overlapping", "hard spheres", "overlapping spheres", "dilute")


# fmt: off
@click.command(
    epilog=options.example("lorentz simulate -e 0.7 --media 10 --times 1:1000:7 -o run.h5"),
    short_help="Follow particles from collision to collision.",
)
@option("--scatterers", default="hard disks", type=options.Scatterers(MEDIA),
        help="Disks or spheres that do not overlap, that may, or dilute: random free paths. A "
        "space may be a hyphen, hard-disks.")
@options.restitution_option
@options.tangential_option
@options.mass_option
@options.density_option
@option("--count", type=int, default=40_000, help="Scatterers in the periodic box.")
@option("--dimension", type=int,
        help="Of --scatterers dilute: 2 for disks, as it is if not given, 3 for spheres. Others "
        "have their own. Densities of spheres are in d^-3.")
@option("--media", type=int, default=100, help="Configurations of scatterers.")
@option("--tracers", type=int, default=100, help="Tracers in each configuration.")
@option("--max-collisions", type=int, help="Stop a tracer after so many collisions.")
@option("--initial", type=Choice(["gaussian", "monoenergetic", "rest"]), default="gaussian",
        help="Initial velocities: Gaussian, all of speed U, or none (in a field, bath or noise).")
@option("--field", type=float, default=0.0,
        help="Uniform acceleration along +x in U^2/d; not among spheres.")
@options.drive_options
@option("--depth", type=float, help="In a field, record when x = DEPTH [d] is first reached.")
@options.times_option
@options.until_option
@option("--observables", default="", metavar="NAMES",
        help="What to save beside the averages, separated by commas: speed_histogram, "
        "velocity_component_histogram, displacement_histogram, free_path_histogram, "
        "free_time_histogram, positions, velocities, finals.")
@option("-o", "--output", type=options.Output(".h5", ".hdf5", ".h5md"), metavar="HDF5",
        help="Save here, configuration by configuration; FILE.h5md: positions and velocities as "
        "H5MD, for other programs, written at the end.")
@option("--part", callback=options.part_of, metavar="K/N",
        help="Only the K-th of N parts of the configurations; `lorentz merge` joins the parts.")
@option("--resume", is_flag=True, help="Go on from --output if it is there.")
@options.seed_option
@options.workers_option
@options.json_option
def simulate(
    until: float | None, number_density: float, scatterers: str, count: int,
    dimension: int | None, times: tuple[float, ...], observables: str, output: Path | None,
    as_json: bool, viscoelastic: float | None,
    **arguments: Any,
) -> None:
    """Follow particles from collision to collision; every estimate with its standard error.

    With --output, a run that was stopped in whatever way goes on with --resume to the same bits.
    """
    # fmt: on
    import particles

    names = options.names_in(observables)
    law = options.impact_law(viscoelastic, "particles", arguments["restitution"])
    arguments |= {"restitution": law, "times": options.times_until(times, until) or None}
    h5md = output if output is not None and output.suffix.lower() == ".h5md" else None
    if h5md is not None:
        if arguments["resume"]:
            raise InputError("--resume: an H5MD file is written at the end; give --output FILE.h5")
        _require_new(h5md)
        output, names = None, tuple(dict.fromkeys((*names, "positions", "velocities")))
    medium = make_medium(scatterers, number_density, count, dimension)
    with _saying_how_to_go_on(output) as told, options.progress(arguments["media"]) as tell:

        def progress(done: int, total: int) -> None:
            told["total"] = total
            tell("configurations", total, done)

        run = particles.simulate(
            medium, observables=names or None, output=output, progress=progress, **arguments
        )
    if h5md is not None:
        run.write_h5md(h5md)
    _show(run, as_json)


@click.command(
    epilog=options.example("lorentz merge part1.h5 part2.h5 -o run.h5"),
    short_help="Join the parts of a run.",
)
@click.argument("parts", nargs=-1, required=True, metavar="HDF5...")
@option("-o", "--output", type=options.Output(".h5", ".hdf5"), metavar="HDF5", required=True,
        help="Save the whole run here, to the bits that it has if run at once.")  # fmt: skip
@options.json_option
def merge(parts: tuple[str, ...], output: Path, as_json: bool) -> None:
    """Join the files of `lorentz simulate --part K/N -o FILE`: all N of one run, in any order."""
    import particles

    _require_new(output)
    # Shells of Windows leave *.h5 as it is.
    files = [f for part in parts for f in ([part] if Path(part).exists() else glob(part) or [part])]
    with options.progress(name="joining"):
        run = particles.Ensemble.merge(files)
        run.save(output)
    _show(run, as_json)


def _require_new(output: Path) -> None:
    if output.exists():
        raise InputError(f"output: got {str(output)!r}; it exists, and nothing is overwritten")


def _show(run: Any, as_json: bool) -> None:
    if as_json:
        options.print_json(_document(run))
    else:
        click.echo(_text(run))


def make_medium(word: str, number_density: float, count: int, dimension: int | None) -> Any:
    """The medium that the options describe. Raises InputError where they do not fit."""
    import particles

    if word == "dilute":
        chosen: Any = 2 if dimension is None else dimension
        return particles.BoltzmannGrad(number_density, dimension=chosen)
    own = 3 if word.endswith("spheres") else 2
    if dimension not in (None, own):
        others = "dilute" + ", hard or overlapping spheres" * (own == 2)
        raise InputError(f"dimension: got {dimension}; it must be {own} unless these are {others}")
    kinds: dict[str, Any] = {
        "hard disks": particles.HardDisks,
        "overlapping": particles.Poisson,
        "hard spheres": particles.HardSpheres,
        "overlapping spheres": particles.PoissonSpheres,
    }
    return kinds[word](number_density, count=count)


@contextmanager
def _saying_how_to_go_on(output: Path | None) -> Iterator[dict[str, int]]:
    """After Ctrl-C or SIGTERM, say what is saved, of `total`, and how the run goes on."""
    told: dict[str, int] = {}
    try:
        yield told
    except (KeyboardInterrupt, SystemExit):
        import h5py

        with suppress(OSError, KeyError), h5py.File(output or "no file", "r") as file:
            done = f"{file.attrs['done']} of {told['total']} configurations are saved in {output}"
            click.echo(f"lorentz: {done}; the same command with --resume goes on", err=True)
        raise


def _document(run: Any) -> dict[str, Any]:
    """What --json prints."""
    plan, scatterers, moves = run.plan, run.medium.scatterers, math.isfinite(run.mass_ratio)
    estimates = ["mean_free_path", *ESTIMATES, *(OF_A_FIELD if run.field else ())]
    estimates += ["passed", "mean_passage_time"] if plan.depth is not None else []
    estimates += ["trapped_fraction"] if plan.capture_speed and not run.field else []
    law = ["tangential_restitution", "number_density", "field", "times", "samples", "missing"]
    law += ["trapped", *(name for name in options.DRIVES if getattr(run, name))]
    law += ["mass_ratio"] if moves else []  # JSON has no infinity
    initial = "rest" if plan.rest else "monoenergetic" if plan.monoenergetic else "gaussian"
    return {
        "medium": scatterers, "scatterers": scatterers, **options.law_keys(run.restitution),
        "dimension": run.medium.dimension, **{name: getattr(run, name) for name in law},
        "initial": initial if plan.velocities is None else None,
        **{name: getattr(plan, name) for name in ("media", "tracers", "max_collisions", "seed")},
        **({"part": plan.part} if plan.part else {}),
        "statuses": {name: getattr(run.statuses, name) for name in ENDS},
        **{name: {"value": x.value, "error": x.error}
           for name in estimates for x in [getattr(run, name)]},
    }  # fmt: skip


def _text(run: Any) -> str:
    """The estimates as a table, one row for each time, the mean free path, how tracers ended."""
    from kinetics.crosscheck.words import number

    lines, shown, depth = [], dict(IN_FIELD if run.field else ESTIMATES), run.plan.depth
    single = {"mean free path: {} d": run.mean_free_path}
    if depth is not None and run.times.size:
        shown["passed"] = f"passed {depth:g} d"
        single["mean time of the first passage: {} d/U"] = run.mean_passage_time
    if run.times.size:
        found = {head: getattr(run, name) for name, head in shown.items()}
        table = {head: list(map(number, x.value, x.error)) for head, x in found.items()}
        lines.append(options.columns({"t [d/U]": run.times, **table}))
    lines += [text.format(number(float(x.value), float(x.error))) for text, x in single.items()]
    names = [name for name in ENDS if name != "captured" or run.capture_speed]
    ends = (f"{getattr(run.statuses, name)} {name}" for name in names)
    return "\n".join([*lines, f"tracers: {', '.join(ends)}"])

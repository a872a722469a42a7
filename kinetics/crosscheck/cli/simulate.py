"""The command `simulate`, which prints estimates with their errors; `merge`, of parts of a run."""

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click import option

from kinetics.crosscheck.cli import options
from kinetics.errors import InputError, printable

if TYPE_CHECKING:
    from particles import Ensemble, Medium

#: Averages that are printed: name in the result -> head of its column.
ESTIMATES = {
    "thermal_speed": "v0 [U]",
    "a2": "a2",
    "msd": "<r^2> [d^2]",
    "kurtosis": "kurtosis",
    "collisions": "collisions",
}
#: The same in a field.
IN_FIELD = {
    "drift": "<v_x> [U]",
    "thermal_speed": "v0 [U]",
    "dispersion_parallel": "var x [d^2]",
    "dispersion_perpendicular": "var y [d^2]",
    "collisions": "collisions",
}
#: Estimates that a document of a run in a field has beside ESTIMATES.
OF_A_FIELD = (
    "drift_of_moving",
    "trapped_fraction",
    "drift",
    "mean_velocity",
    "velocity_tensor",
    "mean_displacement",
    "dispersion",
    "dispersion_parallel",
    "dispersion_perpendicular",
)
#: Ways in which tracers end.
CAPTURED = "captured"
ENDS = ("finished", "collision_cap", "trapped", "escaped", CAPTURED)
DILUTE = "dilute"
#: Words of --scatterers beside "dilute": the dimension, and the class of `particles`.
PLACED_SCATTERERS = {
    "hard disks": (2, "HardDisks"),
    "overlapping disks": (2, "Poisson"),
    "hard spheres": (3, "HardSpheres"),
    "overlapping spheres": (3, "PoissonSpheres"),
}
H5MD = ".h5md"


# fmt: off
@click.command(
    epilog=options.example("lorentz simulate -e 0.7 --media 10 --times 1:1000:7 -o run.h5"),
    short_help="Follow particles from collision to collision.",
)
@option("--scatterers", default="hard disks", type=options.Scatterers([*PLACED_SCATTERERS, DILUTE]),
        help="hard: scatterers that do not overlap; overlapping: placed independently; dilute: no "
        "places, random free paths. A hyphen may stand for the space.")
@options.restitution_option
@options.tangential_option
@options.mass_option
@options.density_option
@option("--count", type=int, default=40_000, help="Scatterers in the periodic box.")
@option("--dimension", type=int,
        help="With --scatterers dilute, 2: disks in the plane (default); 3: spheres in space. "
        "Densities of spheres are in d^-3.")
@option("--media", type=int, default=100, help="Configurations of scatterers.")
@option("--tracers", type=int, default=100, help="Tracers in each configuration.")
@option("--max-collisions", type=int, help="Stop a tracer after so many collisions.")
@option("--initial", type=options.Word(["gaussian", "monoenergetic", "rest"]), default="gaussian",
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
        help="Save the run in this file during the run; FILE.h5md: positions and velocities in the "
        "format H5MD, for other programs, written at the end.")
@option("--part", callback=options.part_of, metavar="K/N",
        help="Only the K-th of N parts of the configurations; `lorentz merge` joins the parts.")
@option("--resume", is_flag=True, help="Continue the run in the file of --output, if it exists.")
@options.seed_option
@options.workers_option
@options.json_option
def simulate(
    times: tuple[float, ...],
    until: float | None,
    observables: str,
    output: Path | None,
    as_json: bool,
    viscoelastic: float | None,
    **arguments: Any,
) -> None:
    """Follow particles from collision to collision; every estimate with its standard error.

    A run with --output that was stopped, by whatever cause, continues with --resume, and gives the
    same result to the last bit.
    """
    # fmt: on
    import particles

    medium = make_medium(
        arguments.pop("scatterers"),
        arguments.pop("number_density"),
        arguments.pop("count"),
        arguments.pop("dimension"),
    )
    law = options.impact_law(viscoelastic, "particles", arguments["restitution"])
    arguments["restitution"] = law
    arguments["times"] = options.times_until(times, until) or None
    saved = options.names_in(observables)
    h5md = None
    if output is not None and output.suffix.lower() == H5MD:
        h5md = output
        output = None
        if arguments["resume"]:
            raise InputError("--resume: an H5MD file is written at the end; give --output FILE.h5")
        _require_new(h5md)
        saved = tuple(dict.fromkeys((*saved, "positions", "velocities")))
    with _saying_how_to_go_on(output) as saving, options.progress(arguments["media"]) as tell:

        def progress(done: int, total: int) -> None:
            saving.total = total
            tell("configurations", total, done)

        ensemble = particles.simulate(
            medium, observables=saved or None, output=output, progress=progress, **arguments
        )
    if h5md is not None:
        ensemble.write_h5md(h5md)
    _show(ensemble, as_json)


@click.command(
    epilog=options.example("lorentz merge part1.h5 part2.h5 -o run.h5"),
    short_help="Join the parts of a run.",
)
@click.argument("parts", nargs=-1, required=True, metavar="HDF5...")
@option("-o", "--output", type=options.Output(".h5", ".hdf5"), metavar="HDF5", required=True,
        help="Save the whole run here, the same to the last bit as a run in one part.")
@options.json_option
def merge(parts: tuple[str, ...], output: Path, as_json: bool) -> None:
    """Join the files of `lorentz simulate --part K/N -o FILE`: all N of one run, in any order."""
    import particles

    _require_new(output)
    files: list[str] = []
    for name in parts:
        if Path(name).exists():
            files.append(name)
        else:  # shells of Windows leave *.h5 as it is
            files += glob(name) or [name]
    with options.progress(name="joining"):
        ensemble = particles.Ensemble.merge(files)
        ensemble.save(output)
    _show(ensemble, as_json)


def _require_new(output: Path) -> None:
    """Raise InputError if a file is there."""
    if output.exists():
        raise InputError(f"output: got {str(output)!r}; it exists, and nothing is overwritten")


def _show(ensemble: "Ensemble", as_json: bool) -> None:
    """Print a run, as a document or as tables."""
    if as_json:
        options.print_json(_document(ensemble))
    else:
        click.echo(_text(ensemble))


def make_medium(
    word: str, number_density: float, count: int, dimension: int | None
) -> "Medium":
    """Return the medium that the options describe. Raises InputError where they do not fit."""
    import particles

    if word == DILUTE:
        requested: Any = 2 if dimension is None else dimension
        return particles.BoltzmannGrad(number_density, dimension=requested)
    own_dimension, kind = PLACED_SCATTERERS[word]
    if dimension not in (None, own_dimension):
        others = DILUTE
        if own_dimension == 2:
            others = "dilute, hard or overlapping spheres"
        allowed = f"it must be {own_dimension} unless these are {others}"
        raise InputError(f"dimension: got {dimension}; {allowed}")
    medium: Medium = getattr(particles, kind)(number_density, count=count)
    return medium


@dataclass
class Saving:
    """How many configurations a run has in all; 0 before the first is done."""

    total: int = 0


@contextmanager
def _saying_how_to_go_on(output: Path | None) -> Iterator[Saving]:
    """After Ctrl-C or SIGTERM, say what is saved, of the total, and how the run goes on."""
    saving = Saving()
    try:
        yield saving
    except (KeyboardInterrupt, SystemExit):
        if output is not None and saving.total:
            _say_what_is_saved(output, saving.total)
        raise


def _say_what_is_saved(output: Path, total: int) -> None:
    """Say how many configurations a file has, if it is there."""
    import h5py

    with suppress(OSError, KeyError), h5py.File(output, "r") as file:
        saved = f"{file.attrs['done']} of {total} configurations are saved in {printable(output)}"
        click.echo(f"lorentz: {saved}; the same command with --resume goes on", err=True)


def _document(ensemble: "Ensemble") -> dict[str, object]:
    """Return what --json prints."""
    plan = ensemble.plan
    document: dict[str, object] = {
        "medium": ensemble.medium.scatterers,
        "scatterers": ensemble.medium.scatterers,
        **options.law_keys(ensemble.restitution),
        "dimension": ensemble.medium.dimension,
    }
    attributes = ["tangential_restitution", "number_density", "field", "times", "samples"]
    attributes += ["missing", "trapped"]
    attributes += [name for name in options.DRIVES if getattr(ensemble, name)]
    if math.isfinite(ensemble.mass_ratio):  # JSON has no infinity
        attributes.append("mass_ratio")
    for name in attributes:
        document[name] = getattr(ensemble, name)
    document["initial"] = _initial_of(ensemble)
    for name in ("media", "tracers", "max_collisions", "seed"):
        document[name] = getattr(plan, name)
    if plan.part:
        document["part"] = plan.part
    document["statuses"] = {name: getattr(ensemble.statuses, name) for name in ENDS}
    for name in _estimates_of(ensemble):
        estimate = getattr(ensemble, name)
        document[name] = {"value": estimate.value, "error": estimate.error}
    return document


def _initial_of(ensemble: "Ensemble") -> str | None:
    """Return the word for the initial velocities; None where they were given one by one."""
    plan = ensemble.plan
    if plan.velocities is not None:
        return None
    if plan.rest:
        return "rest"
    if plan.monoenergetic:
        return "monoenergetic"
    return "gaussian"


def _estimates_of(ensemble: "Ensemble") -> list[str]:
    """Return the names of the estimates that a document of the run has."""
    names = ["mean_free_path", *ESTIMATES]
    if ensemble.field:
        names += OF_A_FIELD
    if ensemble.plan.depth is not None:
        names += ["passed", "mean_passage_time"]
    if ensemble.plan.capture_speed and not ensemble.field:
        names.append("trapped_fraction")
    return names


def _text(ensemble: "Ensemble") -> str:
    """Return the estimates by time, the mean free path, and how tracers ended."""
    from kinetics.crosscheck.words import number

    heads = dict(IN_FIELD if ensemble.field else ESTIMATES)
    depth = ensemble.plan.depth
    has_passages = depth is not None and bool(ensemble.times.size)
    if has_passages:
        heads["passed"] = f"passed {depth:g} d"
    lines = []
    if ensemble.times.size:
        table: dict[str, Any] = {"t [d/U]": ensemble.times}
        for name, head in heads.items():
            estimate = getattr(ensemble, name)
            table[head] = list(map(number, estimate.value, estimate.error))
        lines.append(options.columns(table))
    path = ensemble.mean_free_path
    lines.append(f"mean free path: {number(float(path.value), float(path.error))} d")
    if has_passages:
        passage = ensemble.mean_passage_time
        time = number(float(passage.value), float(passage.error))
        lines.append(f"mean time of the first passage: {time} d/U")
    ends = []
    for name in ENDS:
        if name != CAPTURED or ensemble.capture_speed:
            ends.append(f"{getattr(ensemble.statuses, name)} {name}")
    lines.append(f"tracers: {', '.join(ends)}")
    if ensemble.media == 1:
        lines.append("± ?: the error is unknown, as one configuration (--media) has no spread")
    return "\n".join(lines)

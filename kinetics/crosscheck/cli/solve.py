"""The command `solve`: prints what the kinetic equation gives for a scene, or for one state."""

import io
import math
import os
import textwrap
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import click
from click import Choice, option

from kinetics.crosscheck.cli import options
from kinetics.errors import InputError
from kinetics.outputs import DRIVEN_OUTPUTS, FIELD_OUTPUTS, OUTPUTS

LAW = ("restitution", "tangential_restitution", "dimension", "mass_ratio")
MEDIUM = ("scatterers", "density_order", "number_density")
# averages, and parts of vectors and tensors, that are printed -> their heads
HEADS = {row.name: row.head for row in OUTPUTS.values() if row.shape == ("n_times",)}
PARTS = {
    "mean_velocity_x": "<v_x> [U]", "mean_displacement_x": "<x> [d]",
    "velocity_tensor_xx": "<v_x^2> [U^2]", "velocity_tensor_yy": "<v_y^2> [U^2]",
    "displacement_tensor_xx": "var(x) [d^2]", "displacement_tensor_yy": "var(y) [d^2]",
}  # fmt: skip
# points -> the density that is asked for at them, and the heads of its columns
DENSITIES = {
    "speeds": ("speed_density", "f({} U)"),
    "scaled_radii": ("scaled_position_density", "G({})"),
    "wave_numbers": ("intermediate_scattering", "F({}/d)"),
}
_PRINTED = (*HEADS, *(name.rpartition("_")[0] for name in PARTS))
IN_FIELD = tuple(name for name in FIELD_OUTPUTS if name in _PRINTED)  # with --field
DRIVEN = tuple(name for name in DRIVEN_OUTPUTS if name in _PRINTED)
BY_COLLISION = ("thermal_speed", "a2", "msd")  # those that are printed by collision number as well
# options of states without time -> the function of kinetics, the options that it takes beside those
# of all, and the figures of its state
MODES: dict[str, tuple[str, tuple[str, ...], tuple[str, ...]]] = {
    "scaled": ("solve_scaled", (*LAW, *MEDIUM), ("cooling_rate", "a2", "nodes")),
    "field_steady": ("solve_field", (*LAW, "field_units"), (
        "drift", "mean_square_speed", "mean_square_along", "mean_speed", "diffusion_parallel",
        "diffusion_perpendicular",
    )),
    "steady": ("solve_steady", (
        "restitution", "viscoelastic", "dimension", "mass_ratio", *options.DRIVES, "field",
    ), (
        "thermal_speed", "a2", "drift", "mean_square_along", "collision_rate",
        "diffusion_coefficient", "diffusion_parallel", "diffusion_perpendicular", "mobility",
        "capture_time", "capture_depth",
    )),
}  # fmt: skip
OF_ALL = ("rtol", "output", "as_json")
EPILOG = f"""{options.UNITS} The example solves for the steady state of a tracer in a bath of
scatterers four times as heavy; without --steady it is solved over time."""
PICTURES = (".png", ".svg", ".pdf")
ENDINGS = (".csv", ".parquet", ".nc", ".h5", *PICTURES)

_points = partial(option, type=options.Numbers(), default="")


# fmt: off
@click.command(
    epilog=options.example("lorentz solve --steady -e 0.7 --bath-speed 1 --mass-ratio 4", EPILOG),
    short_help="Solve the kinetic equation.",
)
@options.restitution_option
@options.tangential_option
@options.mass_option
@options.dimension_option
@options.density_option
@option("--initial", default="gaussian", metavar="NAME|FILE.csv",
        help="Initial velocities: gaussian; monoenergetic (all speeds alike); beam (all along one "
        "direction); rest (only with --field); or a .csv file of two columns, the speed in U and "
        "its density in 1/U.")
@option("--speed", type=float, default=1.0, help="Speed of the start monoenergetic or beam, in U.")
@option("--direction", type=float, default=0.0,
        help="Angle of the start beam to the x axis, in radians.")
@option("--scatterers", type=options.Scatterers(["dilute", "hard disks", "overlapping"]),
        default="dilute",
        help="Medium. dilute is the paper's equation; the others include the finite density.")
@option("--density-order", type=Choice(["leading", "first", "second"]), default="second",
        help="Order of the theory for a finite density n: n ln n, n, or a fitted (n ln n)^2.")
@options.times_option
@options.until_option
@option("--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c).")
@option("--field", type=float, default=0.0,
        help="Uniform acceleration along x, in U^2/d; for averages, and for f(v) with --speeds.")
@option("--field-steady", is_flag=True,
        help="Solve the steady state in a uniform field g: drift and dispersion, in units of g and "
        "the mean free path l.")
@options.drive_options
@option("--steady", is_flag=True,
        help="Solve the steady state of a driven tracer. The unit of length is then the mean free "
        "path l, also in --heating, --drag and --field.")
@_points("--field-units", metavar="G,D,RHO",
         help="With --field-steady: print the results in your units too. Specify acceleration, "
         "diameter and density of scatterers, such as 9.81,0.001,1e8 in SI units.")
@option("--outputs", default="thermal_speed,a2,msd",
        help=f"Averages to print, separated by commas: {', '.join(HEADS)}. With --field: "
        f"{', '.join(IN_FIELD)}.")
@_points("--speeds", help="Speeds v in U at which to print f(v), separated by commas.")
@_points("--radii", help="Radii R at which to print G(R), separated by commas.")
@_points("--collision-numbers", help="Numbers N of collisions after which to print averages.")
@_points("--wave-numbers", help="Wave numbers k in 1/d at which to print F(k, t).")
@option("--rtol", type=float,
        help="Relative tolerance. [default: 1e-10; with --radii or a field 1e-6; for other driven "
        "tracers over time 1e-8]")
@option("-o", "--output", type=options.Output(*ENDINGS), metavar="FILE",
        help="Write the result to this file: .csv or .parquet (a row for each time), .nc (netCDF), "
        ".h5 (for kinetics.load), or a figure of all quantities: .png, .svg or .pdf.")
@options.json_option
def solve(
    field_units: tuple[float, ...], outputs: str, speeds: tuple[float, ...],
    radii: tuple[float, ...], wave_numbers: tuple[float, ...], rtol: float | None,
    output: Path | None, as_json: bool, until: float | None, viscoelastic: float | None,
    **system: Any,
) -> None:
    """Solve the kinetic equation: averages over time or by collision number, densities, F(k, t)."""
    # fmt: on
    given = [name for name in MODES if system.pop(name)]
    mode = given[0] if given else ""
    if mode:
        every = {str(one.name) for one in click.get_current_context().command.params}
        nothing = every - {mode, *MODES[mode][1], *OF_ALL}
        options.refuse_given(sorted(nothing), f"--{mode.replace('_', '-')}")
    system["restitution"] = options.impact_law(viscoelastic, "kinetics", system["restitution"])
    system["times"] = options.times_until(system["times"], until)
    if system["mass_ratio"] == math.inf:  # the default, which JSON cannot hold
        del system["mass_ratio"]
    if field_units and (mode != "field_steady" or len(field_units) != 3 or min(field_units) <= 0):
        raise click.UsageError("--field-units takes three numbers above 0, with --field-steady")
    points = {"speeds": speeds, "scaled_radii": radii, "wave_numbers": wave_numbers}
    points = {name: at for name, at in points.items() if at}
    with options.progress(name="solving"):
        if mode:
            result, found = without_time(mode, system, rtol or 1e-10)
        else:
            result, found = over_time(system, outputs, points, rtol)
    if field_units:
        found["in_units"] = asdict(result.in_units(*field_units))
    if output is not None:
        write_result(result, output, points)
    if as_json:
        options.print_json(found)
    else:
        click.echo(state_text(found) if mode else text_over_time(found))


def over_time(
    system: dict[str, Any], outputs: str, points: dict[str, Any], rtol: float | None
) -> tuple[Any, dict[str, Any]]:
    """The Solution and the JSON document; points : by the names in `DENSITIES`."""
    import warnings

    from kinetics import Scene, ToleranceWarning
    from kinetics import solve as solve_scene
    from kinetics.validation import not_negative, one_of, refuse

    drives = {name: system[name] for name in options.DRIVES if system[name]}
    driven = bool(drives) or not isinstance(system["restitution"], float)
    if rtol is None:  # G(R) cannot have 1e-10, and averages of driven tracers take long for it
        rough = "scaled_radii" in points or system["field"]
        rtol = 1e-6 if rough else 1e-8 if driven else 1e-10
    known = DRIVEN if driven else IN_FIELD if system["field"] else HEADS
    names = [one_of("outputs", name, known) for name in options.names_in(outputs)]
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(known)}")
    for name, at in points.items():  # refused before minutes of work
        not_negative(name.removeprefix("scaled_"), at)
    densities = {name: DENSITIES[name][0] for name in points}
    wanted = names + [name.removeprefix("scaled_") for name in densities.values()]
    initial = initial_state(*(system.pop(name) for name in ("initial", "speed", "direction")))
    scene = Scene(**system, initial=initial, outputs=tuple(wanted))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)  # the status says it
        solution = solve_scene(scene, rtol=rtol)
    found: dict[str, Any] = {name: system[name] for name in (*LAW, *MEDIUM) if name in system}
    found |= options.law_keys(system["restitution"]) | drives
    found["initial"] = initial if isinstance(initial, str) else repr(scene.state)
    found |= {"field": system["field"]} if system["field"] else {}
    found |= {"rtol": rtol, "status": solution.status.name.lower(), "message": solution.message}
    names += ["captured"] if "capture_speed" in drives else []
    names += ["uncollided"] if system["field"] and "speeds" in points else []
    found |= {name: getattr(solution, name) for name in ("times", *names)}
    for name, density in densities.items():
        found |= {name: points[name], density: getattr(solution, density)(points[name])}
    if numbers := system["collision_numbers"]:
        after = {name: getattr(solution.by_collision, name) for name in BY_COLLISION}
        found["by_collision"] = {"collision_numbers": [int(n) for n in numbers], **after}
    return solution, found


def text_over_time(found: dict[str, Any]) -> str:
    """The same as tables, one row per time, and the status."""
    shown = {head: found[name] for name, head in HEADS.items() if name in found}
    for name, head in PARTS.items():
        whole, _, axes = name.rpartition("_")
        if whole in found:
            shown[head] = found[whole][:, *map("xyz".index, axes)]
    shown |= {"captured": found["captured"]} if "captured" in found else {}
    tables = [shown]
    for points, (name, head) in DENSITIES.items():
        if name in found:
            columns = (head.format(options.written(float(x))) for x in found[points])
            tables.append(dict(zip(columns, found[name].T, strict=True)))
    lines = [options.columns({"t [d/U]": found["times"], **table}) for table in tables]
    if "by_collision" in found:
        numbers, *averages = found["by_collision"].values()
        named = zip(BY_COLLISION, averages, strict=True)
        lines.append(options.columns({"N": numbers, **{HEADS[n]: x for n, x in named}}))
    return "\n".join([*lines, *textwrap.wrap(f"status: {found['message']}", options.WIDTH)])


def without_time(mode: str, system: dict[str, Any], rtol: float) -> tuple[Any, dict[str, Any]]:
    """A state without time and its JSON document; what tracers that stick lack is left out."""
    import kinetics

    solver, takes, names = MODES[mode]
    nothing = {name for name in (*options.DRIVES, "field") if not system[name]}
    nothing |= {*MEDIUM} if system["scatterers"] == "dilute" else {""}
    asked = {name: system[name] for name in takes if name in system and name not in nothing}
    state = getattr(kinetics, solver)(**asked, rtol=rtol)
    found = asked | options.law_keys(asked["restitution"])
    values = {name: getattr(state, name) for name in (*names, "error_estimate")}
    found |= {n: x for n, x in values.items() if not isinstance(x, float) or math.isfinite(x)}
    found["status"] = state.status.name.lower()
    if mode == "scaled":
        return state, found | {"moments": {f"{p}": state.moment(p) for p in range(1, 7)}}
    found |= {"unit_of_length": "l"} if mode == "steady" else {}
    return state, found | {"message": state.message, "plan": [asdict(x) for x in state.plan]}


def state_text(found: dict[str, Any]) -> str:
    """The same, one line for each figure."""
    figures = {name: x for name, x in found.items() if not isinstance(x, dict | list)}
    figures |= {f"<c^{p}>": x for p, x in found.get("moments", {}).items()}
    lines = [f"{name:24} {options.written(x, 13)}" for name, x in figures.items()]
    if "plan" in found and "unit_of_length" not in found:
        lines.insert(0, "speeds in sqrt(g l), diffusion coefficients in sqrt(g l^3)")
    if "in_units" in found:
        lines.append("in the units of acceleration, diameter and number density:")
        lines += [f"{n:24} {options.written(x, 13)}" for n, x in found["in_units"].items()]
    return "\n".join(lines)


def initial_state(text: str, speed: float, direction: float) -> Any:
    """What a Scene takes as `initial`: a word, a beam, or a .csv file of speeds."""
    from kinetics import Beam, Monoenergetic, SpeedTable

    means = {"beam": (), "monoenergetic": ("direction",)}
    options.refuse_given(means.get(text, ("speed", "direction")), f"--initial {text}")
    if text == "beam":
        return Beam(direction, Monoenergetic(speed))
    if text == "monoenergetic" and speed != 1.0:
        return Monoenergetic(speed)
    return SpeedTable(*_two_columns(text)) if text.endswith(".csv") else text


def _two_columns(path: str, largest: int = 10_000_000) -> Any:
    """Two columns of numbers, below one line of names if there is one: (2, n)."""
    allowed = "it must be a CSV file of two columns, a speed and its density, of two rows at least"
    allowed += f" and {largest:g} bytes at most"
    import numpy as np

    with suppress(OSError, ValueError, IndexError):  # a line of other columns, or no text
        if not os.path.isfile(path) or os.path.getsize(path) > largest:
            raise ValueError
        rows = np.atleast_2d(np.genfromtxt(path, delimiter=",", encoding="utf-8"))
        table = rows[int(np.isnan(rows[0]).any()) :]
        if table.shape[1] == 2 and len(table) > 1 and np.all(np.isfinite(table)):
            return table.T
    raise InputError(f"initial: got {path!r}; {allowed}")


def write_result(result: Any, path: Path, points: dict[str, Any]) -> None:
    """Write a result, whole or not at all; points : where its densities are asked for."""
    from kinetics.crosscheck.files import write_together

    ending = path.suffix.lower()
    if ending == ".h5":
        result.save(path)
    elif ending == ".nc":
        contents = bytes(result.to_xarray(**points).to_netcdf(engine="scipy"))
        write_together(path.parent, {path.name: contents})
    elif ending in PICTURES:
        from matplotlib import pyplot

        result.plot_all()  # at points of its own, which are many
        pyplot.savefig(picture := io.BytesIO(), format=ending[1:], dpi=160)
        pyplot.close()
        write_together(path.parent, {path.name: picture.getvalue()})
    else:
        frame = rows_of(result, points)
        write = frame.to_csv if ending == ".csv" else frame.to_parquet
        write_together(path.parent, {path.name: write(index=False)})


def rows_of(result: Any, points: dict[str, Any]) -> Any:
    """The data frame of a result, its heads with units, a column for each point of a density."""
    frame = result.to_dataframe(**points)
    units = dict(frame.attrs["units"])
    for at in points:
        long = result.to_dataframe(DENSITIES[at][0], **points)
        _, along, *names = long.columns  # two for what is complex
        for name, (x, part) in product(names, long.groupby(along, sort=False)):
            head = f"{name}({along}={x:g})"
            frame[head], units[head] = part[name].values, long.attrs["units"][name]
    frame.attrs = {}  # which a Parquet file cannot hold
    return frame.rename(columns={n: n if u == "1" else f"{n} [{u}]" for n, u in units.items()})

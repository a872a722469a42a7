"""The command `solve`: prints what the kinetic equation gives for a scene."""

from __future__ import annotations

import textwrap
from functools import partial
from pathlib import Path
from typing import Any

import click

from kinetics.crosscheck.commands import options
from kinetics.crosscheck.commands.result_files import check_output, write_result
from kinetics.crosscheck.commands.start import initial_state
from kinetics.crosscheck.commands.states import scaled_state, state_text, steady_state
from kinetics.outputs import FIELD_OUTPUTS, OUTPUTS

LAW = ("restitution", "tangential_restitution", "dimension")
MEDIUM = ("scatterers", "density_order", "number_density")
HEADS = {row.name: row.head for row in OUTPUTS.values() if row.is_number}
"""Outputs that are one number for each time -> heads of their columns."""
TENSORS = {
    "mean_velocity": (("<v_x> [U]", (0,)),),
    "mean_displacement": (("<x> [d]", (0,)),),
    "velocity_tensor": (("<v_x^2> [U^2]", (0, 0)), ("<v_y^2> [U^2]", (1, 1))),
    "displacement_tensor": (("var(x) [d^2]", (0, 0)), ("var(y) [d^2]", (1, 1))),
}
"""Outputs that are vectors or tensors, with --field -> heads of the parts that are printed."""
_DENSITY_AT = {
    "speeds": "speed_density",
    "scaled_radii": "scaled_position_density",
    "wave_numbers": "intermediate_scattering",
}
"""Points -> the density that is asked for at them."""
_OVER_TIME = (
    "times", "until", "initial", "speed", "direction", "field", "outputs", "speeds", "radii",
    "collision_numbers", "wave_numbers",
)  # fmt: skip
"""Options that mean nothing where no scene is solved over time."""
BY_COLLISION = ("thermal_speed", "a2", "msd")
"""Those that are printed by collision number as well."""

_points = partial(click.option, type=options.Numbers(), default="")


@click.command(epilog=options.UNITS, short_help="Solve the kinetic equation.")
@options.restitution_option
@options.tangential_option
@click.option(
    "--dimension",
    type=int,
    default=2,
    help="3: spheres; number densities are then in d^-3.",
)
@options.density_option
@click.option(
    "--initial",
    default="gaussian",
    metavar="NAME|FILE.csv",
    help="Initial velocities: gaussian, monoenergetic, beam (all along one direction), with "
    "--field also rest; or a .csv file of two columns, the speed in U and its density in 1/U.",
)
@click.option("--speed", type=float, default=1.0, help="Of monoenergetic or beam, in U.")
@click.option(
    "--direction", type=float, default=0.0, help="Of beam: its angle to the x axis, in radians."
)
@click.option(
    "--scatterers",
    type=click.Choice(["dilute", "overlapping", "hard disks"]),
    default="dilute",
    help="Dilute: the paper's equation; else with the correction for this density.",
)
@click.option(
    "--density-order",
    type=click.Choice(["leading", "first", "second"]),
    default="second",
    help="How far that correction goes: n ln n, n, or a fitted (n ln n)^2.",
)
@options.times_option
@options.until_option
@click.option(
    "--scaled", is_flag=True, help="Solve the scaled equation: h, a2 and moments of F(c)."
)
@click.option(
    "--field",
    type=float,
    default=0.0,
    help="A uniform acceleration along x, in U^2/d: averages over time with it.",
)
@click.option(
    "--field-steady",
    is_flag=True,
    help="Solve the steady state in a uniform field: drift and dispersion, in units of g and l.",
)
@_points(
    "--field-units",
    metavar="G,D,RHO",
    help="With --field-steady, also in your units: the acceleration, the diameter and the density "
    "of the scatterers, separated by commas, such as 9.81,0.001,1e8 in SI units.",
)
@click.option(
    "--outputs",
    default="thermal_speed,a2,msd",
    help=f"Averages, separated by commas, of {', '.join(HEADS)}; with --field of "
    f"{', '.join(FIELD_OUTPUTS)}.",
)
@_points("--speeds", help="v in U at which to print f(v).")
@_points("--radii", help="R at which to print G(R), commas.")
@_points("--collision-numbers", help="N at which to print averages, commas.")
@_points("--wave-numbers", help="k in 1/d at which to print F.")
@click.option(
    "--rtol", type=float, help="Relative tolerance asked for; by default 1e-10, with --radii 1e-6."
)
@click.option(
    "-o",
    "--output",
    type=options.output_path,
    metavar="FILE",
    help="Write the result here: .csv (a row for each time), .nc (netCDF) or .h5 (for "
    "kinetics.load).",
)
@options.json_option
def solve(
    scaled: bool,
    field_steady: bool,
    field_units: tuple[float, ...],
    outputs: str,
    speeds: tuple[float, ...],
    radii: tuple[float, ...],
    wave_numbers: tuple[float, ...],
    rtol: float | None,
    output: Path | None,
    as_json: bool,
    until: float | None,
    **system: Any,
) -> None:
    """Solve the kinetic equation: averages over time or by collision number, densities, F(k, t)."""
    mode = "--scaled" if scaled else "--field-steady" if field_steady else ""
    if mode:
        also = ("field_steady",) if scaled else MEDIUM
        options.refuse_given((*_OVER_TIME, *also), mode)
    if output is not None:
        check_output(output)
    system["times"] = options.times_until(system["times"], until)
    asked: dict[str, Any] = {}
    if rtol is None:  # G(R) cannot have 1e-10, and averages in a field take long for it
        rtol = 1e-6 if (radii or system["field"]) and not mode else 1e-10
    law = {name: system[name] for name in LAW}
    if field_units and (not field_steady or len(field_units) != 3 or not min(field_units) > 0):
        raise click.UsageError("--field-units takes three numbers above 0, with --field-steady")
    if field_steady:
        result, found, text = *steady_state(law, field_units, rtol), state_text
    elif scaled:
        if system["scatterers"] != "dilute":
            law |= {name: system[name] for name in MEDIUM}
        result, found, text = *scaled_state(law, rtol), state_text
    else:
        points = {"speeds": speeds, "scaled_radii": radii, "wave_numbers": wave_numbers}
        asked = {name: at for name, at in points.items() if at}
        result, found = solve_document(system, outputs, asked, rtol)
        text = solve_text
    if output is not None:
        write_result(result, output, asked, [_DENSITY_AT[name] for name in asked])
    if as_json:
        options.print_json(found)
    else:
        click.echo(text(found))


def solve_document(
    system: dict[str, Any], outputs: str, asked: dict[str, Any], rtol: float
) -> tuple[Any, dict[str, Any]]:
    """The Solution and the JSON document: arguments of the scene, arrays, and densities.

    asked : where densities are asked for, by the names in :data:`_DENSITY_AT`
    """
    from kinetics import Scene
    from kinetics import solve as solve_scene
    from kinetics.validation import not_negative, one_of, refuse

    known = FIELD_OUTPUTS if system.get("field") else HEADS
    names = [one_of("outputs", name, known) for name in options.names_in(outputs)]
    if not names:
        refuse("outputs", outputs, f"name at least one of {', '.join(known)}")
    for name, at in asked.items():  # refused before minutes of work
        not_negative({"scaled_radii": "radii"}.get(name, name), at)
    needed = {"scaled_position_density": "position_density"}
    wanted = names + [needed.get(_DENSITY_AT[name], _DENSITY_AT[name]) for name in asked]
    initial = initial_state(*(system.pop(name) for name in ("initial", "speed", "direction")))
    scene = Scene(**system, initial=initial, outputs=tuple(wanted))
    solution = solve_scene(scene, rtol=rtol)
    found: dict[str, Any] = {
        **{name: system[name] for name in (*LAW, *MEDIUM)},
        "initial": initial if isinstance(initial, str) else repr(scene.state),
        **({"field": system["field"]} if system.get("field") else {}),
        "rtol": rtol,
        "status": solution.status.name.lower(),
        "message": solution.message,
        "times": solution.times,
        **{name: getattr(solution, name) for name in names},
    }
    for name, at in asked.items():
        found[name] = at
        found[_DENSITY_AT[name]] = getattr(solution, _DENSITY_AT[name])(at)
    collision_numbers = system.get("collision_numbers", ())
    if collision_numbers:
        after = solution.by_collision
        found["by_collision"] = {
            "collision_numbers": [int(n) for n in collision_numbers],
            **{name: getattr(after, name) for name in BY_COLLISION},
        }
    return solution, found


def solve_text(found: dict[str, Any]) -> str:
    """The same as tables, one row per time, and the status."""
    from kinetics.crosscheck.text_tables import WIDTH, columns, written

    names = [name for name in HEADS if name in found]
    heads = ["t [d/U]", *(HEADS[name] for name in names)]
    arrays = [found[name] for name in ("times", *names)]
    for name, parts in TENSORS.items():
        for head, place in parts if name in found else ():
            heads.append(head)
            arrays.append(found[name][(slice(None), *place)])
    tables = [columns(heads, arrays)]
    for at, head in (("speeds", "f({} U)"), ("scaled_radii", "G({})"), ("wave_numbers", "F({}/d)")):
        name = _DENSITY_AT[at]
        if name in found:
            heads = ["t [d/U]", *(head.format(written(x)) for x in found[at])]
            tables.append(columns(heads, [found["times"], *found[name].T]))
    if "by_collision" in found:
        heads = ["N", *(HEADS[name] for name in BY_COLLISION)]
        tables.append(columns(heads, list(found["by_collision"].values())))
    return "\n".join([*tables, *textwrap.wrap(f"status: {found['message']}", WIDTH)])

"""What `lorentz solve` prints: the numbers of a scene, or of the scaled equation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinetics.crosscheck.text import columns
from kinetics.errors import InputError, short

HEADS = {
    "thermal_speed": "v0 [U]",
    "temperature": "T [m U^2]",
    "a2": "a2",
    "collisions": "collisions",
    "msd": "<r^2> [d^2]",
    "kurtosis": "<r^4>/<r^2>^2",
    "velocity_autocorrelation": "<v(0).v> [U^2]",
    "diffusion_coefficient": "D [d U]",
}


def named(outputs: str) -> tuple[str, ...]:
    """Output names from text with commas; InputError for one that has no number per time."""
    names = tuple(part.strip() for part in outputs.split(",") if part.strip())
    for name in names:
        if name not in HEADS:
            raise InputError(f"outputs: got {name!r}; it must be among {', '.join(HEADS)}")
    if not names:
        raise InputError(f"outputs: got {short(outputs)}; name at least one of {', '.join(HEADS)}")
    return names


def solve_document(
    system: dict[str, Any],
    outputs: str,
    radii: tuple[float, ...],
    wave_numbers: tuple[float, ...],
    rtol: float,
) -> dict[str, Any]:
    """The JSON document: arguments of the scene, its arrays, G(R) and F(k) where asked for."""
    from kinetics import Scene, solve

    names = named(outputs)
    wanted = list(names)
    wanted += ["position_density"] if radii else []
    wanted += ["intermediate_scattering"] if wave_numbers else []
    for name, values in (("radii", radii), ("wave_numbers", wave_numbers)):
        if not all(0.0 <= x < math.inf for x in values):  # before minutes of work
            raise InputError(f"{name}: got {short(values)}; they must be finite, none negative")
    solution = solve(Scene(**system, outputs=tuple(wanted)), rtol=rtol)
    found: dict[str, Any] = {name: value for name, value in system.items() if name != "times"}
    found |= {"rtol": rtol, "status": solution.status.name.lower(), "times": solution.times}
    found |= {name: getattr(solution, name) for name in names}
    if radii:
        found["scaled_radii"] = np.array(radii)
        found["scaled_position_density"] = solution.scaled_position_density(radii)
    if wave_numbers:
        found["wave_numbers"] = np.array(wave_numbers)
        found["intermediate_scattering"] = solution.intermediate_scattering(wave_numbers)
    return found


def solve_text(found: dict[str, Any]) -> str:
    """The same as tables, one row per time."""
    from kinetics.scaling.scaled_vdf import SolverStatus

    names = [name for name in HEADS if name in found]
    heads, values = ["t [d/U]"], [found["times"]]
    heads += [HEADS[name] for name in names]
    values += [found[name] for name in names]
    parts = [columns(heads, values)]
    for head, at, name in (
        ("G({:g})", "scaled_radii", "scaled_position_density"),
        ("F({:g}/d)", "wave_numbers", "intermediate_scattering"),
    ):
        if name in found:
            heads = ["t [d/U]", *(head.format(x) for x in found[at])]
            parts.append(columns(heads, [found["times"], *found[name].T]))
    parts.append(f"status: {SolverStatus[found['status'].upper()].value}")
    return "\n".join(parts)

"""What `lorentz solve --field-steady` prints: the steady state in a uniform field."""

from __future__ import annotations

from typing import Any


def field_document(
    law: dict[str, Any], units: tuple[float, ...], rtol: float
) -> tuple[Any, dict[str, Any]]:
    """The result and its JSON document: figures in units of g and l, and in the user's own.

    units : acceleration, diameter and number density, in any consistent units; or nothing
    """
    from dataclasses import asdict

    from kinetics import solve_field

    state = solve_field(**law, rtol=rtol)
    found: dict[str, Any] = {
        **law,
        "drift": state.drift,
        "mean_square_speed": state.mean_square_speed,
        "mean_square_along": state.mean_square_along,
        "mean_speed": state.mean_speed,
        "diffusion_parallel": state.diffusion_parallel,
        "diffusion_perpendicular": state.diffusion_perpendicular,
        "error_estimate": state.error_estimate,
        "status": state.status.name.lower(),
        "message": state.message,
        "plan": [asdict(step) for step in state.plan],
    }
    if units:
        found["in_units"] = asdict(state.in_units(*units))
    return state, found


def field_text(found: dict[str, Any]) -> str:
    """The same, one line for each figure."""
    from kinetics.crosscheck.text_tables import figure, written

    lines = ["speeds in sqrt(g l), diffusion coefficients in sqrt(g l^3)"]
    lines += [
        f"{name:24} {figure(x)}" for name, x in found.items() if name not in ("plan", "in_units")
    ]
    if "in_units" in found:
        lines.append("in the units of acceleration, diameter and number density:")
        lines += [f"{name:24} {written(x, 10)}" for name, x in found["in_units"].items()]
    return "\n".join(lines)

"""The steady state in a field as a table: its figures, and the density of the velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.tables import Quantity, Table, attributes_of

_SPEEDS = np.linspace(0.0, 4.0, 161)[1:]
_ANGLES = np.array([0.0, 0.5, 1.0]) * np.pi
_FIGURES = {
    "drift": ("sqrt(g l)", "<v_x>, the percolation velocity"),
    "mean_square_speed": ("g l", "<v^2>"),
    "mean_square_along": ("g l", "<v_x^2>"),
    "mean_speed": ("sqrt(g l)", "<v>"),
    "diffusion_parallel": ("sqrt(g l^3)", "half the growth rate of the variance along the field"),
    "diffusion_perpendicular": ("sqrt(g l^3)", "the same in one direction across the field"),
}


def field_table(
    state: Any, only: str | None, speeds: ArrayLike | None, angles: ArrayLike | None
) -> Table:
    """The table of a FieldState. Points: speeds in sqrt(g l), angles to the field in radians."""
    v = _SPEEDS if speeds is None else np.atleast_1d(np.asarray(speeds, dtype=float))
    phi = _ANGLES if angles is None else np.atleast_1d(np.asarray(angles, dtype=float))
    found = [
        Quantity(name, (), np.asarray(getattr(state, name)), unit, words)
        for name, (unit, words) in _FIGURES.items()
        if only != "vdf"  # the diffusion coefficients are solved when they are asked for
    ]
    words, unit = "density of the velocity", "1/(g l)" if state.dimension == 2 else "(g l)^(-3/2)"
    density = np.asarray(state.vdf(v, phi)).T
    found.append(Quantity("vdf", ("angle", "v"), density, unit, words, "f", is_density=True))
    question = {
        "law": state.law.described,
        **{n: getattr(state, n) for n in ("restitution", "tangential_restitution", "dimension")},
    }
    return Table(
        (
            Quantity("v", ("v",), v, "sqrt(g l)", "speed"),
            Quantity("angle", ("angle",), phi, "rad", "angle to the field"),
        ),
        tuple(found),
        attributes_of(
            f"Steady state in a uniform field: {state.law.described}; units l = g = 1",
            question,
            (state.rtol, state.error_estimate),
            status=state.status.name.lower(),
            message=state.message,
        ),
    )

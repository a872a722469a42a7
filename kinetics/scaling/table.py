"""The scaled distribution as a table: F(c) at chosen c, h, a2 and moments."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.tables import Quantity, Table, attributes_of

_SPEEDS = np.linspace(0.0, 4.0, 201)[1:]
_POWERS = np.arange(1.0, 7.0)


def scaled_table(
    state: Any, c: ArrayLike | None, accuracy: tuple[float, float] | None, **more: str
) -> Table:
    """The table of a ScaledVDF or a ScalingSolution; without F(c) where bounces are elastic.

    accuracy, more : of `kinetics.tables.attributes_of`
    """
    speeds = _SPEEDS if c is None else np.atleast_1d(np.asarray(c, dtype=float))
    h = state.cooling_rate
    found = [
        Quantity("cooling_rate", (), np.asarray(h), "1", "h(e), from v0 = 2 l/(h t)", "h"),
        Quantity("a2", (), np.asarray(state.a2), "1", "<c^4> d/(d+2) - 1", "a2"),
        Quantity(
            "moment", ("p",), np.array([state.moment(p) for p in _POWERS]), "1",
            "<c^p>, c the speed over the thermal speed", "<c^p>",
        ),
    ]  # fmt: skip
    if h > 0.0:
        words = "scaled velocity distribution F(c), its integral over the plane or space is 1"
        density = np.asarray(state.vdf(speeds))
        found.append(Quantity("vdf", ("c",), density, "1", words, "F", is_density=True))
    title = f"Scaled velocity distribution: {state.law.described}"
    return Table(
        (
            Quantity("c", ("c",), speeds, "1", "speed over the thermal speed"),
            Quantity("p", ("p",), _POWERS, "1", "power of the speed"),
        ),
        tuple(found),
        attributes_of(title, state, accuracy, **more),
    )

"""Starts of extreme sizes, and what is known exactly of them, for the tests of stability."""

import math
from typing import Any

import mpmath as mp

from kinetics import (
    Beam,
    Gaussian,
    InputError,
    Monoenergetic,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
)

DENSITY = ("speed_density", "thermal_speed")


def starts(scale: float) -> dict[str, tuple[Any, float]]:
    """Name -> state and its <v^2>/scale^2."""
    return {
        "delta": (Monoenergetic(scale), 1.0),
        "gaussian": (Gaussian(scale, scale), 2.0),
        "tail": (
            SpeedDensity(lambda v: 5 * (v / scale) * (1 + (v / scale) ** 2) ** -3.5 / scale),
            2.0 / 3.0,
        ),
        "table": (SpeedTable([0.5 * scale, scale, 1.5 * scale], [0.0, 2.0 / scale, 0.0]), 25 / 24),
        "samples": (SpeedSamples([0.1 * scale, scale, 3.0 * scale]), 10.01 / 3.0),
        "beam": (Beam(0.3, Monoenergetic(scale)), 1.0),
    }


def cooling_rate(e: float) -> float:
    """h, from averages over the impact parameter in many digits."""
    if e == 0.0:
        return math.sqrt(2.0)
    # 1 - e^2 must differ from 1
    with mp.workdps(50 + int(-2.0 * math.log10(e))):
        b = mp.sqrt(1 - mp.mpf(e) ** 2)
        kappa = 1 - e * mp.acos(e) / b
        first = (1 - mp.mpf(e) ** 2 * mp.atanh(b) / b) / 2
        return float(2 * mp.sqrt(kappa * first))


def one_line(error: InputError) -> None:
    message = str(error)
    assert "\n" not in message
    assert message.split(":")[0].isidentifier(), message

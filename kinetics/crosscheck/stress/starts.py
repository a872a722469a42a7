"""Rough and extreme initial states of the sweep, and quadratures that stand for them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.limits import FloatArray, Law, as_law
from kinetics.numerics.gauss import panels_between

_POINTS = 16  # of Gauss-Legendre in each panel
NARROW = 1e-3  # deviation of v_y over that of v_x


def starts() -> dict[str, Any]:
    """Initial states by name."""
    from kinetics import Beam, Gaussian, SpeedSamples, SpeedTable

    return {
        "monoenergetic": "monoenergetic",
        "gaussian": "gaussian",
        "step": SpeedTable([1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0]),
        "narrow triangle": SpeedTable([1.0 - 1e-6, 1.0, 1.0 + 1e-6], [0.0, 1e6, 0.0]),
        "two delta peaks": SpeedSamples([0.01, 1.0]),
        "speeds 1e-100 and 1": SpeedSamples([1e-100, 1.0]),
        "two spikes 1e150 apart": SpeedTable(
            [1e-150, 2e-150, 3e-150, 1.0, 2.0, 3.0], [0.0, 0.5e150, 0.0, 0.0, 0.5, 0.0]
        ),
        "uniform from 0": SpeedTable([0.0, 1.0], [1.0, 1.0]),
        "tail v^-6": tail,
        "beam": Beam(0.3),
        "two temperatures, 1e-3 and 1": Gaussian(1.0, NARROW),
    }


def solve_start(
    e: Law, label: str, times: Any, outputs: tuple[str, ...], rtol: float, **options: Any
) -> Any:
    """The solution from the start of this name, at the default density; options: of `solve`."""
    from kinetics import Beam, Scene, solve

    law = as_law(e)
    # in space a beam must be along the axis of symmetry
    start = Beam(0.0) if label == "beam" and law.dimension == 3 else starts()[label]
    scene = Scene(law, initial=start, times=times, outputs=outputs)
    return solve(scene, rtol, **options)


def tail(v: Any) -> Any:
    """A speed density that falls as v^-6."""
    with np.errstate(under="ignore"):
        return 5.0 * np.asarray(v) * np.hypot(1.0, v) ** -7.0


def quadrature(label: str) -> tuple[FloatArray, FloatArray]:
    """Speeds and weights that stand for the start of this name, (n,) each; none of the solver's."""
    x, w = panels_between(np.array([-1.0, 0.0, 1.0]), _POINTS)
    w *= 1.0 - np.abs(x)  # a triangle
    one, half = (np.ones(1), np.ones(1)), np.array([0.5, 0.5])
    spikes = np.concatenate([1e-150 * (2.0 + x), 2.0 + x])
    known: dict[str, Callable[[], tuple[FloatArray, FloatArray]]] = {
        "monoenergetic": lambda: one,
        "beam": lambda: one,
        "two delta peaks": lambda: (np.array([0.01, 1.0]), half),
        "speeds 1e-100 and 1": lambda: (np.array([1e-100, 1.0]), half),
        "two spikes 1e150 apart": lambda: (spikes, 0.5 * np.tile(w, 2)),
        "narrow triangle": lambda: (1.0 + 1e-6 * x, w),
        "step": lambda: panels_between(np.linspace(1.0, 2.0, 5), _POINTS),
        "uniform from 0": lambda: _logarithmic(-36.0, 0.0, np.ones_like),
        "gaussian": lambda: _logarithmic(-18.0, 2.5, lambda v: v * np.exp(-0.5 * v * v)),
        "two temperatures, 1e-3 and 1": lambda: _logarithmic(-25.0, 2.5, _two_temperatures),
        "tail v^-6": lambda: _logarithmic(-18.0, 36.0, tail),
    }
    return known[label]()


def first_averages(label: str, dimension: int = 2) -> tuple[float, float]:
    """v0 and a2 of a start, by its quadrature."""
    v, w = quadrature(label)
    with np.errstate(under="ignore"):
        second, fourth = float(w @ v**2), float(w @ v**4)
    gaussian = (dimension + 2.0) / dimension
    return math.sqrt(second), fourth / (gaussian * second**2) - 1.0


def _two_temperatures(v: FloatArray) -> FloatArray:
    from scipy.special import i0e

    a, b = 1.0, 1.0 / NARROW**2
    return np.asarray(v / NARROW * np.exp(-0.5 * a * v * v) * i0e(0.25 * (b - a) * v * v))


def _logarithmic(
    low: float, high: float, density: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Panels of width 1/2 in ln v."""
    x, w = panels_between(np.linspace(low, high, math.ceil(2.0 * (high - low)) + 1), _POINTS)
    v = np.exp(x)
    return v, w * v * density(v)

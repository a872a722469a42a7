"""Rough and extreme initial states of the sweep, and what is known of them by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

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


def tail(v: Any) -> Any:
    """A speed density that falls as v^-6."""
    with np.errstate(under="ignore"):
        return 5.0 * np.asarray(v) * np.hypot(1.0, v) ** -7.0


def quadrature(label: str) -> tuple[FloatArray, FloatArray]:
    """Speeds and weights that stand for the start of this name, (n,) each; none of the solver's."""
    if label in ("monoenergetic", "beam"):
        return np.ones(1), np.ones(1)
    if label == "two delta peaks":
        return np.array([0.01, 1.0]), np.array([0.5, 0.5])
    if label == "speeds 1e-100 and 1":
        return np.array([1e-100, 1.0]), np.array([0.5, 0.5])
    if label == "two spikes 1e150 apart":
        v, w = _panels(np.array([1.0, 2.0, 3.0]), lambda x: np.minimum(x - 1.0, 3.0 - x))
        return np.concatenate([1e-150 * v, v]), np.concatenate([0.5 * w, 0.5 * w])
    if label == "step":
        return _panels(np.linspace(1.0, 2.0, 5), np.ones_like)
    if label == "narrow triangle":
        v, w = _panels(np.array([-1.0, 0.0, 1.0]), lambda x: 1.0 - np.abs(x))
        return 1.0 + 1e-6 * v, w
    if label == "uniform from 0":
        return _logarithmic(-36.0, 0.0, np.ones_like)
    if label == "gaussian":
        return _logarithmic(-18.0, 2.5, lambda v: v * np.exp(-0.5 * v * v))
    if label == "two temperatures, 1e-3 and 1":
        return _logarithmic(-25.0, 2.5, _two_temperatures)
    return _logarithmic(-18.0, 36.0, tail)


def _two_temperatures(v: FloatArray) -> FloatArray:
    from scipy.special import i0e

    a, b = 1.0, 1.0 / NARROW**2
    return np.asarray(v / NARROW * np.exp(-0.5 * a * v * v) * i0e(0.25 * (b - a) * v * v))


def _panels(
    edges: FloatArray, density: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.diff(edges)[:, None]
    v = (edges[:-1, None] + half * (1.0 + x)).ravel()
    return v, (half * w).ravel() * density(v)


def _logarithmic(
    low: float, high: float, density: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Panels of width 1/2 in ln v."""
    x, w = _panels(np.linspace(low, high, math.ceil(2.0 * (high - low)) + 1), np.ones_like)
    v = np.exp(x)
    return v, w * v * density(v)


def first_moments(label: str) -> tuple[float, float] | None:
    """sqrt(<v^2>) and <v^4>/(2 <v^2>^2) of a start, by hand; None for the step."""
    second, fourth = {
        "monoenergetic": (1.0, 1.0),
        "beam": (1.0, 1.0),
        "gaussian": (2.0, 8.0),
        "two delta peaks": ((1.0 + 1e-4) / 2.0, (1.0 + 1e-8) / 2.0),
        "speeds 1e-100 and 1": (0.5, 0.5),
        "two spikes 1e150 apart": (25.0 / 12.0, 0.5 * 301.0 / 15.0),
        "uniform from 0": (1.0 / 3.0, 1.0 / 5.0),
        "two temperatures, 1e-3 and 1": (1.0 + 1e-6, 3.0 + 2e-6 + 3e-12),
        "tail v^-6": (2.0 / 3.0, 8.0 / 3.0),
        "narrow triangle": (1.0 + 1e-12 / 6.0, 1.0 + 1e-12),
    }.get(label, (0.0, 0.0))
    if not second:
        return None
    return math.sqrt(second), fourth / (2.0 * second**2)

"""Measures the constants of kinetics/states and prints them beside the values used.

Run as a script: python tests/kinetics/measurements/states.py (some seconds).
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.states import quadrature


def gaussian_error(rtol: float, lowest: float, highest: float) -> float:
    """Largest error of <v^p>, p from lowest to highest, relative to itself, over rtol."""
    points = quadrature.gaussian(rtol, lowest, highest)
    worst = 0.0
    for p in np.linspace(lowest, highest, 9):
        exact = 2.0 ** (p / 2.0) * math.gamma(1.0 + p / 2.0)
        worst = max(worst, abs(points.weight @ np.exp(p * points.x) / exact - 1.0))
    return worst / rtol


def gathering_error(p: float) -> float:
    """Error of the mean of 1/(1 + v)^p over samples that were gathered on a grid, relative."""
    x = np.random.default_rng(1).normal(size=5000)
    found = quadrature.samples(x, np.full(x.size, 1.0 / x.size), 1e-9, 2.0)
    exact = np.mean((1.0 + np.exp(x)) ** -p)
    return float(abs(found.weight @ (1.0 + np.exp(found.x)) ** -p / exact - 1.0))


if __name__ == "__main__":
    print("quadrature.gaussian: 8 + 1.5 highest e-folds for the powers of v, so that the error")
    print("stays below rtol: largest error over rtol, by rtol and by powers")
    for rtol in (1e-3, 1e-6, 1e-9, 1e-12):
        row = [gaussian_error(rtol, *powers) for powers in ((0, 2), (0, 4), (0, 12), (-1.5, 2))]
        print(f"  {rtol:.0e}:", *(f"{value:9.2e}" for value in row))
    print("quadrature.samples: 12 points, 1/16 apart, leave 1e-13: measured for (1 + v)^-p")
    for p in (1.0, 4.0, 16.0):
        print(f"  p = {p:g}: {gathering_error(p):.1e}")

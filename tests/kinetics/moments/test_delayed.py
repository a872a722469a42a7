"""Returns that take time, against plain steps in time that share no code with the solver."""

from typing import Any

import numpy as np
import pytest

from kinetics import Beam, Scene, solve
from kinetics.collision import law_in_medium
from kinetics.collision.law import CollisionLaw

LAST = 8.0  # T, in l/U


def by_steps(e: float, p: float, source: float, loops: list[Any], step: float) -> np.ndarray:
    """<x>/l of a beam, source 1 and p = 0, or <v^p> of one speed, source 0, by Heun's method.

    At T = 0, step, ..., LAST:  Y' = source + (K - 1) U,  U = Y + V, and V is the sum over (r, y, k)
    in loops of r^p k [(K - 1) U](r (T - y (1 + 1/r)/2)).
    """
    grid = np.arange(0.0, LAST + step, step)
    impact, weight = np.polynomial.legendre.leggauss(60)
    impact, weight = 0.5 * (impact + 1.0), 0.5 * weight
    ratio = np.sqrt(e**2 + (1 - e**2) * impact**2)
    gain = weight * (((1 + e) * impact**2 - e) / ratio if source else ratio**p)
    total, lost = np.zeros(grid.size), np.zeros(grid.size)  # U and (K - 1) U
    found = np.full(grid.size, 1.0 - source)

    def rate(k: int, now: float) -> float:
        total[k] = now
        for r, y, many in loops:
            left = r * (grid[k] - y * 0.5 * (1 + 1 / r))
            begun = (left >= 0.0) & (k > 0)
            total[k] += (r**p * many * np.interp(left, grid[: k or 1], lost[: k or 1]))[begun].sum()
        lost[k] = gain @ np.interp(ratio * grid[k], grid[: k + 1], total[: k + 1]) - total[k]
        return float(source + lost[k])

    slope = rate(0, found[0])
    for k in range(1, grid.size):
        ahead = rate(k, found[k - 1] + step * slope)
        found[k] = found[k - 1] + 0.5 * step * (slope + ahead)
        slope = rate(k, found[k])
    return found


def spread(e: float, n: float, r: float, b: float, eps: float | None, share: float) -> list[Any]:
    """Near loops, and those of the size of l: their share, or what is left of eps."""
    log_y = np.linspace(np.log(1e-4 * n), np.log(40.0), 1200)
    y = np.exp(log_y)
    near = 2 * e / (1 + e) * n * np.exp(-0.6 * (y + 2 * n)) / (y + 2 * n) * y
    far = (np.exp(-0.9 * y / b) - np.exp(-1.1 * y / b)) * y
    rest = share if eps is None else eps - np.trapezoid(near, log_y)
    step = log_y[1] - log_y[0]
    return [(e, y, near * step), (r, y, far * step * rest / np.trapezoid(far, log_y))]


@pytest.mark.parametrize(("e", "n"), [(0.7, 0.04), (0.4, 0.1), (1.0, 0.05)])
def test_averages_by_plain_steps(e: float, n: float) -> None:
    """The path of a beam, and powers of the speed with loops of their own: <v^2>, <v^4>."""
    law = law_in_medium(CollisionLaw(e), "overlapping", n, 1.0)
    assert law.medium is not None
    times, path = np.array([0.1, 0.5, 1.0, 3.0, LAST]), 0.5 / n * law.medium.path_ratio
    scene = Scene(
        e, n, times=times * path, initial=Beam(), scatterers="overlapping",
        outputs=("mean_displacement", "thermal_speed"),
    )  # fmt: skip
    solution = solve(scene, 1e-9)
    loops = [
        (r, y, -many) for r, y, many in spread(e, n, e, 1.8 * e, -law.medium.returns(1)[0], 0.0)
    ]
    asked = [(solution.mean_displacement[:, 0] / path, 0.0, 1.0, loops)]
    if e < 1.0:  # among others, what comes back at once
        (at_once, fall), (r, b, share) = law.medium.of_speed, law.medium.far_loops
        loops = [*spread(e, n, r, b, None, share), (np.exp(-fall), np.zeros(1), at_once)]
        asked += [(solution.moment(p), p, 0.0, loops) for p in (2.0, 4.0)]
    for found, p, source, loops in asked:
        errors = []
        for step in (0.02, 0.01):
            steps = by_steps(e, p, source, loops, step)
            errors.append(np.abs(steps[np.round(times / step).astype(int)] / found - 1.0).max())
        assert errors[1] < 2e-3
        assert errors[1] < 0.6 * errors[0]

"""Returns that take time, against plain steps in time that share no code with the solver."""

import numpy as np
import pytest

from kinetics import Beam, Scene, solve
from kinetics.collision import law_in_medium
from kinetics.collision.law import CollisionLaw


def along_the_start(e: float, n: float, eps: float, step: float, last: float) -> np.ndarray:
    """<x>/l of a beam of one speed at T = 0, step, ..., by Heun's method on a grid of T.

    Y' = 1 + (K - 1) U, U = Y + V, V(T) = -int k(y) [(K - 1) U](e (T - y (1 + 1/e)/2)) dy.
    """
    grid = np.arange(0.0, last + step, step)
    impact, weight = np.polynomial.legendre.leggauss(60)
    impact, weight = 0.5 * (impact + 1.0), 0.5 * weight
    ratio = np.sqrt(e**2 + (1 - e**2) * impact**2)
    gain = weight * ((1 + e) * impact**2 - e) / ratio
    log_y = np.linspace(np.log(1e-4 * n), np.log(40.0), 1200)
    y = np.exp(log_y)
    near = 2 * e / (1 + e) * n * np.exp(-0.6 * (y + 2 * n)) / (y + 2 * n)
    far = np.exp(-0.9 * y / (1.8 * e)) - np.exp(-1.1 * y / (1.8 * e))
    rest = (eps - np.trapezoid(near * y, log_y)) / np.trapezoid(far * y, log_y)
    loops = near + rest * far
    loops *= y * (log_y[1] - log_y[0])
    total, lost = np.zeros(grid.size), np.zeros(grid.size)  # U and (K - 1) U
    value, found = 0.0, np.zeros(grid.size)

    def rate(k: int, now: float) -> float:
        left = e * (grid[k] - y * 0.5 * (1 + 1 / e))
        returned = loops * np.interp(left, grid[:k], lost[:k], left=0.0) if k else np.zeros(1)
        total[k] = now - returned[left > 0.0].sum() if k else now
        lost[k] = gain @ np.interp(ratio * grid[k], grid[: k + 1], total[: k + 1]) - total[k]
        return float(1.0 + lost[k])

    slope = rate(0, 0.0)
    for k in range(1, grid.size):
        ahead = rate(k, value + step * slope)
        value += 0.5 * step * (slope + ahead)
        slope = rate(k, value)
        found[k] = value
    return found


@pytest.mark.parametrize(("e", "n"), [(0.7, 0.04), (0.4, 0.1), (1.0, 0.05)])
def test_the_path_of_a_beam_by_plain_steps(e: float, n: float) -> None:
    law = law_in_medium(CollisionLaw(e), "overlapping", n, 1.0)
    assert law.medium is not None
    times, path = np.array([0.1, 0.5, 1.0, 3.0, 8.0]), 0.5 / n * law.medium.path_ratio
    scene = Scene(
        e, n, times=times * path, initial=Beam(), scatterers="overlapping",
        outputs="mean_displacement",
    )  # fmt: skip
    found = solve(scene, 1e-9).mean_displacement[:, 0] / path
    errors = []
    for step in (0.02, 0.01):
        steps = along_the_start(e, n, -law.medium.returns(1)[0], step, 8.0)
        errors.append(np.abs(steps[np.round(times / step).astype(int)] / found - 1.0).max())
    assert errors[1] < 2e-3
    assert errors[1] < 0.5 * errors[0]

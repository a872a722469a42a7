"""The methods by name, each asked in the way that the benchmark needs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics import Scene, solve
from kinetics.crosscheck.bench import straightforward
from kinetics.crosscheck.references import MEAN_FREE_PATH
from kinetics.paper.series import SeriesStatus, cooling, scaled_state
from particles import BoltzmannGrad, simulate

FloatArray = NDArray[np.float64]

SPECTRAL, CONSERVATIVE = "spectral", "conservative"
STRAIGHTFORWARD, SONINE, MONTE_CARLO = "straightforward", "Sonine", "Monte Carlo"
PRINTED = "as printed"
METHODS = (SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD, SONINE, MONTE_CARLO, PRINTED)
PARTICLES = "particles"

NUMBER_DENSITY = 0.04  # of the paper: l = MEAN_FREE_PATH
TIGHTEST = 1e-13  # rtol of the runs whose nodes are given
LATE = {CONSERVATIVE: 1e10, MONTE_CARLO: 1e7}  # d/U, where the scaling state is reached
_MEDIA = 50  # blocks of a Monte Carlo run

OTHER_LAWS: dict[str, dict[str, Any]] = {
    "spheres": {"dimension": 3},
    "et = 0.8": {"tangential_restitution": 0.8},
    "spheres, et = 0.8": {"tangential_restitution": 0.8, "dimension": 3},
}
"""Laws beside smooth disks, as the names of problems and the arguments of `Scene` have them."""


# -- the conservative scheme -----------------------------------------------------------------------


def conservative(e: float, start: str, times: FloatArray, nodes: int) -> Any:
    """The conservative scheme's speed density, as a user asks for it.

    At the tightest tolerance the scheme itself serves every time; none is left to the scaling
    state, which is spectral.
    """
    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=("speed_density",))
    return solve(scene, TIGHTEST, method=CONSERVATIVE, nodes=nodes)


def conservative_cooling(
    e: float, start: str, times: FloatArray, nodes: int
) -> tuple[FloatArray, FloatArray]:
    """v0 (U) and a2 from the conservative scheme, shape (n_times,) each."""
    return _density_moments(conservative(e, start, times, nodes), start, nodes)


def _density_moments(solution: Any, start: str, nodes: int) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 from the density: the trapezoid rule in ln v, four points for each node."""
    # from far below the scaling state's thermal speed at the end up to the fastest of the start
    slowest = 1e-5 * min(1.0, MEAN_FREE_PATH / solution.times[-1])
    fastest = 2.0 * straightforward.FASTEST[start]
    v = np.geomspace(slowest, fastest, 4 * nodes)
    weight = solution.speed_density(v) * v * math.log(v[1] / v[0])
    second, fourth = (weight @ v**p + solution.uncollided for p in (2, 4))
    return np.sqrt(second), 0.5 * fourth / second**2 - 1.0


@dataclass(frozen=True)
class LateState:
    """The scaling state as a late time has it; named as the properties of `ScalingSolution`."""

    thermal_speed: float
    a2: float
    time: float
    solution: Any = None

    @property
    def cooling_rate(self) -> float:
        """h from v0 = 2 l/(h t)."""
        return 2.0 * MEAN_FREE_PATH / (self.thermal_speed * self.time)

    def vdf(self, c: FloatArray) -> FloatArray:
        """F(c), c > 0."""
        density = self.solution.speed_density(c * self.thermal_speed)[0] * self.thermal_speed
        return np.asarray(density / (2.0 * math.pi * c))


def conservative_state(e: float, nodes: int) -> LateState:
    """From a Gaussian start, by the conservative scheme."""
    late = LATE[CONSERVATIVE]
    solution = conservative(e, "gaussian", np.array([late]), nodes)
    speed, a2 = _density_moments(solution, "gaussian", nodes)
    return LateState(float(speed[0]), float(a2[0]), late, solution)


# -- the Sonine expansion: an order without a real solution is a ValueError, and so a failed row ---


def sonine_state(e: float, order: int) -> Any:
    """The scaled equation at this order."""
    state = scaled_state(e, order)
    if state.status is not SeriesStatus.REAL:
        raise ValueError(f"order = {order}: no real solution at restitution {e:g}")
    return state


def sonine_cooling(
    e: float, start: str, times: FloatArray, order: int
) -> tuple[FloatArray, FloatArray]:
    """v0 (U) and a2, shape (n_times,) each."""
    found = cooling(e, times, order, MEAN_FREE_PATH, start, 1e-8)
    if found.status is not SeriesStatus.REAL:
        raise ValueError(f"order = {order}: {found.status.value}")
    return found.thermal_speed, found.a2


# -- Monte Carlo -----------------------------------------------------------------------------------


def particles(
    e: float,
    start: Any,
    times: FloatArray,
    samples: float,
    seed: int,
    observables: tuple[str, ...] = (),
    tangential_restitution: float = 1.0,
    dimension: int = 2,
) -> Any:
    """A Boltzmann-Grad run in blocks, of one thread, with the free path MEAN_FREE_PATH."""
    medium = BoltzmannGrad(NUMBER_DENSITY)
    if dimension == 3:
        medium = BoltzmannGrad(1.0 / (math.pi * MEAN_FREE_PATH), dimension=3)
    return simulate(
        medium,
        restitution=e,
        initial=start,
        times=times,
        media=_MEDIA,
        tracers=max(1, int(samples) // _MEDIA),
        seed=seed,
        observables=observables or None,
        workers=1,
        tangential_restitution=tangential_restitution,
    )


def monte_carlo_state(e: float, samples: float, seed: int, **law: Any) -> LateState:
    """h and a2 from a Gaussian start; law : tangential restitution and dimension."""
    late = LATE[MONTE_CARLO]
    run = particles(e, "gaussian", np.array([late]), samples, seed, **law)
    return LateState(float(run.thermal_speed.value[0]), float(run.a2.value[0]), late)

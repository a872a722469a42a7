"""The methods by name, and those of this package asked in the way that the comparison needs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.bench import references, straightforward

FloatArray = NDArray[np.float64]

SPECTRAL, CONSERVATIVE = "spectral", "conservative"
STRAIGHTFORWARD, SONINE, MONTE_CARLO = "straightforward", "Sonine", "Monte Carlo"
PRINTED = "as printed"
METHODS = (SPECTRAL, CONSERVATIVE, STRAIGHTFORWARD, SONINE, MONTE_CARLO, PRINTED)

NUMBER_DENSITY = 0.04  # of the paper: l = references.MEAN_FREE_PATH
TIGHTEST = 1e-13  # rtol of the runs whose nodes are given
_MEDIA = 50  # blocks of a Monte Carlo run


def panels(e: float, start: str, times: FloatArray, nodes: int) -> tuple[FloatArray, FloatArray]:
    """The spectral averages with so many nodes in a panel of the backward equation."""
    from kinetics import CollisionLaw
    from kinetics.moments.velocity import Averages
    from kinetics.states.isotropic import NAMED

    averages = Averages(
        CollisionLaw(e), references.MEAN_FREE_PATH, NAMED[start], times, TIGHTEST, nodes=nodes
    )
    second, fourth = averages.power(2.0), averages.power(4.0)
    return (
        np.asarray(np.exp(averages.log_reference) * np.sqrt(second)),
        np.asarray(0.5 * fourth / second**2 - 1.0),
    )


def conservative(e: float, start: str, times: FloatArray, nodes: int) -> Any:
    """The conservative scheme's speed density, as a user asks for it.

    At the tightest tolerance the scheme itself serves every time; none is left to the scaling
    state, which is spectral.
    """
    from kinetics import Scene, solve

    scene = Scene(e, NUMBER_DENSITY, initial=start, times=times, outputs=("speed_density",))
    return solve(scene, TIGHTEST, method=CONSERVATIVE, nodes=nodes)


def conservative_cooling(
    e: float, start: str, times: FloatArray, nodes: int
) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 from the conservative scheme."""
    return _density_moments(conservative(e, start, times, nodes), start, nodes)


def _density_moments(solution: Any, start: str, nodes: int) -> tuple[FloatArray, FloatArray]:
    """v0 and a2 from the density: the trapezoid rule in ln v, four points for each node."""
    # from far below the scaling state's thermal speed at the end up to the fastest of the start
    slowest = 1e-5 * min(1.0, references.MEAN_FREE_PATH / solution.times[-1])
    fastest = 2.0 * straightforward.FASTEST[start]
    v = np.geomspace(slowest, fastest, 4 * nodes)
    weight = solution.speed_density(v) * v * math.log(v[1] / v[0])
    second, fourth = (weight @ v**p + solution.uncollided for p in (2, 4))
    return np.sqrt(second), 0.5 * fourth / second**2 - 1.0


def conservative_vdf(e: float, nodes: int, late: float, c: FloatArray) -> FloatArray:
    """F(c) from the conservative scheme at a late time."""
    solution = conservative(e, "gaussian", np.array([late]), nodes)
    thermal = float(_density_moments(solution, "gaussian", nodes)[0][0])
    density = solution.speed_density(c * thermal)[0] * thermal
    return np.asarray(density / (2.0 * math.pi * c))


def particles(
    e: float,
    start: Any,
    times: FloatArray,
    samples: int,
    seed: int,
    observables: tuple[str, ...] = (),
) -> Any:
    """A Boltzmann-Grad run in blocks, of one thread."""
    from particles import BoltzmannGrad, simulate

    return simulate(
        BoltzmannGrad(NUMBER_DENSITY),
        restitution=e,
        initial=start,
        times=times,
        media=_MEDIA,
        tracers=max(1, samples // _MEDIA),
        seed=seed,
        observables=observables or None,
        workers=1,
    )

"""The scatterers of the unbounded plane, drawn from the streams of its regions.

The plane is cut by a grid whose lines lie alternately side - 2 and 2 apart: cores of cells, bands
along their edges and squares at their corners. A cell lists what can be touched in it, which is
the 3 by 3 regions around its core: no more than is listed is ever drawn, and each region, whichever
cell asks for it, is drawn from its own stream and so always the same.

A region's candidates are a Poisson process, each with a mark uniform on (0, 1). Overlapping
scatterers are all of them. Hard disks are those that random sequential addition in the order of
the marks keeps: a candidate is refused if one of lower mark, itself kept, is nearer than 1. Such
chains are short, so a candidate is decided by a few others around it.
"""

from math import exp, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import int64, njit, uint64

from particles.streams import mix, plane_key, to_unit, uniform

BAND = 2.0  # a circle of radius 1 reaches over an edge from no farther
# Odd numbers without a pattern: the fractional parts of sqrt(2) and sqrt(3).
_SQRT2, _SQRT3 = 0x6A09E667F3BCC909, 0xBB67AE8584CAA73B
# Candidates per region that are drawn at most; means are below 16.
ROOM = 100


class Law(NamedTuple):
    """What a plane is drawn from.

    side: of a cell. Mean number of candidates of a core, a band and a corner, and the chance of
    none. hard: whether they exclude one another. key: of its regions' streams. Plain numbers,
    which cost nothing to pass.
    """

    side: float
    core_mean: float
    band_mean: float
    corner_mean: float
    core_none: float
    band_none: float
    corner_none: float
    hard: bool
    key: Any


def make_law(
    side: float, number_density: float, hard: bool, seed: np.uint64, configuration: int
) -> Law:
    """Return the law of a plane of this density (d^-2) whose cells have this side (at least 3)."""
    core = side - BAND
    density = candidate_density(number_density) if hard else number_density
    inner, band, corner = density * core * core, density * core * BAND, density * BAND * BAND
    return Law(
        side, inner, band, corner, exp(-inner), exp(-band), exp(-corner), hard,
        plane_key(seed, configuration),
    )  # fmt: skip


def candidate_density(number_density: float) -> float:
    """Return candidates per unit area (d^-2) of which random sequential addition keeps this many.

    The integral of 1 / phi, phi the chance of finding room at coverage theta to third order
    (Schaaf & Talbot, Phys. Rev. Lett. 62, 175, 1989).
    """
    theta = pi / 4 * number_density
    third = 40 / (sqrt(3) * pi) - 176 / (3 * pi**2)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t = 0.5 * theta * (nodes + 1)
    room = 1 - 4 * t + 6 * sqrt(3) / pi * t**2 + third * t**3
    return float(0.5 * theta * np.sum(weights / room) * 4 / pi)


@njit(error_model="numpy", forceinline=True)
def open_region(law: Law, p: int, q: int) -> tuple[Any, Any]:
    """Return the stream of region (p, q): core of cell (i, j) at (2i, 2j), bands at odd p or q."""
    place = uint64(int64(p)) * uint64(_SQRT2) + uint64(int64(q)) * uint64(_SQRT3)
    state = mix(uint64(law.key) + place)
    return state, mix(state ^ uint64(law.key)) | uint64(1)


@njit(error_model="numpy", forceinline=True)
def candidates(law: Law, p: int, q: int, state: Any) -> int:
    """Return the number of candidates of a region: Poisson, by inversion of its stream's state."""
    mean, probability = law.band_mean, law.band_none
    if (p & 1) + (q & 1) == 0:
        mean, probability = law.core_mean, law.core_none
    elif p & q & 1:
        mean, probability = law.corner_mean, law.corner_none
    left = to_unit(state)
    n = 0
    while left > probability and n < ROOM:
        left -= probability
        n += 1
        probability *= mean / n
    return n


@njit(error_model="numpy", forceinline=True)
def width(law: Law, p: int) -> float:
    """Return the width of the regions of this column, or height of this row."""
    return BAND if p & 1 else law.side - BAND


@njit(error_model="numpy", forceinline=True)
def candidate(law: Law, p: int, q: int, state: Any, gamma: Any, k: int) -> tuple[float, float]:
    """Return a candidate's place from the centre of its region."""
    x = (uniform(state, gamma, 3 * k + 1) - 0.5) * width(law, p)
    y = (uniform(state, gamma, 3 * k + 2) - 0.5) * width(law, q)
    return x, y


@njit(error_model="numpy", forceinline=True)
def is_clear(law: Law, p: int, q: int, x: float, y: float) -> bool:
    """Tell whether a place in a region is not within 1 of the origin, where tracers start."""
    ox, oy = x + 0.5 * p * law.side, y + 0.5 * q * law.side
    return ox * ox + oy * oy >= 1.0


@njit(error_model="numpy")
def is_kept(law: Law, p: int, q: int, x: float, y: float, mark: float) -> bool:
    """Tell whether a candidate of region (p, q) finds room when its mark is up."""
    half = 0.5 * law.side
    for dp in range(-1, 2):
        if dp * x < abs(dp) * (0.5 * width(law, p) - 1.0):
            continue
        for dq in range(-1, 2):
            if dq * y < abs(dq) * (0.5 * width(law, q) - 1.0):
                continue
            state, gamma = open_region(law, p + dp, q + dq)
            for k in range(candidates(law, p + dp, q + dq, state)):
                px, py = candidate(law, p + dp, q + dq, state, gamma, k)
                dx, dy = px + dp * half - x, py + dq * half - y
                if dx * dx + dy * dy >= 1.0 or not is_clear(law, p + dp, q + dq, px, py):
                    continue
                earlier = uniform(state, gamma, 3 * k + 3)
                if earlier < mark and is_kept(law, p + dp, q + dq, px, py, earlier):
                    return False
    return True

"""The scatterers of the unbounded plane, drawn from the streams of its regions.

The plane is cut into square blocks of cells. Each block has three kinds of regions: its core, bands
along its edges and squares at its corners; bands and squares are shared with the neighbours. Each
region is drawn from a random stream of its own, so it is always the same, whichever block is made;
a block is made from the 3 by 3 regions in and around it.

The candidates of a region are a Poisson process, each with a mark uniform on (0, 1). Overlapping
scatterers are all candidates. Hard disks are those that random sequential addition in the order of
the marks keeps: a candidate is refused if another one that is kept has a lower mark and is nearer
than 1. Whether that one is kept depends on its own neighbours in turn; such chains are short.
"""

from functools import lru_cache
from math import ceil, lgamma, log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import int64, njit, uint64

from particles.compiled.decorators import kernel
from particles.streams import CELLS, bits, mix, open_stream, to_unit

# Odd numbers without a pattern: the fractional parts of sqrt(2) and sqrt(3).
_SQRT2, _SQRT3 = 0x6A09E667F3BCC909, 0xBB67AE8584CAA73B
GUIDES = 256  # entries of a table that only shortens a search; the draws do not depend on it
_TO_UNIT = 2.0**-32


class Law(NamedTuple):
    """What a plane is drawn from.

    side: of a block. band: width of the bands. edge: from the origin to the left and the lower edge
    of block (0, 0). hard: whether scatterers exclude one another. key: of the regions' streams.
    Plain numbers, which cost nothing to pass.
    """

    side: float
    band: float
    edge: float
    hard: bool
    key: Any


class Counts(NamedTuple):
    """Distribution of the number of candidates of a core, a band and a corner.

    cumulative (3, most + 1): chance of no more than n. guides (3, 256): where to begin looking for
    a number u in it, by the first 8 bits of u.
    """

    cumulative: np.ndarray
    guides: np.ndarray


def make_law(side: float, edge: float, hard: bool, key: np.uint64) -> Law:
    """Return the law of a plane whose blocks have this side (at least 8).

    A circle of radius 1 reaches over an edge if its centre is within 1 of it; a candidate that
    excludes such a hard disk is within 2 of the edge. So bands are twice as wide as these lengths.
    """
    return Law(side, 4.0 if hard else 2.0, edge, hard, key)


def cells_key(seed: np.uint64, configuration: int) -> np.uint64:
    """Return the key of the streams that an unbounded medium is drawn from."""
    return np.uint64(_cells_key(seed, configuration))


@kernel
def _cells_key(seed: Any, configuration: int) -> Any:
    return open_stream(seed, CELLS, configuration, 0)[0]


@lru_cache(maxsize=8)
def make_counts(side: float, band: float, density: float) -> Counts:
    """Return the counts of regions of these sizes for a density of candidates in d^-2."""
    core = side - band
    return make_counts_of((density * core * core, density * core * band, density * band * band))


@lru_cache(maxsize=8)
def make_counts_of(means: tuple[float, ...]) -> Counts:
    """Return the distributions of Poisson numbers of these means, the largest mean first."""
    # Twelve standard deviations: the chance of more is below 1e-30.
    most = ceil(means[0] + 12.0 * sqrt(means[0]) + 40.0)
    n = np.arange(most + 1)
    factorials = np.array([lgamma(k + 1.0) for k in n])
    cumulative = np.array([np.cumsum(np.exp(n * log(mean) - mean - factorials)) for mean in means])
    cumulative[:, -1] = 1.0
    steps = np.arange(GUIDES) / GUIDES
    guides = np.array([np.searchsorted(row, steps) for row in cumulative])
    return Counts(cumulative, guides)


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


@njit(error_model="numpy", inline="always")
def open_region(law: Law, p: int, q: int) -> tuple[Any, Any]:
    """Return the stream of region (p, q): core of block (I, J) at (2I, 2J), bands at odd p or q."""
    place = uint64(int64(p)) * uint64(_SQRT2) + uint64(int64(q)) * uint64(_SQRT3)
    state = mix(uint64(law.key) + place)
    return state, mix(state ^ uint64(law.key)) | uint64(1)


@njit(error_model="numpy", inline="always")
def count(counts: Counts, p: int, q: int, state: Any) -> int:
    """Return the number of candidates of a region, by inversion of its stream's state."""
    kind = (p & 1) + (q & 1)
    u = to_unit(state)
    n = counts.guides[kind, int(u * GUIDES)]
    while u > counts.cumulative[kind, n]:
        n += 1
    return n


@njit(error_model="numpy", inline="always")
def width(law: Law, p: int) -> float:
    """Return the width of the regions of this column, or height of this row."""
    return law.band if p & 1 else law.side - law.band


@njit(error_model="numpy", inline="always")
def begin(law: Law, p: int) -> float:
    """Return where this column of regions begins, from the left edge of its block.

    Bands at odd p belong to the block on their left.
    """
    return law.side - 0.5 * law.band if p & 1 else 0.5 * law.band


@njit(error_model="numpy", inline="always")
def spot(state: Any, gamma: Any, k: int) -> tuple[float, float]:
    """Return the place of candidate k as shares of its region's width and height."""
    word = bits(state, gamma, 2 * k + 1)
    x = float(int64(word >> uint64(32))) + 0.5
    y = float(int64(word & uint64(0xFFFFFFFF))) + 0.5
    return x * _TO_UNIT, y * _TO_UNIT


@njit(error_model="numpy", inline="always")
def mark(state: Any, gamma: Any, k: int) -> float:
    """Return the mark of candidate k, which decides when its turn comes."""
    return to_unit(bits(state, gamma, 2 * k + 2))


@njit(error_model="numpy", inline="always")
def is_clear(law: Law, p: int, q: int, x: float, y: float) -> bool:
    """Tell whether (x, y) of a region is not within 1 of the origin, where tracers start."""
    ox = (p >> 1) * law.side + begin(law, p) + law.edge + x
    oy = (q >> 1) * law.side + begin(law, q) + law.edge + y
    return ox * ox + oy * oy >= 1.0


@njit(error_model="numpy")  # it calls itself
def is_kept(
    law: Law, counts: Counts, region: tuple[int, int], x: float, y: float, turn: float
) -> bool:
    """Tell whether a candidate at (x, y) of region (p, q) finds room when its turn comes."""
    p, q = region
    for dp in range(-1, 2):
        if (dp < 0 and x > 1.0) or (dp > 0 and x < width(law, p) - 1.0):
            continue
        ox = -width(law, p - 1) if dp < 0 else dp * width(law, p)
        for dq in range(-1, 2):
            if (dq < 0 and y > 1.0) or (dq > 0 and y < width(law, q) - 1.0):
                continue
            oy = -width(law, q - 1) if dq < 0 else dq * width(law, q)
            state, gamma = open_region(law, p + dp, q + dq)
            for k in range(count(counts, p + dp, q + dq, state)):
                sx, sy = spot(state, gamma, k)
                px, py = sx * width(law, p + dp), sy * width(law, q + dq)
                dx, dy = ox + px - x, oy + py - y
                if dx * dx + dy * dy >= 1.0 or not is_clear(law, p + dp, q + dq, px, py):
                    continue
                earlier = mark(state, gamma, k)
                if earlier < turn and is_kept(law, counts, (p + dp, q + dq), px, py, earlier):
                    return False
    return True

"""Where bounces do not end: grooves between two spheres and pockets between more of them.

Close to where the spheres of contact (radius 1) of several scatterers meet they are planes, and the
flights of a tracer may shrink geometrically, to infinitely many in a finite length. So after a
flight shorter than SHORT the bounces between all spheres within NEAR of contact are followed to
their end, between the planes that touch them there. Where they end after a finite number, that is
left to the event loop, as long as it can resolve them.

Between two planes bounces never end if rho, the normal speed with which the tracer leaves the one
plane over that with which it approaches the other one, is small (`events.lower_rebound`). For
et = 1 it then leaves along the edge with the speed that it has along it: a groove is no trap. For
et < 1 that speed is multiplied by et at each bounce, so it is left at rest: it is trapped. But the
spheres recede by path^2/2, which matters when path (along)/(across) is about 1, a number that each
bounce multiplies by rho^3/r^2: the bounces never end if rho^3 <= r^2.

More planes: the bounces are followed, each groove being left along its edge, until the tracer
leaves, or until its speed has fallen to GRAZING of what tangential friction alone would have left.
"""

from math import sqrt

import numpy as np
from numba import njit

from particles.cells import NEAR, SLOTS, Cells, next_listed
from particles.compiled import called
from particles.events import GRAZING, MOST_STEPS, NEVER, lower_rebound

UNRESOLVED = 1e-14  # in d: shorter flights are rounding
LEAVES, FOR_EVER, RESTS = range(3)


@called
def end_of_bounces(
    cells: Cells,
    cell: int,
    place: tuple[float, float, float],
    direction: tuple[float, float, float],
    law: tuple[float, float],
    path: float,
) -> tuple[tuple[float, float, float], float]:
    """Return (direction, speed ratio) with which a tracer leaves after a flight of this length.

    place: from the centre of the cell; direction: after the bounce there. law: (e, et), et > e.
    Ratio 0: the tracer is trapped. Both are unchanged where the event loop is to go on.
    """
    # The spheres within NEAR of contact: normals towards the tracer, and gaps.
    found = np.empty((cells.fill[cell], 4))
    n, slot, node = 0, 0, cells.head[cell]
    while slot < SLOTS or node >= 0:
        cx, cy, cz, slot, node = next_listed(cells, cell, slot, node)
        dx, dy, dz = place[0] - cx, place[1] - cy, place[2] - cz
        distance = sqrt(dx * dx + dy * dy + dz * dz)
        if distance <= 1.0 + NEAR:
            found[n, 0], found[n, 1], found[n, 2] = dx / distance, dy / distance, dz / distance
            found[n, 3] = max(distance - 1.0, 0.0)
            n += 1
    if n < 2:
        return direction, 1.0
    end, last, ratio = last_bounces(found[:n], direction, law[0], law[1])
    if end == LEAVES and path > UNRESOLVED:
        return direction, 1.0
    return last, ratio


@njit(error_model="numpy")
def is_endless(cosine: float, rho: float, restitution: float, tangential: float) -> bool:
    """Tell whether a tracer bounces for ever between two spheres; arguments of `lower_rebound`."""
    r, sine2 = restitution / tangential, (1.0 - cosine) * (1.0 + cosine)
    lower = lower_rebound(cosine, sine2, rho, restitution, tangential)
    return lower < NEVER if tangential == 1.0 else lower**3 <= r * r


@njit(error_model="numpy")
def last_bounces(
    walls: np.ndarray, direction: tuple[float, float, float], restitution: float, tangential: float
) -> tuple[int, tuple[float, float, float], float]:
    """Follow bounces between planes to their end: LEAVES, FOR_EVER (infinitely many) or RESTS.

    walls (n, 4): normals and gaps, 0 of the plane struck last; they are changed. Return also the
    unit direction in the end, and the ratio of the speeds after and before.
    """
    ux, uy, uz = direction
    n = walls.shape[0]
    gap = walls[:, 3]
    last = int(np.argmin(gap))
    ratio = friction = 1.0
    end = LEAVES
    for _ in range(MOST_STEPS):
        struck, path, approach, left = -1, np.inf, 0.0, 0.0
        for k in range(n):
            w = walls[k, 0] * ux + walls[k, 1] * uy + walls[k, 2] * uz
            if k == last:
                left = w
            # A sphere recedes by path^2 / 2 from the plane.
            if w < -GRAZING and w * w > 2.0 * gap[k] and gap[k] < -w * path:
                struck, path, approach = k, -gap[k] / w, w
        if struck < 0:
            return end, (ux, uy, uz), ratio
        nx, ny, nz = walls[struck, 0], walls[struck, 1], walls[struck, 2]
        mx, my, mz = walls[last, 0], walls[last, 1], walls[last, 2]
        farther = _gap_of_others(walls, last, struck, (ux, uy, uz))
        if (
            struck != last
            and left >= 0.0
            and 1e3 * max(gap[struck], gap[last]) <= farther
            and is_endless(nx * mx + ny * my + nz * mz, -left / approach, restitution, tangential)
        ):
            end = FOR_EVER
            (ux, uy, uz), along = _along_edge((nx, ny, nz), (mx, my, mz), (ux, uy, uz))
            ratio *= along
            if tangential < 1.0 or along < GRAZING or ratio < GRAZING:
                return RESTS, (ux, uy, uz), 0.0
            gap[struck] = gap[last] = 0.0
            continue
        for k in range(n):
            w = walls[k, 0] * ux + walls[k, 1] * uy + walls[k, 2] * uz
            gap[k] = max(gap[k] + w * path, 0.0)
        gap[struck] = 0.0
        change = (tangential + restitution) * approach
        ux = tangential * ux - change * nx
        uy = tangential * uy - change * ny
        uz = tangential * uz - change * nz
        size = sqrt(ux * ux + uy * uy + uz * uz)
        ratio *= size
        friction *= tangential
        if ratio <= GRAZING * friction:
            return RESTS, (ux, uy, uz), 0.0
        ux, uy, uz = ux / size, uy / size, uz / size
        last = struck
    return RESTS, (ux, uy, uz), 0.0


@called
def _along_edge(
    one: tuple[float, float, float],
    other: tuple[float, float, float],
    direction: tuple[float, float, float],
) -> tuple[tuple[float, float, float], float]:
    """Return (unit vector along the edge of two planes, component of the direction along it)."""
    (nx, ny, nz), (mx, my, mz), (ux, uy, uz) = one, other, direction
    tx, ty, tz = ny * mz - nz * my, nz * mx - nx * mz, nx * my - ny * mx
    size = sqrt(tx * tx + ty * ty + tz * tz)
    if size == 0.0:
        return direction, 0.0
    along = (tx * ux + ty * uy + tz * uz) / size
    if along < 0.0:
        size = -size
    return (tx / size, ty / size, tz / size), abs(along)


@called
def _gap_of_others(
    walls: np.ndarray, one: int, other: int, direction: tuple[float, float, float]
) -> float:
    """Return the least gap to a plane that is approached, besides two of them."""
    least = np.inf
    for k in range(walls.shape[0]):
        w = walls[k, 0] * direction[0] + walls[k, 1] * direction[1] + walls[k, 2] * direction[2]
        if k not in (one, other) and w < -GRAZING:
            least = min(least, walls[k, 3])
    return least

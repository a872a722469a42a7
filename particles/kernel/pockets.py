"""Where bounces do not end: grooves between two spheres and pockets between more of them.

Close to where the spheres of contact (radius 1) of several scatterers meet they are planes, and the
flights of a tracer may shrink geometrically, to infinitely many in a finite length. So after a
flight shorter than `cell_walk.SHORT` the bounces between all spheres within NEAR of contact are
followed to their end, between the planes that touch them there. Where they end after a finite
number, that is left to the event loop, as long as it can resolve them.

Between two planes bounces never end if rho, the normal speed with which the tracer leaves the one
plane over that with which it approaches the other one, is small (`events.lower_rebound`). For
et = 1 it then leaves along the edge with the speed that it has along it: a groove is no trap. For
et < 1 that speed is multiplied by et at each bounce, so it is left at rest: it is trapped. But the
spheres recede by path^2/2, which matters when path (along)/(across) is about 1, a number that each
bounce multiplies by rho^3/r^2: the bounces never end if rho^3 <= r^2.

More planes: the bounces are followed, each groove being left along its edge, until the tracer
leaves, or until its speed has fallen to GRAZING of what tangential friction alone would have left.
Begin reading with `end_of_bounces`.
"""

from math import sqrt

import numpy as np
from numba import njit

from particles.cells import NEAR, SLOTS, Cells, next_listed
from particles.compiled import called, inlined
from particles.events import GRAZING, MOST_STEPS, NEVER, lower_rebound

#: Flights shorter than this, in d, are rounding. The origin of the number is not recorded.
UNRESOLVED = 1e-14
#: Gaps to other planes over the larger one of two planes, from which on the bounces between these
#: two are taken to be alone. The origin of the number is not recorded.
ALONE = 1e3

# How bounces end.
LEAVES = 0  # the tracer leaves
FOR_EVER = 1  # it leaves after infinitely many bounces
RESTS = 2  # it comes to rest

Vector = tuple[float, float, float]


@called
def end_of_bounces(
    cells: Cells,
    cell: int,
    place: Vector,
    direction: Vector,
    law: tuple[float, float],
    path: float,
) -> tuple[Vector, float]:
    """Return (direction, speed ratio) with which a tracer leaves after a very short flight.

    Ratio 0: the tracer is trapped. Direction and speed are unchanged where the event loop is to go
    on.

    Parameters
    ----------
    cells, cell : the scatterers, and the number of the tracer's cell
    place : from the centre of the cell
    direction : after the bounce there
    law : (e, et), et > e
    path : length of the flight in d
    """
    walls = _touching_planes(cells, cell, place)
    if walls.shape[0] < 2:
        return direction, 1.0
    end, last_direction, ratio = last_bounces(walls, direction, law[0], law[1])
    if end == LEAVES and path > UNRESOLVED:
        return direction, 1.0
    return last_direction, ratio


@inlined
def _touching_planes(cells: Cells, cell: int, place: Vector) -> np.ndarray:
    """Return normals towards a place, and gaps, of the spheres within NEAR of contact, (n, 4)."""
    planes = np.empty((cells.fill[cell], 4))
    n = 0
    slot = 0
    node = cells.head[cell]
    while slot < SLOTS or node >= 0:
        cx, cy, cz, slot, node = next_listed(cells, cell, slot, node)
        dx = place[0] - cx
        dy = place[1] - cy
        dz = place[2] - cz
        distance = sqrt(dx * dx + dy * dy + dz * dz)
        if distance <= 1.0 + NEAR:
            planes[n, 0] = dx / distance
            planes[n, 1] = dy / distance
            planes[n, 2] = dz / distance
            planes[n, 3] = max(distance - 1.0, 0.0)
            n += 1
    return planes[:n]


@njit(error_model="numpy")
def is_endless(cosine: float, rho: float, restitution: float, tangential: float) -> bool:
    """Tell whether a tracer bounces for ever between two spheres; arguments of `lower_rebound`."""
    r = restitution / tangential
    sine2 = (1.0 - cosine) * (1.0 + cosine)
    lower = lower_rebound(cosine, sine2, rho, restitution, tangential)
    return lower < NEVER if tangential == 1.0 else lower**3 <= r * r


@njit(error_model="numpy")
def last_bounces(
    walls: np.ndarray, direction: Vector, restitution: float, tangential: float
) -> tuple[int, Vector, float]:
    """Follow bounces between planes to their end: LEAVES, FOR_EVER (infinitely many) or RESTS.

    Return also the unit direction in the end, and the ratio of the speeds after and before.

    Parameters
    ----------
    walls : normals and gaps, 0 of the plane struck last, shape (n, 4); they are changed
    direction : unit vector
    restitution, tangential : e and et, et > e
    """
    ux, uy, uz = direction
    gap = walls[:, 3]
    last = int(np.argmin(gap))
    ratio = 1.0
    friction = 1.0
    end = LEAVES
    for _ in range(MOST_STEPS):
        u = ux, uy, uz
        struck, path, approach = _next_plane(walls, u)
        if struck < 0:
            return end, u, ratio
        normal = walls[struck, 0], walls[struck, 1], walls[struck, 2]
        last_normal = walls[last, 0], walls[last, 1], walls[last, 2]
        leaving = _along(walls, last, u)
        is_alone = ALONE * max(gap[struck], gap[last]) <= _gap_of_others(walls, last, struck, u)
        if (
            struck != last
            and leaving >= 0.0
            and is_alone
            and is_endless(_dot(normal, last_normal), -leaving / approach, restitution, tangential)
        ):
            end = FOR_EVER
            (ux, uy, uz), along = _along_edge(normal, last_normal, u)
            ratio *= along
            if tangential < 1.0 or along < GRAZING or ratio < GRAZING:
                return RESTS, (ux, uy, uz), 0.0
            gap[struck] = gap[last] = 0.0
            continue
        for k in range(walls.shape[0]):
            gap[k] = max(gap[k] + _along(walls, k, u) * path, 0.0)
        gap[struck] = 0.0
        change = (tangential + restitution) * approach
        ux = tangential * ux - change * normal[0]
        uy = tangential * uy - change * normal[1]
        uz = tangential * uz - change * normal[2]
        speed = sqrt(ux * ux + uy * uy + uz * uz)
        ratio *= speed
        friction *= tangential
        if ratio <= GRAZING * friction:
            return RESTS, (ux, uy, uz), 0.0
        ux = ux / speed
        uy = uy / speed
        uz = uz / speed
        last = struck
    return RESTS, (ux, uy, uz), 0.0


@inlined
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def _along(walls: np.ndarray, k: int, direction: Vector) -> float:
    """Return the component of a direction along the normal of plane k."""
    return walls[k, 0] * direction[0] + walls[k, 1] * direction[1] + walls[k, 2] * direction[2]


@inlined
def _next_plane(walls: np.ndarray, direction: Vector) -> tuple[int, float, float]:
    """Return (plane that is met first, path, component of the direction along its normal).

    The plane is -1 if none is met.
    """
    struck = -1
    path = np.inf
    approach = 0.0
    for k in range(walls.shape[0]):
        along = _along(walls, k, direction)
        gap = walls[k, 3]
        # A sphere recedes by path^2 / 2 from the plane.
        if along < -GRAZING and along * along > 2.0 * gap and gap < -along * path:
            struck = k
            path = -gap / along
            approach = along
    return struck, path, approach


@called
def _along_edge(a: Vector, b: Vector, direction: Vector) -> tuple[Vector, float]:
    """Return (unit vector along the edge of two planes, component of the direction along it).

    a, b: normals of the planes.
    """
    tx = a[1] * b[2] - a[2] * b[1]
    ty = a[2] * b[0] - a[0] * b[2]
    tz = a[0] * b[1] - a[1] * b[0]
    size = sqrt(tx * tx + ty * ty + tz * tz)
    if size == 0.0:
        return direction, 0.0
    along = _dot((tx, ty, tz), direction) / size
    if along < 0.0:
        size = -size
    return (tx / size, ty / size, tz / size), abs(along)


@called
def _gap_of_others(walls: np.ndarray, a: int, b: int, direction: Vector) -> float:
    """Return the least gap to a plane that is approached, besides planes a and b."""
    least = np.inf
    for k in range(walls.shape[0]):
        if k not in (a, b) and _along(walls, k, direction) < -GRAZING:
            least = min(least, walls[k, 3])
    return least

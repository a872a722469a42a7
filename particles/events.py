"""One event of a tracer: where it strikes next, how it moves there, how it leaves.

Lengths are in d, so the centre of the tracer meets a scatterer on a circle of radius 1. The path
among fixed scatterers does not depend on the speed; so a tracer is a place, a unit direction and,
apart from them, an inverse speed: the rescaling of the paper's section 2 with the speed kept. The
collision law stands in `_rebound` and `bounce` alone. Begin reading with `contact` and `scatter`.
"""

from math import copysign, frexp, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from particles.compiled import inlined
from particles.impact import NODES_PER_OCTAVE

#: A contact whose normal velocity is below this fraction of the speed does not count as a
#: collision. Chosen: otherwise a tracer that slides off a scatterer (restitution 0) could meet it
#: again by rounding. Only contacts that would enter the scatterer by less than 1e-18 d are left
#: out.
GRAZING = 1e-9
#: A time, or a path, that stands for infinity. Chosen: its square root, and products of it with
#: numbers of a run, still are finite.
NEVER = 1e300
#: Steps of an iteration that mostly ends after a few; more are taken for infinitely many. The
#: origin of the number is not recorded.
MOST_STEPS = 10_000


class Varying(NamedTuple):
    """A restitution that depends on the impact speed, and sticking (`particles.impact`).

    Parameters
    ----------
    lowest : octave of the lowest impact speed of the table
    values : e at the nodes of `impact.tabulate` from 2^lowest on, shape (n,); n = 1: constant
    capture : impact speed below which a tracer sticks
    slowest : e of bounces that never end, 1 where they would stick
    """

    lowest: int
    values: np.ndarray
    capture: float
    slowest: float


@inlined
def restitution_at(varying: Varying, speed: float) -> float:
    """Return the restitution at an impact speed."""
    values = varying.values
    last = values.size - 1
    if last == 0 or not speed > 0.0:
        return float(values[0])
    fraction, exponent = frexp(speed)
    place = (2.0 * fraction - 1.0 + (exponent - 1 - varying.lowest)) * NODES_PER_OCTAVE
    if place <= 0.0:
        return float(values[0])
    if place >= last:
        return float(values[last])
    node = int(place)
    return float(values[node] + (place - node) * (values[node + 1] - values[node]))


@njit(inline="always", error_model="numpy")
def contact(dx: float, dy: float, ux: float, uy: float) -> tuple[float, float]:
    """Return (path to contact, impact parameter) with a scatterer at (dx, dy) from the tracer.

    The path is NEVER where the unit direction (ux, uy) misses it, and may be negative by rounding
    for a tracer that touches two scatterers. The impact parameter is signed.
    """
    along = dx * ux + dy * uy
    impact = dx * uy - dy * ux
    square = (1.0 - impact) * (1.0 + impact)
    if along > GRAZING and square > 0.0:
        return along - sqrt(square), impact
    return NEVER, impact


@njit(inline="always", error_model="numpy")
def contact_in_space(dx: float, dy: float, dz: float, ux: float, uy: float, uz: float) -> float:
    """Return the path to contact with a scatterer at (dx, dy, dz) from the tracer, or NEVER."""
    along = dx * ux + dy * uy + dz * uz
    px = dx - along * ux
    py = dy - along * uy
    pz = dz - along * uz
    square = 1.0 - (px * px + py * py + pz * pz)
    if along > GRAZING and square > 0.0:
        return along - sqrt(square)
    return NEVER


@njit(inline="always", error_model="numpy")
def touch(cx: float, cy: float, ux: float, uy: float, impact: float) -> tuple[float, float]:
    """Return the place of contact on the circle around (cx, cy), exact to rounding."""
    depth = sqrt((1.0 - impact) * (1.0 + impact))
    return cx - depth * ux - impact * uy, cy - depth * uy + impact * ux


@njit(inline="always", error_model="numpy")
def _rebound(
    a: float, b: float, square: float, restitution: float, tangential: float
) -> tuple[float, float]:
    """Return (component of the new velocity along the old one, speed ratio), old speed 1.

    The impact parameter is y with y^2 = a b and 1 - y^2 = square = q^2. The normal component of the
    velocity is multiplied by -e and the tangential one by et, so the first result is
    -e + (e + et) y^2, and the square of the second is e^2 q^2 + et^2 y^2. Either is written in y
    alone if et >= e, so that no term cancels; the ratio is exactly 1 at e = et = 1.
    """
    if tangential >= restitution:
        gain = tangential * tangential - restitution * restitution
        ratio = sqrt(restitution * restitution + gain * a * b)
        along = (tangential + restitution) * a * b - restitution
    else:
        gain = restitution * restitution - tangential * tangential
        ratio = sqrt(tangential * tangential + gain * square)
        along = tangential * a * b - restitution * square
    return along, ratio


@njit(inline="always", error_model="numpy")
def scatter(
    ux: float, uy: float, impact: float, restitution: float, tangential: float
) -> tuple[float, float, float]:
    """Return (new ux, new uy, speed ratio) after a collision in the plane.

    With the normal s = -(q u + y w), w = (uy, -ux), y the impact parameter and q = sqrt(1 - y^2),
    the new velocity is (-e + (e + et) y^2) u - (e + et) q y w. A head-on collision at e = 0 has
    ratio 0 and keeps (ux, uy).
    """
    square = (1.0 - impact) * (1.0 + impact)
    depth = sqrt(square)
    along, ratio = _rebound(impact, impact, square, restitution, tangential)
    if ratio == 0.0:
        return ux, uy, 0.0
    scale = 1.0 / ratio
    along *= scale
    across = (tangential + restitution) * depth * impact * scale
    vx = along * ux - across * uy
    vy = along * uy + across * ux
    # One Newton step on the norm: rounding of a million collisions does not add up.
    scale = 1.5 - 0.5 * (vx * vx + vy * vy)
    return vx * scale, vy * scale, ratio


@njit(inline="always", error_model="numpy")
def bounce(
    vx: float, vy: float, nx: float, ny: float, law: tuple[float, float]
) -> tuple[float, float, float]:
    """Return (new velocity, its normal component) after a collision in the plane.

    (nx, ny): the unit normal towards the tracer. law: (e, et). In this form normal components far
    smaller than the speed keep their digits. One that is not towards the scatterer counts as 0.
    """
    restitution, tangential = law
    approach = -min(vx * nx + vy * ny, 0.0)
    change = (tangential + restitution) * approach
    new_vx = tangential * vx + change * nx
    new_vy = tangential * vy + change * ny
    return new_vx, new_vy, restitution * approach


@njit(inline="always", error_model="numpy")
def turned(
    direction: tuple[float, float, float], along: float, a: float, b: float
) -> tuple[float, float, float]:
    """Return along u + a p + b r, where p and r are two unit vectors across the direction u.

    They depend on u alone (Duff et al., J. Computer Graphics Techniques 6, 1, 2017).
    """
    ux, uy, uz = direction
    sign = copysign(1.0, uz)
    tilt = -1.0 / (sign + uz)
    mixed = ux * uy * tilt
    return (
        along * ux + a * (1.0 + sign * ux * ux * tilt) + b * mixed,
        along * uy + a * sign * mixed + b * (sign + uy * uy * tilt),
        along * uz - a * sign * ux - b * uy,
    )


@njit(inline="always", error_model="numpy")
def _unit(vx: float, vy: float, vz: float) -> tuple[float, float, float]:
    """Return a unit vector exact to rounding of one that nearly is: one Newton step on the norm."""
    scale = 1.5 - 0.5 * (vx * vx + vy * vy + vz * vz)
    return vx * scale, vy * scale, vz * scale


@njit(inline="always", error_model="numpy")
def scatter_in_space(
    direction: tuple[float, float, float],
    impact: tuple[float, float],
    restitution: float,
    tangential: float,
) -> tuple[tuple[float, float, float], float]:
    """Return (new unit direction, speed ratio) after a collision in three dimensions.

    impact (a, b): the impact parameter as a vector y = a p + b r (`turned`). With the normal
    s = -(q u + y), q = sqrt(1 - y^2), the new velocity is (-e + (e + et) y^2) u - (e + et) q y. A
    head-on collision at e = 0 has ratio 0 and keeps u.
    """
    a, b = impact
    y2 = a * a + b * b
    square = 1.0 - y2
    along, ratio = _rebound(y2, 1.0, square, restitution, tangential)
    if ratio == 0.0:
        return direction, 0.0
    scale = 1.0 / ratio
    across = -(tangential + restitution) * sqrt(square) * scale
    vx, vy, vz = turned(direction, along * scale, a * across, b * across)
    return _unit(vx, vy, vz), ratio


@njit(inline="always", error_model="numpy")
def bounce_in_space(
    offset: tuple[float, float, float],
    direction: tuple[float, float, float],
    restitution: float,
    tangential: float,
) -> tuple[tuple[float, float, float], tuple[float, float, float], float]:
    """Return (normal at contact, new unit direction, speed ratio) of a flight that ends in contact.

    offset: from the tracer to the scatterer, where the flight begins. With the impact parameter as
    a vector y across the direction u, and q = sqrt(1 - y^2), the normal is -(q u + y), exact to
    rounding, and the new velocity is that of `scatter_in_space`.
    """
    dx, dy, dz = offset
    ux, uy, uz = direction
    along = dx * ux + dy * uy + dz * uz
    px = dx - along * ux
    py = dy - along * uy
    pz = dz - along * uz
    y2 = px * px + py * py + pz * pz
    square = 1.0 - y2
    depth = sqrt(square)
    normal = (-(depth * ux + px), -(depth * uy + py), -(depth * uz + pz))
    along_old, ratio = _rebound(y2, 1.0, square, restitution, tangential)
    if ratio == 0.0:
        return normal, direction, 0.0
    scale = 1.0 / ratio
    along_old *= scale
    across = -(tangential + restitution) * depth * scale
    vx = along_old * ux + across * px
    vy = along_old * uy + across * py
    vz = along_old * uz + across * pz
    return normal, _unit(vx, vy, vz), ratio


@njit(error_model="numpy")
def lower_rebound(
    cosine: float, sine2: float, rho: float, restitution: float, tangential: float
) -> float:
    """Return what rho tends to in the bounces between two planes, NEVER if they do not go on.

    cosine: of the angle of their normals; sine2: the square of its sine. rho: the normal speed with
    which a tracer leaves the one plane over that with which it approaches the other one. With
    C = -cosine and r = e/et a bounce makes

        rho' = r / ((1 + r) C - rho),     fixed points rho^2 - (1 + r) C rho + r = 0.

    They are real if C >= 2 sqrt(r)/(1 + r); the upper one repels, so for r < 1 path and speed
    shrink geometrically for ever if rho is below it.
    """
    r = restitution / tangential
    middle = -0.5 * (1.0 + r) * cosine
    square = 0.25 * ((1.0 - r) * (1.0 - r) - (1.0 + r) * (1.0 + r) * sine2)
    if restitution >= tangential or middle <= 0.0 or square < 0.0:
        return NEVER
    upper = middle + sqrt(square)
    return r / upper if rho < upper else NEVER


@njit(error_model="numpy")
def is_collapsing(
    previous_normal: tuple[float, float],
    normal: tuple[float, float],
    direction: tuple[float, float],
    restitution: float,
    tangential: float,
) -> bool:
    """Tell whether a tracer between two straight walls collides infinitely often from now on.

    Parameters
    ----------
    previous_normal : of the wall before, a unit vector
    normal : of the wall that the tracer leaves
    direction : in which it leaves, a unit vector
    restitution, tangential : e and et
    """
    ax, ay = previous_normal
    bx, by = normal
    ux, uy = direction
    approach = -(ux * ax + uy * ay)
    sine = ax * by - ay * bx
    cosine = ax * bx + ay * by
    if approach <= 0.0:
        return False
    rho = (ux * bx + uy * by) / approach
    return lower_rebound(cosine, sine * sine, rho, restitution, tangential) < NEVER

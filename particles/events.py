"""One event of a tracer: where it strikes next, how it moves there, how it leaves.

Lengths are in d, so the centre of the tracer meets a scatterer on a circle of radius 1.
The path of a tracer among fixed scatterers does not depend on its speed; so a tracer is a place,
a unit direction and, apart from them, an inverse speed. This is the rescaling of the paper's
section 2 with the speed kept.
"""

from math import sqrt

from numba import njit

# A collision whose normal velocity is below this fraction of the speed is none. It keeps a tracer
# that slides off a scatterer (restitution 0) from meeting it again through rounding; what is lost
# is a grazing contact that would enter the scatterer by less than 1e-18 d.
GRAZING = 1e-9
NEVER = 1e300


@njit(inline="always", error_model="numpy")
def contact(dx: float, dy: float, ux: float, uy: float) -> tuple[float, float]:
    """Return (path to contact, impact parameter) with a scatterer at (dx, dy) from the tracer.

    The path is NEVER where the unit direction (ux, uy) misses it. It may be negative by rounding
    for a tracer that touches two scatterers at once. The impact parameter is signed, in d.
    """
    along = dx * ux + dy * uy
    impact = dx * uy - dy * ux
    square = (1.0 - impact) * (1.0 + impact)
    if along > GRAZING and square > 0.0:
        return along - sqrt(square), impact
    return NEVER, impact


@njit(inline="always", error_model="numpy")
def touch(cx: float, cy: float, ux: float, uy: float, impact: float) -> tuple[float, float]:
    """Return the place of contact on the circle around (cx, cy), exact to rounding."""
    depth = sqrt((1.0 - impact) * (1.0 + impact))
    return cx - depth * ux - impact * uy, cy - depth * uy + impact * ux


@njit(inline="always", error_model="numpy")
def scatter(ux: float, uy: float, impact: float, restitution: float) -> tuple[float, float, float]:
    """Return (new ux, new uy, speed ratio) after a collision: v' = v - (1 + e)(v.s) s.

    With s = -(q u + y w), w = (uy, -ux), y the impact parameter and q = sqrt(1 - y^2), the new
    velocity is (-e + (1 + e) y^2) u - (1 + e) q y w. Written so, no term cancels at e = 0 or 1;
    the ratio is exactly 1 at e = 1. A head-on collision at e = 0 has ratio 0 and keeps (ux, uy).
    """
    ratio = sqrt(restitution * restitution + (1.0 - restitution * restitution) * impact * impact)
    if ratio == 0.0:
        return ux, uy, 0.0
    depth = sqrt((1.0 - impact) * (1.0 + impact))
    scale = 1.0 / ratio
    along = ((1.0 + restitution) * impact * impact - restitution) * scale
    across = (1.0 + restitution) * depth * impact * scale
    vx = along * ux - across * uy
    vy = along * uy + across * ux
    # One Newton step on the norm: rounding of a million collisions does not add up.
    unit = 1.5 - 0.5 * (vx * vx + vy * vy)
    return vx * unit, vy * unit, ratio

"""Corners of two disks that overlap, in a field: how the bounces between the two end.

The bounces are followed one by one; they take no time. Where the velocity falls to SMALL of what it
was the tracer comes to rest. If -g is between the two normals, it is trapped as soon as v^2/2 <
SMALL |g| d; else it slides along the disk that the field lets it slide along, or falls.
"""

from math import sqrt

from particles.cells import NEAR, SLOTS, Cells, next_listed
from particles.compiled import called
from particles.events import MOST_STEPS, bounce, is_collapsing
from particles.kernel.cell_walk import SHORT
from particles.kernel.disk_contact import STRUCK, TANGENT
from particles.kernel.falling import FallingTracer

#: What counts as rest: a height v_n^2/(2 a_n) in d that bounces on a disk reach, a velocity over
#: that at the beginning of the bounces in a corner, and v^2/2 over |g| d in a corner. The origin of
#: the number is not recorded.
SMALL = 1e-12
#: Normal velocity over speed from which on a tracer in a corner approaches a disk: less is
#: rounding.
APPROACHING = 1e-15
#: Speed^2 over |g| SHORT d below which the field bends flights that are shorter than SHORT, so that
#: the event loop follows the bounces in a corner. The origin of the number is not recorded.
BENT_BELOW = 1e3

# How a tracer goes on from a disk.
FALLS = 0  # on its parabola
SLIDES = 1  # along the disk
RESTS = 2  # it stays there


@called
def is_sliding(
    normal: tuple[float, float], velocity: tuple[float, float], leaving: float, field: float
) -> bool:
    """Tell whether a tracer slides along a disk from now on.

    Parameters
    ----------
    normal : unit vector from the disk to the tracer
    velocity : of the tracer
    leaving : its normal component, not negative
    field : acceleration along x
    """
    nx, ny = normal
    vx, vy = velocity
    along = nx * vy - ny * vx
    pressing = -field * nx - along * along
    if leaving * leaving < 2.0 * SMALL * pressing:
        return True
    # Against the field it will be pressed at the next moment.
    return leaving == 0.0 and field * vx < 0.0 and pressing > -SMALL * abs(field)


@called
def _bounce_in_corner(
    tracer: FallingTracer,
    struck_normal: tuple[float, float],
    met_normal: tuple[float, float],
    law: tuple[float, float],
) -> bool:
    """Bounce between the disk struck last and one just met, until that ends.

    Tell whether the last bounce was off the disk just met.
    """
    ax, ay = struck_normal
    bx, by = met_normal
    initial_square = tracer.vx * tracer.vx + tracer.vy * tracer.vy
    is_on_met_disk = True
    for _ in range(MOST_STEPS):
        square = tracer.vx * tracer.vx + tracer.vy * tracer.vy
        if square <= SMALL * SMALL * initial_square:
            tracer.vx = tracer.vy = 0.0
            break
        approaching = -APPROACHING * sqrt(square)
        if tracer.vx * bx + tracer.vy * by < approaching:
            tracer.vx, tracer.vy, _normal_velocity = bounce(tracer.vx, tracer.vy, bx, by, law)
            is_on_met_disk = True
        elif tracer.vx * ax + tracer.vy * ay < approaching:
            tracer.vx, tracer.vy, _normal_velocity = bounce(tracer.vx, tracer.vy, ax, ay, law)
            is_on_met_disk = False
        else:
            break
        tracer.collisions += 1
    return is_on_met_disk


@called
def _slides_out(
    tracer: FallingTracer,
    on_normal: tuple[float, float],
    off_normal: tuple[float, float],
    field: float,
) -> bool:
    """Tell whether a tracer in a corner slides along one disk, away from the other one."""
    onx, ony = on_normal
    offx, offy = off_normal
    along = onx * tracer.vy - ony * tracer.vx
    if tracer.vx * tracer.vx + tracer.vy * tracer.vy == 0.0:
        along = -field * ony
    is_free = along * (onx * offy - ony * offx) >= 0.0
    leaving = max(tracer.vx * onx + tracer.vy * ony, 0.0)
    return is_free and is_sliding(on_normal, (tracer.vx, tracer.vy), leaving, field)


@called
def settle_in_corner(
    tracer: FallingTracer, met_x: float, met_y: float, law: tuple[float, float], field: float
) -> int:
    """Let a tracer that is on its disk meet another one, at (met_x, met_y), in their corner.

    Return FALLS, SLIDES or RESTS; the tracer is then on the disk that this is about.
    """
    sx = tracer.x - tracer.struck_x
    sy = tracer.y - tracer.struck_y
    mx = tracer.x - met_x
    my = tracer.y - met_y
    per = 1.0 / sqrt(mx * mx + my * my)
    mx = mx * per
    my = my * per
    struck_normal = sx, sy
    met_normal = mx, my
    is_on_met_disk = _bounce_in_corner(tracer, struck_normal, met_normal, law)
    square = tracer.vx * tracer.vx + tracer.vy * tracer.vy
    # -g is between the normals if it is alpha s + beta m, both positive: by Cramer's rule.
    turn = field * (sx * my - sy * mx)
    is_held = sy * turn > 0.0 > my * turn
    motion = FALLS
    if square <= 2.0 * SMALL * abs(field) and is_held:
        motion = RESTS
    else:
        on_struck = _slides_out(tracer, struck_normal, met_normal, field)
        on_met = _slides_out(tracer, met_normal, struck_normal, field)
        if on_struck or on_met:
            motion = SLIDES
            # Where both are possible, on the disk of the last bounce.
            is_on_met_disk = on_met and (is_on_met_disk or not on_struck)
    tracer.normal_x, tracer.normal_y = struck_normal
    if is_on_met_disk:
        tracer.struck_x = met_x
        tracer.struck_y = met_y
        tracer.x = met_x + mx
        tracer.y = met_y + my
        tracer.normal_x, tracer.normal_y = met_normal
    leaving = tracer.vx * tracer.normal_x + tracer.vy * tracer.normal_y
    tracer.touches = STRUCK if leaving > 0.0 else TANGENT
    return motion


@called
def after_short_flight(
    tracer: FallingTracer,
    previous_normal: tuple[float, float],
    cells: Cells,
    law: tuple[float, float],
    field: float,
) -> int:
    """End bounces in a corner that without the field would never end: FALLS, SLIDES or RESTS."""
    square = tracer.vx * tracer.vx + tracer.vy * tracer.vy
    if square <= abs(field) * BENT_BELOW * SHORT:
        return FALLS
    per = 1.0 / sqrt(square)
    direction = tracer.vx * per, tracer.vy * per
    normal = tracer.normal_x, tracer.normal_y
    if not is_collapsing(previous_normal, normal, direction, law[0], law[1]):
        return FALLS
    other_x, other_y, distance = _other_disk(tracer, cells)
    if distance == 1.0 + NEAR:
        return FALLS
    tracer.vx = tracer.vy = 0.0
    return settle_in_corner(tracer, other_x, other_y, law, field)


@called
def _other_disk(tracer: FallingTracer, cells: Cells) -> tuple[float, float, float]:
    """Return the centre of the nearest disk but that struck, and its distance, 1 + NEAR if none."""
    other_x = 0.0
    other_y = 0.0
    distance = 1.0 + NEAR
    slot = 0
    node = cells.head[tracer.cell]
    while slot < SLOTS or node >= 0:
        cx, cy, _cz, slot, node = next_listed(cells, tracer.cell, slot, node)
        dx = tracer.x - cx
        dy = tracer.y - cy
        from_struck = max(abs(cx - tracer.struck_x), abs(cy - tracer.struck_y))
        if from_struck > SHORT and dx * dx + dy * dy < distance * distance:
            other_x = cx
            other_y = cy
            distance = sqrt(dx * dx + dy * dy)
    return other_x, other_y, distance

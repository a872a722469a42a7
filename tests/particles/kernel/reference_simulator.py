"""A slow, obvious simulator: one tracer, all disks, all images, in as many digits as asked for.

It shares nothing with the package: velocities are vectors with their speed in them, a contact is
the smaller root of a quadratic equation, a collision is v' = et v - (et + e)(v.s)s with s the unit
vector from the disk to the tracer. Every disk and every image within reach is tried.
"""

from typing import Any

import mpmath as mp


def follow(
    disks: Any, box: float | None, velocity: Any, law: tuple[float, float], collisions: int,
    digits: int,
) -> list[tuple[Any, ...]]:  # fmt: skip
    """Return (time, x, y, vx, vy, disk) after each collision of a tracer that starts at (0, 0).

    law: (restitution, tangential restitution).
    """
    with mp.workdps(digits):
        centres = [(mp.mpf(float(x)), mp.mpf(float(y))) for x, y in disks]
        x, y, t = mp.mpf(0), mp.mpf(0), mp.mpf(0)
        vx, vy = mp.mpf(float(velocity[0])), mp.mpf(float(velocity[1]))
        events = []
        last = None
        for _ in range(collisions):
            first = None
            for k, (cx, cy) in enumerate(centres):
                for mx, my in _images(box, cx, cy, x, y):
                    if (k, mx, my) == last:
                        continue
                    dx, dy = cx + mx - x, cy + my - y
                    a = vx * vx + vy * vy
                    b = dx * vx + dy * vy
                    c = dx * dx + dy * dy - 1
                    inside = b * b - a * c
                    if b <= 0 or inside <= 0:
                        continue
                    s = (b - mp.sqrt(inside)) / a
                    if first is None or s < first[0]:
                        first = (s, k, mx, my)
            assert first is not None, "the reference met nothing within its images"
            s, k, mx, my = first
            x, y, t = x + s * vx, y + s * vy, t + s
            nx, ny = x - centres[k][0] - mx, y - centres[k][1] - my
            norm = mp.sqrt(nx * nx + ny * ny)
            nx, ny = nx / norm, ny / norm
            normal = vx * nx + vy * ny
            e, et = (mp.mpf(number) for number in law)
            vx = et * vx - (et + e) * normal * nx
            vy = et * vy - (et + e) * normal * ny
            last = (k, mx, my)
            events.append((t, x, y, vx, vy, k))
        return events


def _images(box: float | None, cx: Any, cy: Any, x: Any, y: Any) -> list[tuple[Any, Any]]:
    """Return the shifts that bring a disk into the 3 by 3 boxes around the tracer."""
    if box is None:
        return [(mp.mpf(0), mp.mpf(0))]
    side = mp.mpf(box)
    i, j = mp.nint((x - cx) / side), mp.nint((y - cy) / side)
    return [((i + di) * side, (j + dj) * side) for di in (-1, 0, 1) for dj in (-1, 0, 1)]

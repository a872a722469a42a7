"""A slow, obvious simulator: one tracer, all scatterers and images, in as many digits as asked for.

It shares nothing with the package: velocities are vectors with their speed in them, a contact is
the smaller root of a quadratic equation, a collision is v' = et v - (et + e)(v.s)s with s the unit
vector from the scatterer to the tracer. Every scatterer and every image within reach is tried. In
the plane or in space, as the velocity says.
"""

from itertools import product
from typing import Any

import mpmath as mp


def follow(
    scatterers: Any, box: float | None, velocity: Any, law: tuple[float, float], collisions: int,
    digits: int,
) -> list[tuple[Any, ...]]:  # fmt: skip
    """Return (time, *place, *velocity, scatterer) after each collision of a tracer from the origin.

    law: (restitution, tangential restitution). Without a box the list ends when nothing is met.
    """
    with mp.workdps(digits):
        centres = [[mp.mpf(float(c)) for c in centre] for centre in scatterers]
        v = [mp.mpf(float(c)) for c in velocity]
        x, t = [mp.mpf(0)] * len(v), mp.mpf(0)
        e, et = (mp.mpf(number) for number in law)
        events = []
        last = None
        for _ in range(collisions):
            a = dot(v, v)
            first = None
            for k, centre in enumerate(centres):
                for image in _images(box, centre, x):
                    if (k, image) == last:
                        continue
                    d = [c - p for c, p in zip(image, x, strict=True)]
                    b = dot(d, v)
                    inside = b * b - a * (dot(d, d) - 1)
                    if b <= 0 or inside <= 0:
                        continue
                    s = (b - mp.sqrt(inside)) / a
                    if first is None or s < first[0]:
                        first = (s, k, image)
            if first is None:
                assert box is None, "the reference met nothing within its images"
                break
            s, k, image = first
            x, t = [p + s * c for p, c in zip(x, v, strict=True)], t + s
            normal = [p - c for p, c in zip(x, image, strict=True)]
            size = mp.sqrt(dot(normal, normal))
            normal = [c / size for c in normal]
            change = (et + e) * dot(v, normal)
            v = [et * c - change * n for c, n in zip(v, normal, strict=True)]
            last = (k, image)
            events.append((t, *x, *v, k))
        return events


def dot(a: Any, b: Any) -> Any:
    """Return the scalar product."""
    return sum(p * q for p, q in zip(a, b, strict=True))


def _images(box: float | None, centre: list[Any], place: list[Any]) -> list[tuple[Any, ...]]:
    """Return a scatterer's images in the 3 by 3 (by 3) boxes around the tracer."""
    if box is None:
        return [tuple(centre)]
    side = mp.mpf(box)
    near = [mp.nint((p - c) / side) for p, c in zip(place, centre, strict=True)]
    return [
        tuple(c + (n + m) * side for c, n, m in zip(centre, near, moved, strict=True))
        for moved in product((-1, 0, 1), repeat=len(centre))
    ]

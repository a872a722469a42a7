"""The steps of a tracer that knows no more of the plane than its last collisions taught it.

It keeps the scatterers of its last k collisions and the flights that led to them. On a flight it
meets new scatterers at random, as in the Boltzmann-Grad limit: at exponential distances with
impact parameters that are uniform. Two things differ. A scatterer that it keeps stops the flight if
it comes first. And a new scatterer is left out if it would overlap one of the flights that it
keeps, where there was none. With k = 0 this is the Boltzmann-Grad limit. As long as nothing has
been forgotten it is a Poisson medium, exactly: in the area that was never seen the scatterers are
a Poisson process whatever has been seen elsewhere, and leaving points out thins it.

`known` (k, 4) of a tracer has the latest collision in its first row: the scatterer, and where the
flight to it began, both from the present place.
"""

from math import log, sqrt
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined
from particles.events import NEVER, contact, is_collapsing, scatter, touch
from particles.kernel.in_plane import SHORT
from particles.kernel.lane import Start
from particles.streams import FLIGHTS, open_stream, uniform

# The draws of one flight are numbered from its own multiple of this number on.
_DRAWS = 2**20


@inlined
def open_flights(lane: Any, start: Start, tracer: int) -> None:
    """Open the stream of random flights of a tracer."""
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + tracer
    )


@inlined
def _is_seen(known: np.ndarray, n: int, x: float, y: float) -> bool:
    """Tell whether a scatterer at (x, y) from the present place would overlap a known flight."""
    end_x = end_y = 0.0
    seen = False
    for j in range(n):
        begin_x, begin_y = known[j, 2], known[j, 3]
        along_x, along_y = end_x - begin_x, end_y - begin_y
        square = along_x * along_x + along_y * along_y
        share = 0.0
        if square > 0.0:
            share = ((x - begin_x) * along_x + (y - begin_y) * along_y) / square
            share = min(max(share, 0.0), 1.0)
        dx, dy = x - begin_x - share * along_x, y - begin_y - share * along_y
        seen = seen or dx * dx + dy * dy < 1.0
        end_x, end_y = begin_x, begin_y
    return seen


@inlined
def next_contact(lane: Any, known: np.ndarray, mean_path: float) -> None:
    """Find the scatterer that a tracer meets next, one that it knows or a new one."""
    ux, uy = lane.ux, lane.uy
    n = min(lane.collisions, known.shape[0])
    path, cx, cy = NEVER, 0.0, 0.0
    for j in range(n):
        s, _ = contact(known[j, 0], known[j, 1], ux, uy)
        if s < path:
            path, cx, cy = s, known[j, 0], known[j, 1]
    draw = _DRAWS * lane.collisions
    at = 0.0
    while True:
        at -= mean_path * log(uniform(lane.stream, lane.gamma, draw))
        if at >= path:
            break
        impact = 2.0 * uniform(lane.stream, lane.gamma, draw + 1) - 1.0
        draw += 2
        ahead = at + sqrt((1.0 - impact) * (1.0 + impact))
        x, y = ahead * ux + impact * uy, ahead * uy - impact * ux
        if not _is_seen(known, n, x, y):
            path, cx, cy = at, x, y
            break
    lane.contact, lane.struck_x, lane.struck_y = max(path, 0.0), cx, cy


@inlined
def collide(lane: Any, known: np.ndarray, law: tuple[float, float]) -> tuple[float, bool]:
    """Bounce off the scatterer that was met and remember it; the next flight begins there.

    law: restitution and tangential restitution. Return the ratio of the speeds after and before,
    and whether the tracer is trapped from now on.
    """
    cx, cy, restitution, tangential = lane.struck_x, lane.struck_y, law[0], law[1]
    impact = cx * lane.uy - cy * lane.ux
    x, y = touch(cx, cy, lane.ux, lane.uy, impact)
    lane.ux, lane.uy, ratio = scatter(lane.ux, lane.uy, impact, restitution, tangential)
    nx, ny = x - cx, y - cy
    trapped = ratio == 0.0
    if lane.contact < SHORT and not trapped:
        before = lane.normal_x, lane.normal_y
        trapped = is_collapsing(before, (nx, ny), (lane.ux, lane.uy), restitution, tangential)
    lane.normal_x, lane.normal_y = nx, ny
    k = known.shape[0]
    for j in range(min(lane.collisions, k - 1), 0, -1):
        known[j, 0], known[j, 1] = known[j - 1, 0] - x, known[j - 1, 1] - y
        known[j, 2], known[j, 3] = known[j - 1, 2] - x, known[j - 1, 3] - y
    if k:
        known[0, 0], known[0, 1], known[0, 2], known[0, 3] = -nx, -ny, -x, -y
    lane.flight_x += x
    lane.flight_y += y
    lane.collisions += 1
    return ratio, trapped

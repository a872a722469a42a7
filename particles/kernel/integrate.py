"""The event loops that end a tracer by its path: what `particles.along_path` is made from.

They are the loops of `follow` and of `free_paths` without output times and records, and use the
same steps.
"""

from typing import Any

import numpy as np

from particles.compiled.decorators import inlined, kernel
from particles.grid.cells import Cells
from particles.kernel import last_collisions, steps
from particles.kernel.in_plane import SHORT
from particles.kernel.lane import Start
from particles.kernel.windows import CAUGHT, HITS, Windows, add_flight, begin_windows


@inlined
def _end(lane: Any, trapped: bool, windows: Windows) -> None:
    """Count what a tracer has met until its end."""
    windows.totals[HITS] += lane.collisions
    windows.totals[CAUGHT] += int(trapped)


@kernel
def integrate_among(
    start: Start, cells: Cells, limit: float, lanes: np.ndarray, windows: Windows
) -> None:
    """Follow tracers among the scatterers of one configuration to the end of their windows.

    limit: longest flight in d; the windows of a tracer are not longer than this together. lanes: of
    LANE_OF[dimension], as many as shall be under way at the same time.
    """
    # Taken out of their tuples once, as in `follow`.
    keys, slots, head, links, nodes = cells.keys, cells.slots, cells.head, cells.links, cells.nodes
    side, n = cells.side, cells.n
    law = (start.restitution, start.tangential)
    active = launched = min(lanes.size, start.n)
    for a in range(active):
        begin_windows(lanes[a], start, windows, a)
        steps.begin(lanes[a], cells)
    while active:
        for a in range(active):
            lane = lanes[a]
            if steps.lacks_cell(lane, keys):
                steps.make_cell(lane, keys, cells)
            steps.next_contact(lane, slots, head, links, nodes)
        a = 0
        while a < active:
            lane = lanes[a]
            wall = steps.next_wall(lane)
            if lane.contact > wall and wall <= limit:
                steps.cross_cell(lane, keys, n)
                a += 1
                continue
            path = limit if lane.contact > wall else max(lane.contact, 0.0)
            ended, trapped = add_flight(lane, path, windows), False
            if not ended:
                ratio, trapped = steps.collide(lane, path, side, law)
                lane.slowness /= ratio
                if path < SHORT and not trapped:
                    ratio, trapped = steps.end_bounces(lane, path, cells, law)
                    lane.slowness /= ratio
            if not (ended or trapped):
                a += 1
                continue
            _end(lane, trapped, windows)
            if launched < start.n:
                begin_windows(lane, start, windows, launched)
                steps.begin(lane, cells)
                launched += 1
                a += 1
            else:
                active -= 1
                lanes[a] = lanes[active]


@kernel
def integrate_remembering(
    start: Start, mean_path: float, known: np.ndarray, lanes: np.ndarray, windows: Windows
) -> None:
    """Follow tracers that remember their last collisions, in the plane.

    mean_path: the mean free path in d without memory. known (k, 4): working memory; k = 0 is the
    Boltzmann-Grad limit. lanes: one, of LANE_OF[2].
    """
    lane = lanes[0]
    law = (start.restitution, start.tangential)
    for tracer in range(start.n):
        begin_windows(lane, start, windows, tracer)
        last_collisions.open_flights(lane, start, tracer)
        ended = trapped = False
        while not (ended or trapped):
            last_collisions.next_contact(lane, known, mean_path)
            ended = add_flight(lane, lane.contact, windows)
            if not ended:
                ratio, trapped = last_collisions.collide(lane, known, law)
                lane.slowness /= ratio
        _end(lane, trapped, windows)

"""Blocks of the unbounded plane, drawn when a tracer enters them."""

from collections.abc import Iterator
from math import floor

import numpy as np
from numba import int64, njit
from numba.extending import overload

from particles.compiled.decorators import called, kernel
from particles.compiled.search import SLOTS, crowd
from particles.grid.cells import BLOCK, EMPTY, WINDOW, Cells, enlist
from particles.grid.plane import (
    Counts,
    Law,
    begin,
    count,
    is_clear,
    is_kept,
    mark,
    open_region,
    spot,
    width,
)

_ACROSS = 2**BLOCK
_CELLS = _ACROSS * _ACROSS
# A cell lists what is no farther than this from it: a little more than 1, against rounding.
_REACH = 1.0 + 1e-9
# Columns of a draft, one row for each candidate: place from the corner of the block, when its turn
# comes, 1 while it is kept, and its region relative to the block's core.
_X, _Y, _TURN, _KEPT, _P, _Q = range(6)


@njit(error_model="numpy", inline="always")
def place(i: int, j: int) -> int:
    """Return where the window stores cell (i, j); blocks less than its width apart differ."""
    inside, within = 2**WINDOW - 1, 2**BLOCK - 1
    block = (((i >> BLOCK) & inside) << WINDOW) | ((j >> BLOCK) & inside)
    return (((block << BLOCK) | (i & within)) << BLOCK) | (j & within)


def is_unbounded(keys: np.ndarray) -> bool:
    """Tell a plane's keys from a box's by their type: known when a kernel is compiled."""
    return keys.dtype == np.int64


@overload(is_unbounded, inline="always")
def _compiled_is_unbounded(keys):  # type: ignore[no-untyped-def]
    if keys.dtype == int64:
        return lambda keys: True
    return lambda keys: False


def is_missing(keys: np.ndarray, cell: int, i: int, j: int) -> bool:
    """Tell whether the window lacks cell (i, j) in its place. A box lacks none."""
    block = cell >> 2 * BLOCK
    return is_unbounded(keys) and (keys[block, 0] != i >> BLOCK or keys[block, 1] != j >> BLOCK)


@overload(is_missing, inline="always")
def _compiled_is_missing(keys, cell, i, j):  # type: ignore[no-untyped-def]
    if keys.dtype == int64:
        return lambda keys, cell, i, j: (
            keys[cell >> 2 * BLOCK, 0] != i >> BLOCK or keys[cell >> 2 * BLOCK, 1] != j >> BLOCK
        )
    return lambda keys, cell, i, j: False


def supply(keys: np.ndarray, cells: Cells, cell: int, i: int, j: int) -> None:
    """Make the block of cell (i, j) of a plane; nothing is compiled for a box.

    To be called only after `is_missing`: if the test were in here, numba would count references to
    `cells` at every step of the event loop, which was 5 times slower.
    """
    make(cells, cell, i, j)


@overload(supply, inline="always")
def _compiled_supply(keys, cells, cell, i, j):  # type: ignore[no-untyped-def]
    if keys.dtype == int64:
        return lambda keys, cells, cell, i, j: make(cells, cell, i, j)
    return lambda keys, cells, cell, i, j: None


@njit(error_model="numpy")
def make(cells: Cells, cell: int, i: int, j: int) -> None:
    """Make the block of cell (i, j) where the window stores it; `cell` is where that cell goes."""
    law, keys, slots, fill, head = cells.law, cells.keys, cells.slots, cells.fill, cells.head
    draft, who = cells.draft, cells.who
    block = cell >> 2 * BLOCK
    first = block << 2 * BLOCK
    i, j = i >> BLOCK, j >> BLOCK
    keys[block, 0], keys[block, 1] = i, j
    for c in range(first, first + _CELLS):
        fill[c] = 0
        head[c] = -1
        for k in range(2 * SLOTS):
            slots[c, k] = EMPTY
    drawn, fringe = _draw(law, cells.counts, draft, i, j)
    side = law.side / _ACROSS
    per_side = 1.0 / side
    last = _ACROSS - 1
    spare = block * (cells.links.size >> 2 * WINDOW)
    for k in range(drawn):
        x, y = draft[k, _X], draft[k, _Y]
        a0, a1 = max(floor((x - _REACH) * per_side), 0), min(floor((x + _REACH) * per_side), last)
        b0, b1 = max(floor((y - _REACH) * per_side), 0), min(floor((y + _REACH) * per_side), last)
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                within = a * _ACROSS + b
                if law.hard and fill[first + within] < SLOTS:
                    who[within, fill[first + within]] = k
                own_x, own_y = x - (a + 0.5) * side, y - (b + 0.5) * side
                spare = enlist(cells, first + within, own_x, own_y, spare)
    if law.hard:
        n_pairs = _pair_all(cells, drawn, fringe, first)
        _settle(cells, n_pairs, first, i, j)


@kernel
def make_cell(cells: Cells, i: int, j: int) -> int:
    """Make one cell of the plane, for Python; return where it is stored."""
    cell = place(i, j)
    make(cells, cell, i, j)
    return cell


def listed(cells: Cells, cell: int) -> Iterator[tuple[float, float]]:
    """Yield the disks that a cell lists, from its centre."""
    row = cells.slots[cell]
    for k in range(SLOTS):
        if row[k] != EMPTY:
            yield float(row[k]), float(row[SLOTS + k])
    node = cells.head[cell]
    while node >= 0:
        if cells.nodes[node, 0] != EMPTY:
            yield float(cells.nodes[node, 0]), float(cells.nodes[node, 1])
        node = cells.links[node]


@called
def _draw(law: Law, counts: Counts, draft: np.ndarray, i: int, j: int) -> tuple[int, int]:
    """Draw the candidates in and around block (i, j).

    Those that a cell of the block can list begin the draft, those farther out end it; return the
    numbers of both.
    """
    near = abs(i) <= 1 and abs(j) <= 1
    drawn, fringe = 0, 0
    for dp in range(-1, 2):
        p = 2 * i + dp
        ox, wide = begin(law, p), width(law, p)
        if dp < 0:
            ox -= law.side
        for dq in range(-1, 2):
            q = 2 * j + dq
            oy, high = begin(law, q), width(law, q)
            if dq < 0:
                oy -= law.side
            state, gamma = open_region(law, p, q)
            for k in range(count(counts, p, q, state)):
                x, y = spot(state, gamma, k)
                x *= wide
                y *= high
                if near and not is_clear(law, p, q, x, y):
                    continue
                x += ox
                y += oy
                row = drawn
                if law.hard:
                    if min(x, y) < -_REACH or max(x, y) > law.side + _REACH:
                        fringe += 1
                        row = draft.shape[0] - fringe
                        drawn -= 1
                    draft[row, _TURN] = mark(state, gamma, k)
                    draft[row, _KEPT] = 1.0
                    draft[row, _P], draft[row, _Q] = dp, dq
                draft[row, _X], draft[row, _Y] = x, y
                drawn += 1
    return drawn, fringe


@called
def _pair_all(cells: Cells, drawn: int, fringe: int, first: int) -> int:
    """Find the pairs of candidates that are nearer to each other than 1; return their number.

    Some pairs come twice. Each is an earlier and a later candidate, and the pairs are in the order
    of the later one's turn. A candidate of the fringe comes only as the earlier one of a pair: no
    cell of this block lists it, so whether it is kept matters only where it excludes another.
    """
    law, slots, head, links, nodes = cells.law, cells.slots, cells.head, cells.links, cells.nodes
    draft, pairs, who = cells.draft, cells.pairs, cells.who
    side = law.side / _ACROSS
    per_side = 1.0 / side
    last = _ACROSS - 1
    n_pairs = 0
    for k in range(drawn):
        x, y = draft[k, _X], draft[k, _Y]
        a = min(max(floor(x * per_side), 0), last)
        b = min(max(floor(y * per_side), 0), last)
        home = a * _ACROSS + b
        x -= (a + 0.5) * side
        y -= (b + 0.5) * side
        near = crowd(slots, first + home, x, y)
        if near & (near - 1):  # more than one bit: another candidate besides itself
            for slot in range(SLOTS):
                if near >> slot & 1 and who[home, slot] < k:
                    n_pairs = _pair(draft, pairs, n_pairs, k, who[home, slot])
        node = head[first + home]
        while node >= 0:
            dx, dy = nodes[node, 0] - x, nodes[node, 1] - y
            node = links[node]
            if dx * dx + dy * dy < 1.0:
                # Rare. A chain does not say which candidate a node is, so compare with all.
                for other in range(drawn):
                    dx, dy = draft[other, _X] - draft[k, _X], draft[other, _Y] - draft[k, _Y]
                    if dx * dx + dy * dy < 1.0 and other != k:
                        n_pairs = _pair(draft, pairs, n_pairs, k, other)
                break
        if min(draft[k, _X], draft[k, _Y]) < 0.0 or max(draft[k, _X], draft[k, _Y]) > law.side:
            for other in range(draft.shape[0] - fringe, draft.shape[0]):
                dx, dy = draft[other, _X] - draft[k, _X], draft[other, _Y] - draft[k, _Y]
                if dx * dx + dy * dy < 1.0 and draft[other, _TURN] < draft[k, _TURN]:
                    n_pairs = _pair(draft, pairs, n_pairs, k, other)
    return n_pairs


@called
def _pair(draft: np.ndarray, pairs: np.ndarray, n_pairs: int, one: int, other: int) -> int:
    """Insert a pair in the order of the later one's turn; return the number of pairs."""
    earlier, later = one, other
    if draft[other, _TURN] < draft[one, _TURN]:
        earlier, later = other, one
    at = n_pairs
    while at > 0 and draft[pairs[at - 1, 1], _TURN] > draft[later, _TURN]:
        pairs[at, 0], pairs[at, 1] = pairs[at - 1, 0], pairs[at - 1, 1]
        at -= 1
    pairs[at, 0], pairs[at, 1] = earlier, later
    return n_pairs + 1


@called
def _settle(cells: Cells, n_pairs: int, first: int, i: int, j: int) -> None:
    """Go through the pairs in order; refuse each later candidate whose earlier one is kept."""
    law, counts, draft, pairs = cells.law, cells.counts, cells.draft, cells.pairs
    side = law.side / _ACROSS
    for m in range(n_pairs):
        earlier, later = pairs[m, 0], pairs[m, 1]
        if draft[later, _KEPT] == 0.0:
            continue
        x, y = draft[earlier, _X], draft[earlier, _Y]
        if min(x, y) < -_REACH or max(x, y) > law.side + _REACH:
            dp, dq = int(draft[earlier, _P]), int(draft[earlier, _Q])
            p, q = 2 * i + dp, 2 * j + dq
            x -= begin(law, p) - (law.side if dp < 0 else 0.0)
            y -= begin(law, q) - (law.side if dq < 0 else 0.0)
            kept = is_kept(law, counts, (p, q), x, y, draft[earlier, _TURN])
        else:
            kept = draft[earlier, _KEPT] == 1.0
        if not kept:
            continue
        draft[later, _KEPT] = 0.0
        x, y = draft[later, _X], draft[later, _Y]
        a0, a1 = max(floor((x - _REACH) / side), 0), min(floor((x + _REACH) / side), _ACROSS - 1)
        b0, b1 = max(floor((y - _REACH) / side), 0), min(floor((y + _REACH) / side), _ACROSS - 1)
        for a in range(a0, a1 + 1):
            for b in range(b0, b1 + 1):
                own_x, own_y = x - (a + 0.5) * side, y - (b + 0.5) * side
                _remove(cells, first + a * _ACROSS + b, own_x, own_y)


@called
def _remove(cells: Cells, cell: int, x: float, y: float) -> None:
    """Remove the scatterer at exactly (x, y) from a cell that may list it; its slot stays free."""
    slots, links, nodes = cells.slots, cells.links, cells.nodes
    for k in range(SLOTS):
        if slots[cell, k] == x and slots[cell, SLOTS + k] == y:
            slots[cell, k] = slots[cell, SLOTS + k] = EMPTY
    node = cells.head[cell]
    while node >= 0:
        if nodes[node, 0] == x and nodes[node, 1] == y:
            nodes[node, 0] = nodes[node, 1] = EMPTY
        node = links[node]

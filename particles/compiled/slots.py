"""The eight slots of a cell, searched one after another: what is struck first, and what is near.

These loops run as they stand in the interpreter. Compiled kernels have them from
`particles.compiled.search`, which puts `particles.compiled.vectors` in their place where it can.
"""

import numpy as np

from particles.events import NEVER, contact, contact_in_space

SLOTS = 8


def strike(
    slots: np.ndarray, cell: int, x: float, y: float, ux: float, uy: float
) -> tuple[float, int]:
    """Return (path to contact, slot) of the first scatterer met in a cell; NEVER if none.

    slots (n_cells, 2 * SLOTS): x of each slot, then y, in d. Of equal paths the lowest slot counts.
    """
    path, found = NEVER, 0
    for slot in range(SLOTS):
        s, _ = contact(slots[cell, slot] - x, slots[cell, SLOTS + slot] - y, ux, uy)
        if s < path:
            path, found = s, slot
    return path, found


def crowd(slots: np.ndarray, cell: int, x: float, y: float) -> int:
    """Return which slots of a cell are nearer than 1 to (x, y), one bit each."""
    mask = 0
    for slot in range(SLOTS):
        dx, dy = slots[cell, slot] - x, slots[cell, SLOTS + slot] - y
        mask |= int(dx * dx + dy * dy < 1.0) << slot
    return mask


def near_chord(
    slots: np.ndarray, cell: int, place: tuple[float, float], chord: tuple[float, float],
    reach2: float,
) -> int:  # fmt: skip
    """Return which slots of a cell are near a chord, one bit each.

    chord: vector from `place` to its end. reach2: square of the distance up to which they count.
    """
    (x, y), (ex, ey) = place, chord
    per = 1.0 / max(ex * ex + ey * ey, 1e-300)
    mask = 0
    for slot in range(SLOTS):
        dx, dy = slots[cell, slot] - x, slots[cell, SLOTS + slot] - y
        part = (dx * ex + dy * ey) * per
        part = part if part > 0.0 else 0.0
        part = part if part < 1.0 else 1.0
        px, py = dx - part * ex, dy - part * ey
        mask |= int(px * px + py * py <= reach2) << slot
    return mask


def strike_in_space(
    slots: np.ndarray, cell: int, place: tuple[float, float, float],
    direction: tuple[float, float, float],
) -> tuple[float, int]:  # fmt: skip
    """As `strike`, in three dimensions. slots (n_cells, 3 * SLOTS): x of each slot, then y, z."""
    x, y, z = place
    ux, uy, uz = direction
    path, found = NEVER, 0
    for slot in range(SLOTS):
        dx, dy = slots[cell, slot] - x, slots[cell, SLOTS + slot] - y
        s = contact_in_space(dx, dy, slots[cell, 2 * SLOTS + slot] - z, ux, uy, uz)
        if s < path:
            path, found = s, slot
    return path, found

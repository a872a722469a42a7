"""The search of a cell in LLVM's instructions has the bits of plain loops."""

import numpy as np
import pytest
from numba import njit

from particles.cells import SLOTS, near_chord, strike
from particles.events import NEVER, contact, contact_in_space

CELLS = 3000


@njit
def found(cells, k, place, direction):  # type: ignore[no-untyped-def]
    return strike(cells, k, place, direction)


@njit
def near(cells, k, place, chord, reach2):  # type: ignore[no-untyped-def]
    return near_chord(cells, k, place, chord, reach2)


def many_cells(dimension: int) -> np.ndarray:
    """Return cells with some slots free, some struck at equal paths, some grazed."""
    rng = np.random.default_rng(8)
    cells = rng.uniform(-2.5, 2.5, (CELLS, dimension, SLOTS))
    cells[(rng.random((CELLS, SLOTS)) < 0.3)[:, None].repeat(dimension, axis=1)] = 1e150
    cells[:600, :, 3] = cells[:600, :, 1]  # the same scatterer twice
    # Mirror images about the x-axis, which tracers follow below; and tangents to it.
    cells[600:1200, :, 3] = cells[600:1200, :, 1]
    cells[600:1200, 1, 3] *= -1.0
    cells[1200:1500, 1, 2] = 1.0
    return cells.reshape(CELLS, -1)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_struck_first(dimension: int) -> None:
    cells, struck = many_cells(dimension), 0
    directions = np.random.default_rng(9).normal(size=(CELLS, dimension))
    directions[:1500] = np.eye(dimension)[0]
    place = (0.0, 0.0) if dimension == 2 else (0.1, -0.2, 0.3)
    for k, u in enumerate(directions):
        direction = tuple((u / np.linalg.norm(u)).tolist())
        path, slot = NEVER, 0
        for n in range(SLOTS):
            offset = [cells[k, a * SLOTS + n] - place[a] for a in range(dimension)]
            if dimension == 2:
                s = contact(*offset, *direction)[0]
            else:
                s = contact_in_space(*offset, *direction)
            if s < path:
                path, slot = s, n
        assert found(cells, k, place, direction) == (path, slot)
        struck += path < NEVER
    assert struck > 800


def test_what_is_near_a_chord() -> None:
    cells = many_cells(2)
    rng = np.random.default_rng(3)
    masks = 0
    for k in range(CELLS):
        (x, y), (ex, ey), reach2 = *rng.normal(size=(2, 2)), rng.uniform(0.2, 3.0)
        if k < 9:
            ex = ey = 0.0
        per, mask = 1.0 / max(ex * ex + ey * ey, 1e-300), 0
        for n in range(SLOTS):
            dx, dy = cells[k, n] - x, cells[k, SLOTS + n] - y
            part = min(max((dx * ex + dy * ey) * per, 0.0), 1.0)
            px, py = dx - part * ex, dy - part * ey
            mask |= int(px * px + py * py <= reach2) << n
        assert near(cells, k, (x, y), (ex, ey), reach2) == mask
        masks += mask > 0
    assert masks > 500

"""Answers do not depend on how disks lie in the cells of the index."""

from typing import Any

import numpy as np
import pytest

import particles


def flight(disks: Any, side: float, velocity: Any, times: Any) -> Any:
    """Elastic flight from the origin among disks and their images: places at the times."""
    place, v, clock = np.zeros(2), np.array(velocity), 0.0
    out = []
    for t in times:
        while True:
            apart = disks - place
            # those near enough for the time that is left, as images around the tracer
            shifts = side * np.stack(np.meshgrid([-2, -1, 0, 1, 2], [-2, -1, 0, 1, 2]), -1)
            apart = (apart - side * np.round(apart / side))[:, None] + shifts.reshape(1, -1, 2)
            apart = apart.reshape(-1, 2)
            along = apart @ v
            impact = apart[:, 0] * v[1] - apart[:, 1] * v[0]
            square = (1.0 - impact) * (1.0 + impact)
            hit = (along > 1e-9) & (square > 0.0)
            paths = np.where(hit, along - np.sqrt(np.where(hit, square, 0.0)), np.inf)
            k = int(np.argmin(paths))
            if clock + paths[k] > t:
                place, clock = place + v * (t - clock), t
                break
            place, clock = place + v * paths[k], clock + paths[k]
            normal = apart[k] - v * paths[k]
            v = v - 2.0 * (v @ normal) * normal
        out.append(place)
    return np.array(out)


@pytest.mark.parametrize("cells", [3, 5, 7])
def test_disks_on_corners_walls_and_centres_of_cells(cells: int) -> None:
    """Against flights that know of no index. The tracers start where one disk is left out."""
    spacing = 7.2  # d; at this density a cell is twice as wide
    side = 2 * cells * spacing
    x, y = np.meshgrid(*(spacing * np.arange(-cells, cells),) * 2)
    disks = np.stack([x.ravel(), y.ravel()], axis=1)
    disks = disks[np.any(disks != 0.0, axis=1)]  # from the centre of the cell in the middle
    angles = np.linspace(0.1, 6.0, 40)
    velocity = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    times = np.array([15.0, 30.0])
    middle = 0.5 * side
    found = particles.simulate(
        particles.Positions(disks + middle, box_side=side, start=(middle, middle)), 1.0,
        initial=velocity, times=times, media=1, tracers=40, workers=1, observables=("positions",),
    )  # fmt: skip
    expected = np.stack([flight(disks, side, v, times) for v in velocity], axis=1)
    # each collision makes an error of rounding some ten times larger
    np.testing.assert_allclose(found.positions, expected, atol=1e-7, rtol=0.0)

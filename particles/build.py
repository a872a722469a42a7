"""From a medium to the indexed scatterers of one configuration."""

import numpy as np

from particles.cells import Cells, empty_box
from particles.media import BoltzmannGrad, Medium
from particles.placement import place_at_random


def build(medium: Medium, seed: np.uint64, configuration: int) -> Cells | None:
    """Return the scatterers of one configuration, or None where the medium has none.

    Raises ValueError if the disks do not all find room.
    """
    if isinstance(medium, BoltzmannGrad):
        return None
    d = medium.diameter
    cells = empty_box(medium.box / d, medium.number_density * d * d, medium.count)
    placed = place_at_random(cells, medium.count, medium.overlapping, seed, configuration)
    if placed < medium.count:
        raise ValueError(
            f"number_density = {medium.number_density}: only {placed} of {medium.count} disks "
            f"could be placed; the largest density reached is "
            f"{medium.number_density * placed / medium.count:.3g}"
        )
    return cells

"""From a medium to the indexed scatterers of one configuration."""

import numpy as np

from particles.grid.cells import Cells, empty_box, plane
from particles.grid.placement import place_at_random, place_given
from particles.media import BoltzmannGrad, HardDisks, Medium, Positions


def build(
    medium: Medium, seed: np.uint64, configuration: int, old: Cells | None = None
) -> Cells | None:
    """Return the scatterers of one configuration, or None where the medium has none.

    Tracers start at the centre of the middle cell. old: scatterers that are no longer needed and
    whose memory may be used again. Raises ValueError if not all disks can be placed.
    """
    if isinstance(medium, BoltzmannGrad):
        return None
    d = medium.diameter
    density = medium.number_density * d * d
    if isinstance(medium, Positions):
        own = medium.positions if medium.positions.ndim == 2 else medium.positions[configuration]
        return _place(own / d, np.array(medium.start) / d, medium.box_side / d)
    if medium.box is None:
        return plane(density, not medium.overlapping, seed, configuration, old)
    side = medium.box_side / d
    cells = empty_box(side, density, medium.count, medium.listed)
    placed = place_at_random(cells, medium.count, medium.overlapping, seed, configuration)
    if placed < medium.count:
        raise ValueError(
            f"number_density = {medium.number_density}: only {placed} of {medium.count} disks "
            f"could be placed; the largest density reached is "
            f"{medium.number_density * placed / medium.count:.3g}"
        )
    if isinstance(medium, HardDisks) and medium.equilibrate:
        from particles.grid.equilibrate import equilibrate

        positions = equilibrate(cells, medium.count, medium.equilibrate, seed, configuration)
        return _place(positions, np.zeros(2), side)
    return cells


def _place(positions: np.ndarray, start: np.ndarray, box: float) -> Cells:
    cells = empty_box(box, len(positions) / box**2, len(positions))
    place_given(cells, positions, start)
    return cells

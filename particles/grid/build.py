"""From a medium to the indexed scatterers of one configuration."""

import numpy as np

from particles.grid.cells import Cells, empty_box, plane
from particles.grid.placement import place_at_random, place_given
from particles.grid.plane import cells_key
from particles.grid.space import boxed, unbounded
from particles.grid.spheres import place_spheres
from particles.media import (
    BoltzmannGrad,
    HardDisks,
    HardSpheres,
    Medium,
    Poisson,
    PoissonSpheres,
    Positions,
)


def build(
    medium: Medium, seed: np.uint64, configuration: int, old: Cells | None = None
) -> Cells | None:
    """Return the scatterers of one configuration, or None where the medium has none.

    Tracers start at the centre of the middle cell. old: scatterers that are no longer needed and
    whose memory may be used again. Raises ValueError if not all scatterers can be placed.
    """
    if isinstance(medium, BoltzmannGrad):
        return None
    if isinstance(medium, (HardSpheres, PoissonSpheres)):
        return _build_in_space(medium, seed, configuration, old)
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
    _require_all(medium, placed)
    if isinstance(medium, HardDisks) and medium.equilibrate:
        from particles.grid.equilibrate import equilibrate

        positions = equilibrate(cells, medium.count, medium.equilibrate, seed, configuration)
        return _place(positions, np.zeros(2), side)
    return cells


def _build_in_space(
    medium: HardSpheres | PoissonSpheres, seed: np.uint64, configuration: int, old: Cells | None
) -> Cells:
    if medium.count is None:
        density = medium.number_density * medium.diameter**3
        return unbounded(density, cells_key(seed, configuration), old)
    return boxed(positions_in_space(medium, seed, configuration), medium.box_side / medium.diameter)


def positions_in_space(
    medium: HardSpheres | PoissonSpheres, seed: np.uint64, configuration: int
) -> np.ndarray:
    """Return the spheres of a box (count, 3), from its middle, in d."""
    sweeps = medium.equilibrate if isinstance(medium, HardSpheres) else 0
    overlapping = isinstance(medium, PoissonSpheres)
    assert medium.count is not None
    positions, placed = place_spheres(
        medium.box_side / medium.diameter, medium.count, overlapping, sweeps, seed, configuration
    )
    _require_all(medium, placed)
    return positions


def _require_all(medium: HardDisks | Poisson | HardSpheres | PoissonSpheres, placed: int) -> None:
    """Raise ValueError if fewer scatterers could be placed than were asked for."""
    if medium.count is not None and placed < medium.count:
        what = "disks" if medium.dimension == 2 else "spheres"
        raise ValueError(
            f"number_density = {medium.number_density}: only {placed} of {medium.count} {what} "
            f"could be placed; the largest density reached is "
            f"{medium.number_density * placed / medium.count:.3g}"
        )


def _place(positions: np.ndarray, start: np.ndarray, box: float) -> Cells:
    cells = empty_box(box, len(positions) / box**2, len(positions))
    place_given(cells, positions, start)
    return cells

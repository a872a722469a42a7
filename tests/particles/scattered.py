"""Where the scatterers of a run stand, for tests that look at them from outside."""

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from particles.placement import placed


def places(medium: Any, seed: int = 1, configuration: int = 0) -> np.ndarray:
    """Return the scatterers of a configuration from the start, (count, dimension), in d."""
    return placed(medium, np.uint64(seed), configuration)[1][:, : medium.dimension]


class Around:
    """Finds the scatterers that are nearest to places, in a box with d = 1."""

    def __init__(self, medium: Any, seed: int = 1, configuration: int = 0) -> None:
        self.box = medium.box_side
        inside = (places(medium, seed, configuration) + self.box / 2) % self.box
        self.tree = cKDTree(inside, boxsize=self.box)

    def nearest(self, where: np.ndarray, k: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Return distances and numbers of the k nearest scatterers."""
        return self.tree.query((where + self.box / 2) % self.box, k=k)

    def offset(self, where: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        """Return the vectors from these scatterers to places."""
        apart = where + self.box / 2 - self.tree.data[numbers]
        return np.asarray(apart - self.box * np.round(apart / self.box))

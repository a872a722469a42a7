"""G(R) of a start whose speed density begins with a step and has no other kink."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from kinetics import Scene, SpeedDensity, solve
from kinetics.numerics import FloatArray


@dataclass(frozen=True, eq=False)
class KinkAtItsBeginning(SpeedDensity):
    """A density that names the step at its lowest speed, and goes on beyond it."""

    @property
    def kinks(self) -> FloatArray:  # type: ignore[override]
        """The speed of the step."""
        return np.array([0.5])


def cut_gaussian(v: FloatArray) -> FloatArray:
    return np.where(v > 0.5, v * np.exp((0.25 - v**2) / 2.0), 0.0)


def test_a_density_may_go_on_beyond_its_last_kink() -> None:
    """The mean square of r is that of the averages, within the tolerance of G(R)."""
    scene = Scene(
        0.7,
        0.04,
        times=[100.0],
        initial=KinkAtItsBeginning(cut_gaussian),
        outputs=("position_density", "msd"),
    )
    solution = solve(scene, rtol=1e-2)
    fractions = solution.position_fraction([0.0, 1e4])
    assert fractions[0, 0] == pytest.approx(1.0, abs=1e-2)

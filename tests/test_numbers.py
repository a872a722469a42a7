"""One rule for numbers in all packages: real numbers and NumPy's, no text and no booleans."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from kinetics import CollisionLaw, ScalingSolution, Scene, solve_field, solve_scaled
from particles import BoltzmannGrad, simulate


def ended(e: Any) -> Any:
    run = simulate(BoltzmannGrad(0.04), e, times=np.arange(1, 3), media=np.int8(2), tracers=2)
    return run.restitution


DOORS: dict[str, Callable[[Any], Any]] = {
    "law": lambda e: CollisionLaw(e).restitution,
    "scene": lambda e: Scene(e, times=[1.0]).restitution,
    "scaled": lambda e: solve_scaled(e).restitution,
    "closed form": lambda e: ScalingSolution(e).restitution,
    "field": lambda e: solve_field(e, rtol=1e-3).restitution,
    "particles": ended,
    "medium": lambda e: BoltzmannGrad(e).number_density,
}


class Broken:
    """Its repr fails."""

    def __repr__(self) -> str:
        raise RuntimeError


@pytest.mark.parametrize("value", [np.float32(0.5), np.float64(0.5), Fraction(1, 2)])
@pytest.mark.parametrize("door", DOORS)
def test_real_numbers_are_taken(door: str, value: Any) -> None:
    assert DOORS[door](value) == 0.5


@pytest.mark.parametrize("value", ["0.5", b"0.5", True, np.True_, 0.5 + 0j, None, [0.5], Broken()])
@pytest.mark.parametrize("door", DOORS)
def test_what_is_no_real_number_is_one_line(door: str, value: Any) -> None:
    with pytest.raises(ValueError, match=r"restitution|number_density") as caught:
        DOORS[door](value)
    assert "\n" not in str(caught.value)

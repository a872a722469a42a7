"""What density solvers give: plain data that can be compared, pickled and read at any speed."""

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, Gaussian, Monoenergetic, SpeedTable
from kinetics.densities.conservative import solve_conservative
from kinetics.densities.harmonic import HarmonicProblem, Profile, elastic_profile
from kinetics.densities.spectral import solve_spectral

TIMES, LATE = np.array([0.0, 1.0, 20.0]), np.array([1.0, 1e12])
TABLE = SpeedTable([0.5, 1.0, 2.0], [0.0, 4.0 / 3.0, 0.0])


def asked(e: float, start: Any, m: int = 0, times: Any = TIMES) -> HarmonicProblem:
    return HarmonicProblem(CollisionLaw(e), 1.0, start, m, times, 1e-3)


PROFILES: dict[str, Callable[[], Profile | None]] = {
    "spectral": lambda: solve_spectral(asked(0.6, Gaussian())),
    "spectral, complex": lambda: solve_spectral(asked(0.6, Beam(0.4, Gaussian()), 1)),
    "with the scaling state": lambda: solve_spectral(asked(0.6, Gaussian(), 0, LATE)),
    "conservative": lambda: solve_conservative(asked(0.6, TABLE)),
    "with a peak": lambda: solve_conservative(asked(0.6, Monoenergetic())),
    "elastic": lambda: elastic_profile(asked(1.0, TABLE)),
    "elastic peak": lambda: elastic_profile(asked(1.0, Beam(0.4), 1)),
}


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_are_plain_data(name: str) -> None:
    found = PROFILES[name]()
    assert found is not None
    assert found == PROFILES[name]()
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert hash(again) == hash(found)
    assert len(repr(found)) < 800
    v = np.geomspace(0.01, 3.0, 30)
    assert np.array_equal(again.continuous(v), found.continuous(v))
    assert found.continuous(v).shape == (found.count, 30)

"""What density solvers give: plain data that can be compared, pickled and read at any speed."""

import pickle
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, Gaussian, Monoenergetic, SpeedTable
from kinetics.densities.conservative import NodeMasses, solve_conservative

from kinetics.densities.spectral import GridDensity
from kinetics.densities.harmonic import HarmonicProblem, Profile, ThenScaling, ElasticDensity, elastic_profile
from kinetics.densities.spectral import solve_spectral

LAW, TIMES = CollisionLaw(0.6), np.array([0.0, 1.0, 20.0])
LATE = np.array([1.0, 1e12])
TABLE = SpeedTable([0.5, 1.0, 2.0], [0.0, 4.0 / 3.0, 0.0])

PROFILES: dict[str, tuple[Callable[[], Profile | None], type]] = {
    "spectral": (
        lambda: solve_spectral(HarmonicProblem(LAW, 1.0, Gaussian(), 0, TIMES, 1e-6)),
        GridDensity,
    ),
    "spectral, complex": (
        lambda: solve_spectral(HarmonicProblem(LAW, 1.0, Beam(0.4, Gaussian()), 1, TIMES, 1e-6)),
        GridDensity,
    ),
    "with the scaling state": (
        lambda: solve_spectral(HarmonicProblem(LAW, 1.0, Gaussian(), 0, LATE, 1e-6)),
        ThenScaling,
    ),
    "conservative": (
        lambda: solve_conservative(HarmonicProblem(LAW, 1.0, TABLE, 0, TIMES, 1e-3)),
        NodeMasses,
    ),
    "with a peak": (
        lambda: solve_conservative(HarmonicProblem(LAW, 1.0, Monoenergetic(), 0, TIMES, 1e-3)),
        NodeMasses,
    ),
    "elastic": (
        lambda: elastic_profile(HarmonicProblem(CollisionLaw(1.0), 1.0, TABLE, 0, TIMES, 1e-6)),
        ElasticDensity,
    ),
    "elastic peak": (
        lambda: elastic_profile(HarmonicProblem(CollisionLaw(1.0), 1.0, Beam(0.4), 1, TIMES, 1e-6)),
        ElasticDensity,
    ),
}


def leaves(value: Any) -> Iterator[Any]:
    """All that a value is made of, through dataclasses, tuples and arrays."""
    if is_dataclass(value):
        for f in fields(value):
            if f.init:
                yield from leaves(getattr(value, f.name))
    elif isinstance(value, tuple):
        for item in value:
            yield from leaves(item)
    else:
        yield value


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_are_plain_data(name: str) -> None:
    make, kind = PROFILES[name]
    found = make()
    assert found is not None
    assert isinstance(found.density, kind)
    for leaf in leaves(found):
        assert isinstance(leaf, np.ndarray | int | float | str | None), leaf
        if isinstance(leaf, np.ndarray):
            assert not leaf.flags.writeable
    assert found == make()
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert hash(again) == hash(found)
    assert len(repr(found)) < 600
    assert len(repr(found).splitlines()) == 1
    v = np.geomspace(0.01, 3.0, 30)
    assert np.array_equal(again.continuous(v), found.continuous(v))
    assert found.continuous(v).shape == (found.count, 30)
    assert not any(leaf.flags.writeable for leaf in leaves(again) if isinstance(leaf, np.ndarray))


def test_another_accuracy_is_another_profile() -> None:
    assert solve_spectral(HarmonicProblem(LAW, 1.0, Gaussian(), 0, TIMES, 1e-6)) != solve_spectral(
        HarmonicProblem(LAW, 1.0, Gaussian(), 0, TIMES, 1e-4)
    )

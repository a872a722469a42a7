"""Media and runs of particles: an Ensemble that accounts for every tracer, or a refusal."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing import (
    broken,
    examples,
    extremes,
    fuzz,
    geometric,
    mostly,
    restitutions,
    result_or_refusal,
)
from hypothesis import strategies as st

from particles import BoltzmannGrad, Ensemble, HardDisks, Poisson, Positions, simulate

_density = mostly(geometric(0.01, 0.3), extremes() | broken())
_diameter = mostly(st.just(1.0), extremes() | broken())
_count = mostly(st.integers(80, 200), st.integers(-1, 100) | broken())
_box = mostly(st.sampled_from(["periodic", None]))
_place = st.tuples(st.floats(0.0, 10.0), st.floats(0.0, 10.0))
_CLASSES = {
    "HardDisks": HardDisks,
    "Poisson": Poisson,
    "BoltzmannGrad": BoltzmannGrad,
    "Positions": Positions,
}
_MEDIA = {
    "HardDisks": st.tuples(_density, _count, _diameter, _box, mostly(st.integers(0, 1))),
    "Poisson": st.tuples(_density, _count, _diameter, _box),
    "BoltzmannGrad": st.tuples(_density, _diameter),
    "Positions": st.tuples(
        mostly(st.lists(_place, min_size=1, max_size=5)),
        mostly(st.just(10.0), extremes() | broken()),
        _diameter,
        mostly(st.none(), _place | broken()),
    ),
}


@st.composite
def media(draw: Any) -> tuple[Any, tuple[Any, ...]]:
    """A medium's class and its arguments."""
    kind = draw(st.sampled_from(sorted(_MEDIA)))
    return _CLASSES[kind], draw(_MEDIA[kind])


_whole = mostly(st.integers(1, 3))
RUNS = st.fixed_dictionaries(
    {
        "medium": media(),
        "restitution": mostly(restitutions()),
        "initial": mostly(st.sampled_from(["gaussian", "monoenergetic", np.ones((2, 2))])),
        "times": mostly(
            st.lists(geometric(0.01, 30.0), min_size=1, max_size=3, unique=True).map(sorted),
            st.lists(extremes(), min_size=1, max_size=3).map(sorted) | broken(),
        ),
        "media": _whole,
        "tracers": _whole,
        "max_collisions": mostly(st.integers(1, 200)),  # so that every example ends soon
        "seed": mostly(st.integers(0, 2**64)),
        "workers": mostly(st.just(1)),
        "executor": mostly(st.none()),
        "observables": mostly(
            st.none() | st.lists(st.sampled_from(["positions", "msd", "speed_histogram"]))
        ),
        "progress": mostly(st.none()),
        "output": mostly(st.booleans()),
        "resume": st.booleans(),
    }
)


@examples(90)
def test_runs(tries: int) -> None:
    fuzz(check_run, RUNS, tries)


def check_run(asked: dict[str, Any]) -> None:
    kind, arguments = asked["medium"]
    medium = result_or_refusal(kind, *arguments)
    if medium is None:
        return
    with tempfile.TemporaryDirectory() as folder:
        rest = {name: value for name, value in asked.items() if name not in ("medium", "output")}
        path = Path(folder, "run.h5")
        output = asked["output"]
        if isinstance(output, bool):
            output = path if output else None
        ensemble = result_or_refusal(simulate, medium, output=output, **rest)
        if ensemble is None:
            assert list(Path(folder).iterdir()) == []
            return
        _check_ensemble(ensemble, asked)
        assert [p.name for p in Path(folder).iterdir()] == ["run.h5"] * (output == path)
        if output == path:
            assert Ensemble.load(path) == ensemble


def _check_ensemble(ensemble: Ensemble, asked: dict[str, Any]) -> None:
    repr(ensemble)
    ends = ensemble.statuses
    total = ends.finished + ends.collision_cap + ends.trapped + ends.escaped
    assert total == asked["media"] * asked["tracers"]
    assert np.all(ensemble.samples + ensemble.missing == total)
    for name in ("thermal_speed", "msd", "collisions"):
        value = getattr(ensemble, name).value
        assert np.all(np.isfinite(value[ensemble.samples > 0])), (name, value)

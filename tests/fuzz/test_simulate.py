"""Media and runs of particles: an Ensemble that accounts for every tracer, or a refusal."""

import os
import tempfile
from contextlib import chdir
from typing import Any

import numpy as np
from fuzzing import extremes, fuzz, geometric, keeps, mostly, restitutions, tried
from hypothesis import strategies as st

from kinetics.crosscheck.stress_invariants import of_particles
from particles import BoltzmannGrad, Ensemble, HardDisks, Poisson, Positions, simulate

density = mostly(geometric(0.01, 0.3), extremes)
count = mostly(st.integers(80, 200), st.integers(-1, 100))
place = st.tuples(st.floats(0.0, 10.0), st.floats(0.0, 10.0))
media = st.one_of(
    st.tuples(st.just(HardDisks), density, count, mostly([1.0], extremes)),
    st.tuples(st.just(Poisson), density, count, mostly([1.0], extremes)),
    st.tuples(st.just(BoltzmannGrad), density, mostly([1.0], extremes)),
    st.tuples(st.just(Positions), mostly(st.lists(place, min_size=1, max_size=5)),
              mostly([10.0], extremes)),
)  # fmt: skip
whole = mostly(st.integers(1, 3))
RUN = {
    "restitution": restitutions,
    "initial": mostly(["gaussian", "monoenergetic"], st.just(np.ones((2, 2)))),
    "times": mostly(
        st.lists(geometric(0.01, 30.0), min_size=1, max_size=3, unique=True).map(sorted), extremes
    ),
    "media": whole,
    "tracers": whole,
    "max_collisions": mostly(st.integers(1, 200)),  # so that every example ends soon
    "seed": mostly(st.integers(0, 2**64)),
    "workers": mostly([1]),
    "observables": mostly([None, None, ["positions"], ["speed_histogram", "msd"]]),
    "output": mostly([None, "run.h5"]),
    "resume": mostly([False], st.just(True)),
}


@fuzz(40, medium=media, arguments=st.fixed_dictionaries(RUN))
def test_runs(medium: Any, arguments: Any) -> None:
    kind, *described = medium
    made = tried(kind, *described)
    if made is None:
        return
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        run = tried(simulate, made, **arguments)
        if run is None:
            assert os.listdir() == []
            return
        repr(run)
        keeps(of_particles(run))
        if isinstance(arguments["output"], str):
            assert len(os.listdir()) == 1
            assert Ensemble.load(os.listdir()[0]) == run

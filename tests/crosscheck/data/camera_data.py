"""Tracks as cameras and programs give them, made from a run of the simulator."""

from typing import Any

import numpy as np
import pandas as pd

from kinetics.crosscheck.data.reading import read_sample
from kinetics.crosscheck.data.sample import FramePairs, Sample
from particles import simulate

FRAME_TIMES = np.arange(61.0)

Tracks = tuple[np.ndarray, np.ndarray]
"""Places and velocities, (n_times, n, 2) each."""


def simulated_tracks(medium: Any, restitution: float, times: Any, n: int, seed: int) -> Tracks:
    """Displacements and velocities of tracers, each among scatterers of its own."""
    run = simulate(
        medium,
        restitution,
        times=times,
        media=n,
        tracers=1,
        seed=seed,
        workers=1,
        observables=("positions", "velocities"),
    )
    return np.asarray(run.positions), np.asarray(run.velocities)


def table_of(
    place: np.ndarray, velocity: np.ndarray | None = None, times: Any = FRAME_TIMES
) -> Any:
    """A DataFrame with one row for each tracer at each time."""
    n = place.shape[1]
    columns = {
        "time": np.repeat(times, n),
        "tracer": np.tile(np.arange(n), len(times)),
        "x": place[..., 0].ravel(),
        "y": place[..., 1].ravel(),
    }
    if velocity is not None:
        columns |= {"vx": velocity[..., 0].ravel(), "vy": velocity[..., 1].ravel()}
    return pd.DataFrame(columns)


def sample_of(frame: Any, **arguments: Any) -> Sample:
    """The sample of a DataFrame."""
    return read_sample([{name: frame[name] for name in frame}], **arguments)


def pairs_of(sample: Sample) -> FramePairs:
    assert sample.pairs is not None
    return sample.pairs


def mean_squares(sample: Sample) -> np.ndarray:
    """M(s, t) of the pairs of frames of a sample."""
    sums = pairs_of(sample).sums.sum(axis=0)
    return np.asarray(sums[:, 1] / sums[:, 0])


def true_mean_squares(sample: Sample, place: np.ndarray) -> np.ndarray:
    """M(s, t) of places at the times of a sample, over the tracers that are there at both."""
    pairs = pairs_of(sample)
    steps = place[pairs.later] - place[pairs.earlier]
    return np.asarray(np.nanmean(np.sum(steps**2, axis=2), axis=1))

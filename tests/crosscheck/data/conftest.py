"""Tracks of one run among hard disks, whose truth is known."""

import numpy as np
import pytest
from camera_data import FRAME_TIMES, Tracks, simulated_tracks

from particles import HardDisks


@pytest.fixture(scope="session")
def tracks() -> Tracks:
    """Absolute places and velocities of 600 tracers in 61 frames, e = 0.7, n = 0.02."""
    place, velocity = simulated_tracks(HardDisks(0.02, count=2000), 0.7, FRAME_TIMES, 600, seed=11)
    start = np.random.default_rng(3).uniform(0.0, 50.0, (600, 2))
    return place + start, velocity

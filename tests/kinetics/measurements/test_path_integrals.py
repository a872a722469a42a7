"""The average over what memory changes is the average over whole windows, which is far noisier."""

import numpy as np
import pytest

from particles import Poisson, path_integrals
from tests.kinetics.measurements.path_integrals import measured, pairs_at
from tests.kinetics.measurements.returns import kept


@pytest.mark.slow
def test_what_memory_changes_is_what_the_integrals_lack() -> None:
    e, n = 0.5, 0.04
    pairs = pairs_at(e)
    value, error, collisions = measured(e, n, seconds=0.0)  # 1000 paths
    assert collisions > 100_000
    run = path_integrals(
        Poisson(n, 10_000), e, pairs, [30.0], windows=4, settling=15.0, media=100, tracers=100
    )
    missing = 1.0 / np.array([1.0 - kept(e, m, p) for m, p in pairs])
    found, noise = run.integrals.value[-1] - missing, run.integrals.error[-1]
    assert np.all(abs(found - n * value) < 3.5 * np.hypot(noise, n * error))
    assert np.all(n * error < 0.6 * noise)

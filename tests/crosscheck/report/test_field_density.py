"""Tracers in a field among hard disks, as the report reduces them: made-up runs of known truth."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.report.case import Measured
from kinetics.crosscheck.report.field_density import (
    DensityCase,
    captures,
    density_row,
    extrapolated,
    moving_drift,
)
from kinetics.crosscheck.verdicts import Verdict

DENSITY = 0.25  # l = 2 d


def made_up_run() -> Any:
    """Two tracers in each of three configurations fall with the speeds 1, 2 and 3.

    Times are in d/U: 2 of them are a sqrt(l/g). One tracer of the second configuration is trapped
    at the time 3 sqrt(l/g), one of the third before anything is measured.
    """
    times = np.array([1.0, 2.0, 4.0]) * 2.0
    x = np.array([1.0, 2.0, 3.0])[None, :, None] * times[:, None, None] * np.ones((3, 3, 2))
    x[2, 1, 0] = 2.0 * 6.0
    x[:, 2, 1] = 0.5
    statuses = SimpleNamespace(
        trap_tracers=np.array([[1, 0], [2, 1]]), trap_times=np.array([6.0, 0.5])
    )
    return SimpleNamespace(
        times=times, media=3, tracers=2, number_density=DENSITY, statuses=statuses,
        positions=np.stack([x, 0.0 * x], axis=-1).reshape(3, 6, 2),
        arrays={"path_sums": np.array([[20.0, 5.0], [12.0, 5.0], [8.0, 5.0]])},
    )  # fmt: skip


def test_the_drift_is_that_of_tracers_while_they_move() -> None:
    found = moving_drift(made_up_run(), 1.0, 4.0)
    # ways over times, in sqrt(l/g) and l; of the configurations 6 + 6, 4 + 6 and 9
    fallen, elapsed = np.array([6.0, 4.0 + 6.0, 9.0]), np.array([6.0, 2.0 + 3.0, 3.0])
    assert found.value == pytest.approx(fallen.sum() / elapsed.sum())
    without = [fallen[[1, 2]], fallen[[0, 2]], fallen[[0, 1]]]
    times = [elapsed[[1, 2]], elapsed[[0, 2]], elapsed[[0, 1]]]
    ratios = np.array([f.sum() / t.sum() for f, t in zip(without, times, strict=True)])
    assert found.error == pytest.approx(np.sqrt(2 * ratios.var()))


def test_captures_are_counted_on_the_way_of_all_tracers() -> None:
    assert captures(made_up_run()).value == pytest.approx(2 / (40 / 2))


def made_up_case(limit: float = 1.0) -> DensityCase:
    """The drift is `limit` - n ln(1/n)/2 - 2 n, exactly, with errors of 0.01."""
    n = np.array([0.0025, 0.005, 0.01, 0.02, 0.04, 0.08])
    times = np.geomspace(1.0, 50.0, 5)
    share = np.outer(n, times / 50)
    return DensityCase(
        restitution=0.7, densities=n, tracers=1000, groups=50,
        drift=Measured(limit + 0.5 * n * np.log(n) - 2 * n, np.full(n.size, 0.01)),
        path_alone=1 - 0.6 * n, captures=Measured(n**2, 0.1 * n**2), times=times,
        trapped=Measured(share, 0.1 * share),
    )  # fmt: skip


def test_the_drift_is_extrapolated_to_no_density() -> None:
    found = extrapolated(made_up_case())
    assert found.value == pytest.approx(1.0, abs=1e-10)
    assert 0.01 < found.error < 0.03
    assert density_row(made_up_case()).verdict is Verdict.AGREES
    off = density_row(made_up_case(1.0 + 6 * float(found.error)))
    assert off.sigmas == pytest.approx(6.0)
    assert off.verdict is Verdict.DIFFERS

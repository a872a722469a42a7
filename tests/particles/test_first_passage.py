"""When a tracer in a field first reaches a depth, in units of l = g = 1 where not said else."""

import numpy as np
import pytest

from particles import BoltzmannGrad, Poisson, simulate

DISKS = BoltzmannGrad(0.5)


CASES = [(DISKS, 0.8), (BoltzmannGrad(0.1, dimension=3), 0.8), (Poisson(0.1, 1000), 0.8)]
CASES += [(Poisson(0.1, 1000), 0.0)]  # many a tracer slides past the depth


@pytest.mark.parametrize(("medium", "restitution"), CASES)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_first_passage_is_when_the_depth_is_first_reached(
    medium: BoltzmannGrad | Poisson, restitution: float, sign: float
) -> None:
    times = np.linspace(0.0, 12.0, 601)
    run = simulate(
        medium, restitution, times=times, media=2, tracers=100, field=0.6 * sign,
        depth=2.5 * sign, observables=["positions"],
    )  # fmt: skip
    assert run.passage_times.shape == (200,)
    beyond = sign * run.positions[:, :, 0] >= 2.5
    for tracer, passage in enumerate(run.passage_times):
        assert not beyond[times < passage, tracer].any()
        if np.isfinite(passage):
            # On a flight of so little time x is nearly 2.5 just after it.
            after = np.searchsorted(times, passage)
            near = run.positions[max(after - 1, 0) : after + 1, tracer, 0] * sign
            assert near[0] <= 2.5 + 1e-12
            assert np.all(abs(near - 2.5) < 0.2)
    reached = np.isfinite(run.passage_times)
    assert (100 if isinstance(medium, BoltzmannGrad) else 33) < reached.sum() < 200
    np.testing.assert_allclose(
        run.passed.value, (run.passage_times <= times[:, None]).mean(axis=1), rtol=1e-14
    )
    assert np.isinf(run.mean_passage_time.value)
    # One error of a share p of n independent tracers.
    p = run.passed.value[-1]
    assert 0.0 < run.passed.error[-1] < 5 * np.sqrt(p * (1 - p) / 200)
    assert {"passed", "mean_passage_time"} < {*run.outputs}


def test_the_first_passage_of_a_free_fall_and_of_a_long_way() -> None:
    thin = BoltzmannGrad(1e-40, diameter=2.0)
    starts = np.array([[0.0, 0.0], [1.0, 0.3], [-2.0, 1.0]])
    fall = simulate(thin, 0.5, starts, [9.0], media=1, tracers=3, field=2.0, depth=4.0)
    expected = (-starts[:, 0] + np.sqrt(starts[:, 0] ** 2 + 16.0)) / 2.0
    np.testing.assert_allclose(fall.passage_times, expected, rtol=1e-15)
    # Late, the mean grows as the distance over the drift of the table; e = 0.5 in the plane.
    means = []
    for depth in (20.0, 120.0):
        run = simulate(DISKS, 0.5, "rest", [600.0], media=50, tracers=40, field=1.0, depth=depth)
        assert run.passed.value == 1.0
        means.append(run.mean_passage_time)
    slope = (means[1].value - means[0].value) / 100
    error = np.hypot(means[0].error, means[1].error) / 100
    assert error < 0.01 * slope
    assert abs(slope - 1 / 0.617488570787) < 4 * error
    with pytest.raises(AttributeError, match="passages were not asked for"):
        _ = simulate(DISKS, 0.5, times=[1.0], media=2, tracers=2, field=1.0).passage_times

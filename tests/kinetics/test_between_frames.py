"""M(s, t) = <|r(t) - r(s)|^2>, the mean square displacement between two frames."""

import numpy as np
import pytest

from kinetics import InputError, Monoenergetic, Scene, SpeedSamples, solve
from particles import BoltzmannGrad, simulate

TIMES = [0.0, 10.0, 50.0, 200.0, 400.0]
# d^2, dilute, plane, n = 0.04, Gaussian start: by quadrature of the densities of version 0.3 over
# the displacements of single speeds, 3e-9 against <r^2> on the first rows
TABLE = {
    0.4: {
        (0, 1): 104.209192, (0, 2): 578.829885, (0, 4): 1625.638967, (1, 2): 340.82622,
        (1, 4): 1387.676268, (2, 3): 510.223837, (2, 4): 889.165533, (3, 4): 224.272000,
    },
    0.7: {
        (0, 1): 106.598932, (0, 3): 1717.458860, (1, 2): 450.150131, (1, 4): 2156.473222,
        (2, 3): 885.222526, (2, 4): 1550.901603, (3, 4): 506.600576,
    },
    1.0: {(0, 3): 4524.530485, (2, 3): 3349.843513, (2, 4): 8049.218624, (3, 4): 4524.530485},
}  # fmt: skip


@pytest.mark.parametrize("restitution", TABLE)
def test_the_table(restitution: float) -> None:
    squares = solve(Scene(restitution, times=TIMES)).displacement_between_frames()
    for pair, expected in TABLE[restitution].items():
        assert squares[pair] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_from_time_0_it_is_the_mean_square_displacement(dimension: int) -> None:
    scene = Scene(0.6, dimension=dimension, times=TIMES, outputs=("msd",))
    solution = solve(scene)
    squares = solution.displacement_between_frames()
    np.testing.assert_allclose(squares[0, 1:], solution.msd[1:], rtol=1e-6)
    np.testing.assert_array_equal(squares, squares.T)
    np.testing.assert_array_equal(np.diag(squares), 0.0)


def test_elastic_tracers_are_stationary() -> None:
    squares = solve(Scene(1.0, times=TIMES)).displacement_between_frames()
    assert squares[3, 4] == pytest.approx(squares[0, 3], rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("initial", [Monoenergetic(1.5), SpeedSamples([0.5, 1.0, 2.0])])
def test_sharp_starts_agree_with_particles(initial: Monoenergetic | SpeedSamples) -> None:
    times = [0.0, 20.0, 100.0]
    squares = solve(Scene(0.5, times=times, initial=initial)).displacement_between_frames()
    speeds = np.resize(np.atleast_1d(initial.speed), 30_000)
    start = np.stack([speeds, np.zeros(speeds.size)], axis=-1)[:, None]
    run = simulate(
        BoltzmannGrad(0.04), 0.5, initial=start, times=times, media=speeds.size, tracers=1, seed=5,
        observables=("positions",),
    )  # fmt: skip
    place = np.asarray(run.positions)
    moved = np.sum((place[2] - place[1]) ** 2, axis=1)
    error = moved.std() / np.sqrt(moved.size)
    assert abs(moved.mean() - squares[1, 2]) < 4.0 * error


def test_it_is_refused_where_a_tracer_remembers() -> None:
    with pytest.raises(InputError, match="scatterers"):
        solve(Scene(0.7, times=TIMES, scatterers="hard disks")).displacement_between_frames()
    with pytest.raises(InputError, match="field"):
        solve(Scene(0.7, times=TIMES, field=0.1)).displacement_between_frames()

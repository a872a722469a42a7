"""The backward equation: its error estimate, its first guess of nodes, and high moments."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from marking import slow_but

from kinetics import (
    CollisionLaw,
    Gaussian,
    Monoenergetic,
    ScalingSolution,
    Scene,
    SolverStatus,
    SpeedTable,
    ToleranceWarning,
    solve,
)
from kinetics.moments.backward import BackwardEquation
from kinetics.moments.observables import (
    DISPLACEMENT_ALONG_START,
    MEAN_COLLISIONS,
    MSD_SLOPE,
    SQUARED_DISPLACEMENT,
    Observable,
    quartic_displacement,
    speed_power,
)
from kinetics.states.state import State

OBSERVABLES = (
    speed_power(-0.25), speed_power(1.0), speed_power(2.0), speed_power(3.0), speed_power(4.0),
    speed_power(1.0, 1), speed_power(2.0, 2), MEAN_COLLISIONS, DISPLACEMENT_ALONG_START,
    SQUARED_DISPLACEMENT, quartic_displacement(2), MSD_SLOPE,
)  # fmt: skip
RESTITUTIONS = (0.0, 0.15, 0.35, 0.55, 0.7, 0.8, 0.92, 0.98, 0.9999)


def evaluate(equation: BackwardEquation, y: Observable, x: Any) -> Any:
    """y(X) at X = x, on the panels."""
    return equation.at(y, x)[0]


def relative_error(equation: BackwardEquation, exact: BackwardEquation, y: Observable) -> float:
    x = np.linspace(-1.99, 20.0, 800)
    truth = evaluate(exact, y, x)
    scale = evaluate(exact, speed_power(y.degree), x) if y.harmonic and y.is_power else truth
    return float(np.max(np.abs(evaluate(equation, y, x) - truth) / np.abs(scale)))


@pytest.mark.parametrize("e", slow_but(RESTITUTIONS[::3], RESTITUTIONS))
def test_the_estimate_covers_the_error(e: float) -> None:
    # against 30 nodes a panel, which other tests hold against mpmath
    law = CollisionLaw(e)
    exact = BackwardEquation(law, 22.0, 30)
    for nodes in range(6, 18):
        equation = BackwardEquation(law, 22.0, nodes)
        for y in OBSERVABLES:
            error = relative_error(equation, exact, y)
            if 1e-12 < error < 1e-2:
                assert error <= equation.error_estimate(y) <= 150.0 * error, (nodes, y)


@pytest.mark.parametrize(
    ("e", "p"), [*product([0.0, 0.5, 0.999], [8.0, 20.0, 40.0]), (0.7, -6.0), (0.7, -20.0)]
)
@pytest.mark.parametrize("rtol", [1e-4, 1e-10])
def test_moments_of_the_late_state(e: float, p: float, rtol: float) -> None:
    # T = 1e16: what is left of the start is below 1e-13 (e = 0.999: kappa T = 1e13)
    exact = ScalingSolution(e)
    scene = Scene(e, 0.5, initial=Monoenergetic(1e16), times=[1.0])  # l = d
    moment = float(solve(scene, rtol).moment(p)[0])
    expected = exact.moment(p) * (2.0 / exact.cooling_rate) ** p
    assert abs(moment / expected - 1.0) <= rtol


def test_a_moment_that_misses_its_tolerance_says_so() -> None:
    solution = solve(Scene(0.7, times=[10.0], initial="monoenergetic"), 1e-14)
    assert solution.status is SolverStatus.TOLERANCE_NOT_REACHED
    with pytest.warns(ToleranceWarning, match=r"<v\^3>: the error estimate .* exceeds rtol"):
        solution.moment(3.0)


def test_the_error_of_a_ratio_counts_both_of_its_parts() -> None:
    # 1 + a2 = <v^4>/2<v^2>^2 and the kurtosis were once taken to be as good as their worse part
    for e in (0.3, 0.9, 0.99999996):
        for rtol in (3.898e-4, 3e-6, 3e-9):
            scene = Scene(
                e, times=np.geomspace(1.0, 1e4, 30), initial="monoenergetic",
                outputs=("a2", "kurtosis"),
            )  # fmt: skip
            found, exact = solve(scene, rtol), solve(scene, 1e-13)
            assert np.max(np.abs((1.0 + found.a2) / (1.0 + exact.a2) - 1.0)) <= rtol
            assert np.max(np.abs(found.kurtosis / exact.kurtosis - 1.0)) <= rtol


@pytest.mark.parametrize("e", slow_but([0.6], [0.0, 0.6, 0.99]))
@pytest.mark.parametrize(
    "start", [Gaussian(), Gaussian(1.0, 0.3), SpeedTable([0.5, 1.0, 2.0], [0.0, 4.0 / 3.0, 0.0])]
)
def test_many_times_are_interpolated_and_stay_right(e: float, start: State) -> None:
    # 4000 times by interpolation in ln t, some of them by themselves, the last ones among these
    names = ("thermal_speed", "msd", "kurtosis", "collisions", "velocity_tensor")
    times = np.concatenate([[0.0], np.geomspace(300.0 if e == 0.6 else 1e-6, 1e6, 3999)])
    some = [*range(0, 4000, 500), 3990, 3999]
    for rtol in (1e-4, 1e-11):
        many = solve(Scene(e, times=times, initial=start, outputs=names), rtol)
        few = solve(Scene(e, times=times[some], initial=start, outputs=names), rtol)
        for name in names:
            dense, alone = getattr(many, name)[some], getattr(few, name)
            size = np.abs(alone).max(axis=tuple(range(1, alone.ndim)), keepdims=True)
            assert np.all(np.abs(dense - alone) <= max(0.1 * rtol, 1e-13) * size), name
        third, alone = many.moment(3.0)[some], few.moment(3.0)
        assert np.all(np.abs(third / alone - 1.0) <= max(0.1 * rtol, 1e-13))

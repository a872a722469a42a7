"""Every run ends: with an answer that is right to its error estimate, or with a name for why not.

Right is judged by what is known exactly: sqrt(<v^2>) at t = 0, the loss rate lambda(2) <v^3> at
early times, and v0 t = 2 l/h once the scaling state is reached, h = 2 sqrt(kappa lambda(1)).
"""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from extreme_starts import DENSITY, cooling_rate, one_line, starts
from hypothesis import example, given, settings
from hypothesis import strategies as st

from kinetics import InputError, Monoenergetic, Scene, SolverStatus, solve, solve_scaled

pytestmark = pytest.mark.usefixtures("no_hang")

RESTITUTIONS = [0.0, 1e-8, 1e-4, 0.01, *(0.1 * k for k in range(1, 10)), 0.99, 0.999]
RESTITUTIONS += [1 - 1e-6, 1 - 1e-10, 1.0]
FEW = [0.0, 1e-8, 0.01, 0.5, 0.99, 1 - 1e-10, 1.0]
TIMES = [0.0, 1e-300, 1e-10, 1.0, 1e8, 1e150, 1e300]
AVERAGES = ("thermal_speed", "temperature", "a2", "collisions", "msd", "mean_velocity")


def check_averages(e: float, scale: float, name: str, rtol: float = 1e-8) -> None:
    state, square = starts(scale)[name]
    scene = Scene(restitution=e, initial=state, times=TIMES, outputs=AVERAGES)
    if e == 1.0 and (scale > 1.0 or (scale == 1.0 and name == "tail")):
        # elastic tracers do not slow down: v t is beyond the largest number in the end
        with pytest.raises(InputError, match="overflows double precision"):
            solve(scene, rtol=rtol)
        return
    solution = solve(scene, rtol=rtol)
    for output in AVERAGES:
        assert np.all(np.isfinite(getattr(solution, output))), output
    assert isinstance(solution.status, SolverStatus)
    if solution.status is not SolverStatus.CONVERGED:
        assert solution.error_estimate > rtol
        return
    v0 = solution.thermal_speed
    start = scale * math.sqrt(square)
    assert np.allclose(v0[:2], start, rtol=10 * rtol)
    assert np.all(np.diff(v0) <= 1e-12 * v0[:-1])
    assert np.all(solution.a2 >= -0.5 - 10 * rtol)
    assert np.all(np.diff(solution.collisions) >= 0.0)
    assert np.all(solution.msd >= 0.0)
    if e == 1.0:
        assert np.allclose(v0, v0[0], rtol=1e-12)
    elif start * TIMES[-1] * (1 - e) > 1e20:
        # l = 12.5; corrections to the scaling state are of relative order l/(kappa v t)
        assert abs(v0[-1] * TIMES[-1] * cooling_rate(e) / 25.0 - 1.0) < 10 * rtol
    if e != 1.0 and scale == 1.0 and name in ("delta", "gaussian"):
        short = solve(Scene(restitution=e, initial=state, times=[1e-5]), rtol=1e-12)
        third = 1.0 if name == "delta" else 3.0 * math.sqrt(math.pi / 2)
        lost = (1 - e * e) * 2 / 3 * third * 1e-5 / 12.5 / square
        assert abs(short.thermal_speed[0] / start - (1.0 - 0.5 * lost)) < 1e-9 * lost + 1e-11


@pytest.mark.parametrize("name", starts(1.0))
@pytest.mark.parametrize("scale", [1.0, 1e-150, 1e150])
def test_averages(scale: float, name: str) -> None:
    for e in FEW:
        check_averages(e, scale, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", starts(1.0))
@pytest.mark.parametrize("scale", [1.0, 1e-150, 1e150])
@pytest.mark.parametrize("rtol", [1e-3, 1e-8, 1e-12])
def test_averages_everywhere(scale: float, name: str, rtol: float) -> None:
    for e in RESTITUTIONS:
        check_averages(e, scale, name, rtol)


def check_scaled(e: float, nodes: int, rtol: float = 1e-10) -> None:
    """h and moments finite; right within the estimate, to a factor of 100 where nodes are few."""
    try:
        solution = solve_scaled(e, rtol, nodes=nodes)
        found = (solution.cooling_rate, solution.a2, solution.moment(3.0))
        density = solution.vdf([0.1, 1.0, 3.0])
    except InputError as error:
        one_line(error)
        return
    assert np.all(np.isfinite(found))
    assert np.all(np.isfinite(density))
    assert np.all(density >= 0.0)
    if solution.status is SolverStatus.CONVERGED:
        assert abs(solution.cooling_rate / cooling_rate(e) - 1.0) < 100 * rtol


@pytest.mark.parametrize("nodes", [8, 9, 16, 33, 64, 128, 256])
def test_scaled_nodes(nodes: int) -> None:
    for e in FEW[:-1]:
        check_scaled(e, nodes)


@pytest.mark.slow
@pytest.mark.parametrize("nodes", [8, 9, 16, 33, 64, 128, 256, 512, 1024, 2048, 4096])
@pytest.mark.parametrize("e", RESTITUTIONS[:-1])
def test_scaled_nodes_everywhere(e: float, nodes: int) -> None:
    check_scaled(e, nodes)


def check_density(e: float, scale: float, name: str, nodes: int | None, times: Any) -> None:
    state, _ = starts(scale)[name]
    scene = Scene(restitution=e, initial=state, times=times, outputs=DENSITY)
    try:
        solution = solve(scene, rtol=1e-3, nodes=nodes)
        v0 = solution.thermal_speed
        v = np.concatenate([[0.0], np.geomspace(1e-3, 30.0, 200)])
        f = np.stack([solution.speed_density(v * u)[i] * u for i, u in enumerate(v0)])
    except InputError as error:
        one_line(error)
        return
    assert np.all(np.isfinite(f))
    if solution.status is SolverStatus.CONVERGED:
        assert np.all(f.min(axis=1) >= -1e-3 * f.max(axis=1))
        # the trapezoid rule on 200 points: delta peaks apart, and the late ring of nearly elastic
        # tracers, of relative width sqrt((1 - e^2)/5)
        if name != "samples" and (e <= 0.99 or e == 1.0):
            mass = np.trapezoid(f, v, axis=1) + solution.uncollided
            assert np.all(np.abs(mass - 1.0) < 0.1)
    else:
        assert solution.error_estimate > 1e-3


DENSITY_TIMES = [0.0, 1e-300, 1.0, 1e3, 1e300]


@pytest.mark.parametrize("name", ["delta", "gaussian", "tail", "table"])
def test_densities(name: str) -> None:
    for e in (0.0, 0.5, 0.99, 1.0):
        check_density(e, 1.0, name, None, DENSITY_TIMES)


@pytest.mark.parametrize("nodes", [8, 64, 256])
@pytest.mark.parametrize("name", ["delta", "gaussian"])
def test_density_nodes(name: str, nodes: int) -> None:
    for e in (0.0, 0.5, 0.999):
        check_density(e, 1.0, name, nodes, [0.0, 1.0, 100.0])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["delta", "gaussian", "tail", "table", "samples"])
@pytest.mark.parametrize("e", RESTITUTIONS)
@pytest.mark.parametrize("scale", [1.0, 1e-150, 1e150])
def test_densities_everywhere(scale: float, e: float, name: str) -> None:
    check_density(e, scale, name, None, DENSITY_TIMES)


@pytest.mark.slow
@pytest.mark.parametrize("nodes", [8, 16, 100, 1000, 4096])
@pytest.mark.parametrize("e", RESTITUTIONS)
def test_density_nodes_everywhere(e: float, nodes: int) -> None:
    for name in ("delta", "gaussian", "tail"):
        check_density(e, 1.0, name, nodes, DENSITY_TIMES)


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
@pytest.mark.parametrize("e", [0.0, 0.1, 0.5, 0.7, 0.9])
def test_smooth_densities_keep_their_sign(e: float, rtol: float) -> None:
    """Down to speeds of 1e-12: an error of the density of ln v would be divided by v there."""
    scene = Scene(restitution=e, times=[0.0, 1.0, 30.0, 1e3, 1e6], outputs=DENSITY)
    solution = solve(scene, rtol=rtol, method="spectral")
    v = np.geomspace(1e-12, 10.0, 400)
    for i, v0 in enumerate(solution.thermal_speed):
        f = solution.speed_density(v * v0)[i]
        assert f.min() >= -rtol * f.max(), i


# -- random cases -----------------------------------------------------------------------------

ANY_RESTITUTION = st.one_of(
    st.floats(0.0, 1.0),
    st.floats(-16, 0).map(lambda x: 10.0**x),
    st.floats(-16, 0).map(lambda x: 1.0 - 10.0**x),
)
ANY_SCALE = st.floats(-150, 150).map(lambda x: 10.0**x)
ANY_TIMES = st.lists(st.floats(-300, 300).map(lambda x: 10.0**x), min_size=1, max_size=6).map(
    sorted
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    e=ANY_RESTITUTION,
    scale=ANY_SCALE,
    times=ANY_TIMES,
    name=st.sampled_from(["delta", "gaussian", "samples", "beam"]),
    rtol=st.sampled_from([1e-2, 1e-6, 1e-10]),
)
def test_random_averages(e: float, scale: float, times: Any, name: str, rtol: float) -> None:
    state, square = starts(scale)[name]
    scene = Scene(restitution=e, initial=state, times=times, outputs=("thermal_speed", "a2"))
    solution = solve(scene, rtol=rtol)
    v0 = solution.thermal_speed
    assert np.all(np.isfinite(v0))
    assert np.all(v0 >= 0.0)
    assert np.all(v0 <= scale * math.sqrt(square) * (1 + 10 * rtol))
    assert np.all(np.isfinite(solution.a2))
    for earlier, later in itertools.pairwise(v0):
        assert later <= earlier * (1 + 10 * rtol)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(e=ANY_RESTITUTION, rtol=st.sampled_from([1e-2, 1e-6, 1e-10]))
@example(e=1.0 - 2.0**-53, rtol=1e-2)
@example(e=0.9999999999999963, rtol=1e-6)
@example(e=4e-65, rtol=1e-6)
def test_random_scaled(e: float, rtol: float) -> None:
    if e == 1.0:
        with pytest.raises(InputError, match=r"^restitution:"):
            solve_scaled(e, rtol)
        return
    try:
        solution = solve_scaled(e, rtol)
    except InputError as error:
        one_line(error)
        return
    assert np.isfinite(solution.a2)
    if solution.status is SolverStatus.CONVERGED:
        assert abs(solution.cooling_rate / cooling_rate(e) - 1.0) < 10 * rtol


@settings(max_examples=15, deadline=None, derandomize=True)
@given(
    e=st.floats(0.0, 0.95),
    name=st.sampled_from(["delta", "gaussian", "table"]),
    nodes=st.integers(8, 200),
    end=st.floats(-3, 4),
)
def test_random_densities(e: float, name: str, nodes: int, end: float) -> None:
    check_density(e, 1.0, name, nodes, [0.0, 10.0**end])


@pytest.mark.parametrize("p", [2.0, 4.0, -1.5, 40.0])
def test_moments_that_leave_the_range(p: float) -> None:
    """<v^p> of speeds 1e150: a finite number, or a line that says it overflows."""
    solution = solve(Scene(restitution=0.5, initial=Monoenergetic(1e150), times=[0.0, 1e10]))
    try:
        found = solution.moment(p)
    except InputError as error:
        one_line(error)
        return
    assert np.all(np.isfinite(found))

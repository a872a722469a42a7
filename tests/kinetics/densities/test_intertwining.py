"""Densities without steps: closed forms, kept numbers, and the same equation in steps."""

import math
from typing import Any

import numpy as np
import pytest

from kinetics import CollisionLaw, Gaussian, InputError, Scene, SolverStatus, solve
from kinetics.crosscheck.references import load
from kinetics.densities.gain import log_gain
from kinetics.densities.intertwining import Spectrum, choose_turn, intertwine
from kinetics.densities.stepping import stepped
from kinetics.numerics.log_grid import LogGrid

REFERENCES = load()["speed_density"]


def gamma(v: Any) -> Any:
    return 0.5 * v**2 * np.exp(-v)


STARTS: dict[str, Any] = {"gaussian": "gaussian", "gamma": gamma}


def reached(e: float, start: str, rtol: float, **options: Any) -> tuple[float, SolverStatus]:
    """The largest error of f(v, t) relative to the maximum of f(., t), at the kept points."""
    kept = REFERENCES[repr(e)][start]
    scene = Scene(
        e, number_density=0.5, initial=STARTS[start], times=[float(t) for t in kept],
        outputs=("speed_density",),
    )  # fmt: skip
    solution = solve(scene, rtol, method="spectral", **options)
    worst = 0.0
    for i, pairs in enumerate(kept.values()):
        v, exact = np.array(pairs).T
        found = solution.speed_density(v)[i]
        around = solution.speed_density(np.geomspace(0.1, 10.0, 200) * solution.moment(1.0)[i])[i]
        worst = max(worst, float(np.max(np.abs(found - exact)) / around.max()))
    return worst, solution.status


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7, 1e-9, 1e-10, 1e-12, 1e-13])
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("e", [float(e) for e in REFERENCES])
def test_error_reached_against_error_asked(e: float, start: str, rtol: float) -> None:
    """Two Mellin-Barnes integrals in 25 digits."""
    error, status = reached(e, start, rtol)
    if status is SolverStatus.CONVERGED:
        assert error < rtol
    else:
        # rounding leaves some 1e-13 at any restitution, and the status says so
        assert rtol == 1e-13
        assert error < 4e-13


def test_random_scission() -> None:
    """e = 0: the integral of f above v dies as exp(-v t/l), f = (v + t/l) exp(-v^2/2 - v t/l)."""
    v, times = np.geomspace(1e-3, 5.0, 50), np.array([0.0, 0.4, 3.0, 50.0])
    scene = Scene(0.0, number_density=0.5, times=times, outputs=("speed_density",))
    found = solve(scene, 1e-12).speed_density(v)
    t = times[:, None]
    exact = (v + t) * np.exp(-0.5 * v * v - v * t)
    assert np.max(np.abs(found - exact) / exact.max(axis=1, keepdims=True)) < 1e-11


@pytest.mark.parametrize("m", [0, 1, 4])
@pytest.mark.parametrize(
    "e", [0.0, 0.85, *(pytest.param(e, marks=pytest.mark.slow) for e in (0.4, 0.97))]
)
def test_as_in_steps(e: float, m: int) -> None:
    """A complex harmonic, of both methods; they share the window and nothing else."""
    law, rtol = CollisionLaw(e), 1e-9
    times = np.array([0.0, 0.3, 2.0, 20.0])
    tau = np.log1p(times)
    grid = LogGrid(-45.0, 0.05, 1024)
    g = np.exp(2.0 * grid.x - 0.5 * np.exp(2.0 * grid.x))
    rows = np.stack([g, g * np.exp(-(grid.x**2))]) if m else g[None]
    turn = choose_turn(law, m, Spectrum.of(grid, rows), rtol, grid.spacing)
    hidden = intertwine(grid, rows, log_gain(law, grid.wave_numbers, m), turn, m)
    moved, values, _ = hidden.at(tau)
    other, _ = stepped(law, grid, rows, m, tau, rtol)
    scale = np.abs(rows).max()
    # the nodes of the one have moved by whole spacings, those of the other by tau
    for i, down in enumerate(moved):
        # further up the steps leave some noise
        at = grid.x[200:-40] + tau[i] - down * grid.spacing
        for row in range(rows.shape[0]):
            seen = grid.interpolate(other[i, row], at)
            assert np.max(np.abs(values[i, row, 200:-40] - seen)) < 3e-9 * scale


def gaussian_start(nodes: int) -> tuple[LogGrid, Any]:
    """A grid, and the density of ln v of a Gaussian start on it, shape (1, nodes)."""
    grid = LogGrid(-44.0, 54.0 / nodes, nodes)
    return grid, np.exp(2.0 * grid.x - 0.5 * np.exp(2.0 * grid.x))[None]


@pytest.mark.parametrize("e", [0.3, 0.7, 0.9, 0.99])
def test_turning_the_axis_keeps_rounding_down(e: float) -> None:
    """What is raised without it would be as large as the density at e = 0.99."""
    law, k = CollisionLaw(e), np.linspace(0.0, 100.0, 201)
    grid, rows = gaussian_start(1720)
    turn = choose_turn(law, 0, Spectrum.of(grid, rows), 1e-10, grid.spacing)
    flat = log_gain(law, k).real
    assert turn.error < 1e-11
    assert (turn.angle > 1.0) == (-flat.min() > 60.0)


@pytest.mark.parametrize("e", [0.1, 0.5, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99])
def test_rounding_is_as_large_as_the_estimate_says(e: float) -> None:
    """Two solutions on nodes that are half a spacing apart differ by their rounding alone.

    One node at the end of the window, with the rounding of the highest modes, once made this a
    thousand times larger near e = 0.9.
    """
    law, times = CollisionLaw(e), np.array([0.1, 1.0, 4.0])
    grid, rows = gaussian_start(1720)
    turn = choose_turn(law, 0, Spectrum.of(grid, rows), 1e-12, grid.spacing)
    gain = log_gain(law, grid.wave_numbers)
    hidden = intertwine(grid, rows, gain, turn, 0)
    other = LogGrid(grid.start - 0.5 * grid.spacing, grid.spacing, grid.nodes)
    rows = np.exp(2.0 * other.x - 0.5 * np.exp(2.0 * other.x))[None]
    moved, values, _ = hidden.at(times)
    same, shifted, _ = intertwine(other, rows, gain, turn, 0).at(times)
    np.testing.assert_array_equal(moved, same)
    body = grid.x[1:] > -5.0
    for first, second in zip(values[:, 0], shifted[:, 0], strict=True):
        found = np.abs(first[1:] - other.interpolate(second, grid.x[1:]))
        far = np.sqrt(np.mean(found[~body] ** 2))
        # each of the two has its own, and g itself is rounded where it is large
        assert far < 2.0 * math.sqrt(2.0) * hidden.noise
        assert found.max() < 3.0 * math.sqrt(2.0) * hidden.noise + 4e-14
    assert hidden.noise < 2e-15


def test_harmonics_that_die_away_do_not_spoil_the_status() -> None:
    """They are right beside the isotropic part, and that is what the density needs."""
    scene = Scene(
        0.8, initial=Gaussian(2.0, 1.0), times=[1.0, 1e3, 1e6], outputs=("velocity_density",),
        harmonics=8,
    )  # fmt: skip
    solution = solve(scene, 1e-8)
    assert solution.status is SolverStatus.CONVERGED
    assert solution.error_estimate <= 1e-8


def test_many_times_are_those_of_a_few() -> None:
    """Pieces of the time axis, and times that come twice."""
    times = np.sort(np.concatenate([np.geomspace(0.1, 1e4, 150), [1.0, 1.0]]))
    v = np.geomspace(0.01, 3.0, 30)
    outputs = ("speed_density",)
    many = solve(Scene(0.6, times=times, outputs=outputs), 1e-8).speed_density(v)
    for i in (0, 70, 151):
        alone = solve(Scene(0.6, times=[times[i], 1e4], outputs=outputs), 1e-8).speed_density(v)
        np.testing.assert_allclose(many[i], alone[0], rtol=0, atol=1e-13 * many[i].max())


@pytest.mark.parametrize("nodes", [8, 9, 128, 4096, pytest.param(8192, marks=pytest.mark.slow)])
def test_nodes_that_are_asked_for(nodes: int) -> None:
    scene = Scene(0.4, times=[1.0, 100.0], outputs=("speed_density",))
    solution = solve(scene, 1e-6, nodes=nodes)
    assert abs(solution.stats["density_nodes_m0"] - nodes) <= 1
    if nodes < 100:
        assert solution.status is SolverStatus.TOLERANCE_NOT_REACHED


def test_too_narrow_a_ring() -> None:
    scene = Scene(1.0 - 1e-9, times=[1e12], outputs=("speed_density",))
    with pytest.raises(InputError, match=r"^times: .*would need"):
        solve(scene, 1e-8)

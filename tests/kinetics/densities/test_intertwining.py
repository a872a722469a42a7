"""Densities without steps: closed forms, kept numbers, and the same equation in steps."""

import math
from typing import Any

import numpy as np
import pytest

from kinetics import CollisionLaw, Gaussian, InputError, Scene, SolverStatus, solve
from kinetics.crosscheck.references import load
from kinetics.densities.gain import log_gain
from kinetics.densities.intertwining import choose_turn, intertwine
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


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7, 1e-9, 1e-10, 1e-13])
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("e", [float(e) for e in REFERENCES])
def test_error_reached_against_error_asked(e: float, start: str, rtol: float) -> None:
    """Two Mellin-Barnes integrals in 25 digits."""
    error, status = reached(e, start, rtol)
    if status is SolverStatus.CONVERGED:
        assert error < rtol
    else:
        # near e = 0.9 rounding leaves 3e-11, and the status says so
        assert rtol < 1e-10
        assert error < 1e-10


def test_random_scission() -> None:
    """e = 0: the integral of f above v dies as exp(-v t/l), f = (v + t/l) exp(-v^2/2 - v t/l)."""
    v, times = np.geomspace(1e-3, 5.0, 50), np.array([0.0, 0.4, 3.0, 50.0])
    scene = Scene(0.0, number_density=0.5, times=times, outputs=("speed_density",))
    found = solve(scene, 1e-12).speed_density(v)
    t = times[:, None]
    exact = (v + t) * np.exp(-0.5 * v * v - v * t)
    assert np.max(np.abs(found - exact) / exact.max(axis=1, keepdims=True)) < 1e-11


@pytest.mark.parametrize("m", [0, 1, 4])
@pytest.mark.parametrize("e", [0.0, 0.4, 0.85, 0.97])
def test_as_in_steps(e: float, m: int) -> None:
    """A complex harmonic, of both methods; they share the window and nothing else."""
    law, rtol = CollisionLaw(e), 1e-9
    times = np.array([0.0, 0.3, 2.0, 20.0])
    tau = np.log1p(times)
    grid = LogGrid(-45.0, 0.05, 1024)
    g = np.exp(2.0 * grid.x - 0.5 * np.exp(2.0 * grid.x))
    rows = np.stack([g, g * np.exp(-(grid.x**2))]) if m else g[None]
    turn = choose_turn(law, 45.0, math.pi / grid.spacing, m, rtol)
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


@pytest.mark.parametrize("e", [0.3, 0.7, 0.9, 0.99])
def test_turning_the_axis_keeps_rounding_down(e: float) -> None:
    """What is raised without it would be as large as the density at e = 0.99."""
    law, k = CollisionLaw(e), np.linspace(0.0, 100.0, 201)
    turn = choose_turn(law, 45.0, 100.0, 0, 1e-10)
    flat = log_gain(law, k).real
    assert turn.error < 1e-9
    assert (turn.angle > 1.0) == (-flat.min() > 60.0)


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


@pytest.mark.parametrize("nodes", [8, 9, 128, 4096, 8192])
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

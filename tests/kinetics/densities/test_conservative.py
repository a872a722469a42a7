"""The conservative scheme: positivity, mass and energy node by node, order, delta peaks, steps."""

from typing import Any

import numpy as np
import pytest
from example_values import gaussian_speeds, stairs
from moment_hierarchy import series

from kinetics import (
    Beam,
    Gaussian,
    Monoenergetic,
    Scene,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    solve,
)
from kinetics.collision import CollisionLaw
from kinetics.densities.conservative import solve_conservative
from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.densities.node_masses import NodeMasses

TIMES = np.array([0.0, 1e-3, 0.1, 0.7, 2.0, 10.0, 1e2, 1e4, 1e6])


def noisy_table() -> SpeedTable:
    rng = np.random.default_rng(8)
    v = np.linspace(0.0, 4.0, 161)
    f = gaussian_speeds(v) * rng.uniform(0.0, 2.0, v.size)
    return SpeedTable(v, f / np.trapezoid(f, v))


ROUGH: dict[str, Any] = {
    "one speed": Monoenergetic(1.3),
    "steps": SpeedDensity(stairs),
    "noise": noisy_table(),
    "three peaks": SpeedSamples([0.3, 1.0, 1.7]),
}


def solved(
    e: float, state: Any, m: int, times: Any, nodes: int, rtol: float = 1e-12
) -> tuple[Any, Profile]:
    """The masses at the nodes, with x = ln v, and the profile that holds them.

    At 1e-12 the times here are before the scaling state, which would take over.
    """
    found = solve_conservative(
        HarmonicProblem(CollisionLaw(e), 1.0, state, m, np.asarray(times, float), rtol, nodes)
    )
    assert isinstance(found.density, NodeMasses)
    return found.density, found


def masses(e: float, state: Any, times: Any, nodes: int = 300) -> Any:
    """x = ln v, masses (n_times, nodes), mass in the peak that is kept apart (n_times,)."""
    held, found = solved(e, state, 0, times, nodes)
    assert held.mass.shape[0] == len(times)
    peak = np.zeros(len(times)) if found.peak_weight is None else found.peak_weight
    return held.x, held.mass, peak


@pytest.mark.parametrize("name", ROUGH)
@pytest.mark.parametrize("e", [0.0, 0.6, 0.95])
def test_mass_sign_and_energy_balance_of_the_nodes(e: float, name: str) -> None:
    """d<v^2>/dt = -lambda(2) <v^3> for the nodes themselves, however few: Gauss points in time."""
    _, mass, peak = masses(e, ROUGH[name], TIMES)
    assert mass.min() >= 0.0
    # rounding of the many sweeps up to t = 1e6: 1.2e-13 at most
    assert np.max(np.abs(mass.sum(axis=1) + peak - 1.0)) < 3e-13
    node, weight = np.polynomial.legendre.leggauss(24)
    for low, high in ((0.0, 1.0), (1.0, 4.0), (4.0, 20.0)):
        half = 0.5 * (high - low)
        times = np.concatenate([[low], low + half * (1 + node), [high]])
        x, mass, peak = masses(e, ROUGH[name], times, nodes=60)
        energy = mass @ np.exp(2 * x) + peak * 1.3**2
        third = mass @ np.exp(3 * x) + peak * 1.3**3
        lost = 2.0 / 3.0 * (1.0 - e * e) * half * (weight @ third[1:-1])
        assert abs(energy[0] - energy[-1] - lost) < 1e-11 * energy[0]


@pytest.mark.parametrize("e", [0.0, 0.5, 0.8])
def test_second_order_in_the_moments(e: float) -> None:
    """<v>, <v^3> and <v^4> of a delta peak, six resolutions, against the series."""
    times = [0.5, 3.0, 12.0]
    exact = np.array([[series(e, 0, p, t) for t in times] for p in (1, 3, 4)])
    sizes = [75, 150, 300, 600, 1200, 2400]
    errors = []
    for nodes in sizes:
        x, mass, peak = masses(e, Monoenergetic(), times, nodes)
        found = np.array([mass @ np.exp(p * x) + peak for p in (1, 3, 4)])
        errors.append(np.max(np.abs(found / exact - 1.0)))
    order = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert 1.9 < order < 2.1, errors
    assert errors[-1] < 3e-5, errors


def test_harmonics_of_a_peak() -> None:
    """A beam: every harmonic keeps its uncollided share, and the rest obeys the hierarchy."""
    e, u, angle, m = 0.7, 1.0, 0.9, 2
    times = np.linspace(0.0, 2.0, 9)
    state = Beam(direction=angle)
    held, found = solved(e, state, m, times, 3000)
    turn = np.exp(-1j * m * angle)
    assert np.allclose(found.peak_weight, turn * np.exp(-u * times), rtol=1e-13)
    second = held.mass @ np.exp(2 * held.x) + found.peak_weight
    exact = solve(Scene(restitution=e, number_density=0.5, initial=state, times=times))
    assert np.max(np.abs(second - exact.harmonic(2, m))) < 1e-5


def test_harmonics_by_transforms_keep_their_sign() -> None:
    # with 3000 nodes sums go by transforms; what was negative was once cut off: 3 % too much
    scene = Scene(
        0.1, initial=Gaussian(1.0, 0.3), times=[30.0], outputs=("velocity_density",), harmonics=4
    )
    v, phi = [0.05, 0.3, 1.0], [0.0, 0.8, 1.5]
    found = solve(scene, 1e-6, method="conservative", nodes=3000).velocity_density(v, phi)
    exact = solve(scene, 1e-9, method="spectral").velocity_density(v, phi)
    assert np.max(np.abs(found / exact - 1.0)) < 2e-4


@pytest.mark.parametrize("nodes", [20, 60, 300])
def test_a_table_narrower_than_a_cell(nodes: int) -> None:
    """Its mass lies between the points of the cells: once a division by zero."""
    table = SpeedTable([0.9999, 1.0, 1.0001], [0.0, 1e4, 0.0])
    held, _ = solved(0.5, table, 0, [0.0], nodes)
    assert held.mass.sum() == pytest.approx(1.0, abs=1e-12)
    assert held.mass[0] @ np.exp(2.0 * held.x) == pytest.approx(1.0, abs=1e-7)

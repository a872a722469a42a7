"""The conservative scheme: positivity, mass and energy node by node, order, delta peaks, steps."""

from functools import lru_cache
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import (
    Beam,
    Gaussian,
    InputError,
    Monoenergetic,
    Scene,
    SolverStatus,
    SpeedDensity,
    SpeedSamples,
    SpeedTable,
    solve,
)
from kinetics.collision import CollisionLaw
from kinetics.densities import conservative
from kinetics.densities.harmonic import HarmonicProblem, Profile

TIMES = np.array([0.0, 1e-3, 0.1, 0.7, 2.0, 10.0, 1e2, 1e4, 1e6])


def noisy_table() -> SpeedTable:
    rng = np.random.default_rng(8)
    v = np.linspace(0.0, 4.0, 161)
    f = v * np.exp(-0.5 * v * v) * rng.uniform(0.0, 2.0, v.size)
    return SpeedTable(v, f / np.trapezoid(f, v))


def stairs(v: Any) -> Any:
    """Two steps: 0.8 on [0.5, 1), 1.2 on [1.5, 2)."""
    return np.where((v >= 0.5) & (v < 1.0), 0.8, 0.0) + np.where((v >= 1.5) & (v < 2.0), 1.2, 0.0)


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
    found = conservative.solve_conservative(
        HarmonicProblem(CollisionLaw(e), 1.0, state, m, np.asarray(times, float), rtol, nodes)
    )
    assert isinstance(found.density, conservative.NodeMasses)
    return found.density, found


def masses(e: float, state: Any, times: Any, nodes: int = 300) -> Any:
    """x = ln v, masses (n_times, nodes), mass in the peak that is kept apart (n_times,)."""
    held, found = solved(e, state, 0, times, nodes)
    assert held.mass.shape[0] == len(times)
    peak = np.zeros(len(times)) if found.peak_weight is None else found.peak_weight
    return held.x, held.mass, peak


@lru_cache(maxsize=16)
def decay(e: float) -> tuple[Any, ...]:
    """lambda(p) = 1 - E[s^p], p = 0, 1, ...: (p+1) E[s^p] = 1 + p e^2 E[s^(p-2)] upwards."""
    with mp.workdps(60):
        e_ = mp.mpf(e)
        mean = mp.quad(lambda y: mp.sqrt(e_**2 + (1 - e_**2) * y**2), [0, 0.05, 0.3, 1])
        phi = [mp.mpf(1), mean]
        for p in range(2, 160):
            phi.append((1 + p * e_**2 * phi[p - 2]) / (p + 1))
        return tuple(1 - f for f in phi)


@pytest.mark.parametrize("name", ROUGH)
@pytest.mark.parametrize("e", [0.0, 0.3, 0.95])
def test_positive_and_mass_kept(e: float, name: str) -> None:
    _, mass, peak = masses(e, ROUGH[name], TIMES)
    assert mass.min() >= 0.0
    assert np.max(np.abs(mass.sum(axis=1) + peak - 1.0)) < 1e-13


@pytest.mark.parametrize("name", ROUGH)
@pytest.mark.parametrize("e", [0.0, 0.3, 0.95])
def test_energy_never_grows(e: float, name: str) -> None:
    times = np.concatenate([[0.0], np.logspace(-4, 5, 60)])
    x, mass, peak = masses(e, ROUGH[name], times, nodes=120)
    energy = mass @ np.exp(2 * x) + peak * 1.3**2
    assert np.all(np.diff(energy) < 0.0)


@pytest.mark.parametrize("name", ROUGH)
@pytest.mark.parametrize("e", [0.0, 0.6])
def test_energy_balance_of_the_nodes(e: float, name: str) -> None:
    """d<v^2>/dt = -lambda(2) <v^3> for the nodes themselves, however few: Gauss points in time."""
    node, weight = np.polynomial.legendre.leggauss(24)
    for low, high in ((0.0, 1.0), (1.0, 4.0), (4.0, 20.0)):
        half = 0.5 * (high - low)
        times = np.concatenate([[low], low + half * (1 + node), [high]])
        x, mass, peak = masses(e, ROUGH[name], times, nodes=60)
        energy = mass @ np.exp(2 * x) + peak * 1.3**2
        third = mass @ np.exp(3 * x) + peak * 1.3**3
        lost = float(decay(e)[2]) * half * (weight @ third[1:-1])
        assert abs(energy[0] - energy[-1] - lost) < 1e-11 * energy[0]


def mean_speed_power(e: float, p: int, t: float) -> float:
    """<v^p> at t of tracers that all start with speed 1, l = 1: the alternating series."""
    with mp.workdps(60):
        total, term = mp.mpf(0), mp.mpf(1)
        for k in range(150):
            total += term
            term *= -mp.mpf(t) * decay(e)[p + k] / (k + 1)
        return float(total)


@pytest.mark.parametrize("e", [0.0, 0.5, 0.8])
def test_second_order_in_the_moments(e: float) -> None:
    """<v>, <v^3> and <v^4> of a delta peak, six resolutions, against the series."""
    times = [0.5, 3.0, 12.0]
    exact = np.array([[mean_speed_power(e, p, t) for t in times] for p in (1, 3, 4)])
    sizes = [75, 150, 300, 600, 1200, 2400]
    errors = []
    for nodes in sizes:
        x, mass, peak = masses(e, Monoenergetic(), times, nodes)
        found = np.array([mass @ np.exp(p * x) + peak for p in (1, 3, 4)])
        errors.append(np.max(np.abs(found / exact - 1.0)))
    order = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert 1.9 < order < 2.1, errors
    assert errors[-1] < 3e-5, errors


def test_second_order_in_the_density() -> None:
    """A smooth start: the maximum error of f(v, t) against the spectral method at 1e-11."""
    at = dict(restitution=0.6, number_density=0.5, times=[0.5, 5.0], outputs=("speed_density",))
    v = np.logspace(-2, 0.7, 120)
    exact = solve(Scene(**at), rtol=1e-11, method="spectral").speed_density(v)
    sizes = [100, 200, 400, 800, 1600]
    errors = []
    for nodes in sizes:
        found = solve(Scene(**at), rtol=1e-4, method="conservative", nodes=nodes)
        errors.append(np.max(np.abs(found.speed_density(v) - exact)) / exact.max())
    order = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert 1.85 < order < 2.15, errors
    assert errors[-1] < 4e-4, errors


@pytest.mark.parametrize("e", [0.0, 0.4, 0.9])
def test_uncollided_tracers(e: float) -> None:
    """Those of one speed u that have not collided: exp(-u t/l)."""
    times, u = np.array([0.0, 1e-8, 0.1, 1.0, 20.0, 1e3]), 1.7
    scene = Scene(
        restitution=e,
        number_density=0.1,
        initial=Monoenergetic(u),
        times=times,
        outputs=("speed_density",),
    )
    with np.errstate(under="ignore"):
        exact = np.exp(-u * times / 5.0)
    assert np.allclose(solve(scene, rtol=1e-3).uncollided, exact, rtol=1e-13, atol=0)


@pytest.mark.parametrize("e", [0.2, 0.5, 0.8])
def test_density_of_the_first_collision(e: float) -> None:
    """At early times (u t/l) p(s)/u, s = v/u, p(s) = s/(b sqrt(s^2 - e^2)), b = sqrt(1 - e^2)."""
    u, early = 2.0, 1e-7
    scene = Scene(
        restitution=e,
        number_density=0.5,
        initial=Monoenergetic(u),
        times=[early / u],
        outputs=("speed_density",),
    )
    solution = solve(scene, rtol=1e-6, nodes=8000)
    s = np.linspace(e + 0.1 * (1 - e), 0.99, 41)
    exact = early * s / np.sqrt((1 - e * e) * (s * s - e * e)) / u
    assert np.max(np.abs(solution.speed_density(u * s)[0] / exact - 1.0)) < 2e-3
    below = solution.speed_density(u * e * np.array([0.2, 0.5, 0.9]))[0]
    assert np.all(below < 1e-6 * exact.min())
    assert np.all(solution.speed_density([1.1 * u, 3 * u]) == 0.0)


@pytest.mark.parametrize("e", [0.3, 0.7])
def test_a_delta_peak_collision_by_collision(e: float) -> None:
    """Shares of 300,000 tracers in bins of the speed after one or two collisions; 5 sigma."""
    n, t = 300_000, 1.5
    rng = np.random.default_rng(17)
    speed, clock, hits = np.ones(n), np.zeros(n), np.zeros(n)
    moving = np.arange(n)
    while moving.size:
        clock[moving] += rng.exponential(size=moving.size) / speed[moving]
        moving = moving[clock[moving] < t]
        y = rng.uniform(0.0, 1.0, moving.size)
        speed[moving] *= np.sqrt(y * y + e * e * (1 - y * y))
        hits[moving] += 1
    scene = Scene(
        restitution=e,
        number_density=0.5,
        initial="monoenergetic",
        times=[t],
        outputs=("speed_density",),
    )
    solution = solve(scene, rtol=1e-7, nodes=6000)
    edges = np.linspace(0.05, 1.0, 19)  # not at e
    fine = np.linspace(edges[0], edges[-1], 18 * 400 + 1)
    f = solution.speed_density(fine)[0]
    f[-1] = f[-2]  # at u itself the density steps to zero
    shares = np.add.reduceat(0.5 * (f[1:] + f[:-1]) * np.diff(fine), np.arange(0, 7200, 400))
    counts = np.histogram(speed[hits > 0], edges)[0] / n
    assert np.all(np.abs(counts - shares) < 5 * np.sqrt(shares / n) + 1e-5)
    assert abs(np.mean(hits == 0) - solution.uncollided[0]) < 5 * np.sqrt(0.25 / n)


@pytest.mark.parametrize("e", [0.1, 0.6, 0.9])
def test_both_methods_agree(e: float) -> None:
    """Within the sum of the errors that they state, for a smooth start."""
    scene = Scene(restitution=e, times=[0.0, 3.0, 40.0, 1e3], outputs=("speed_density",))
    spectral = solve(scene, rtol=1e-9, method="spectral")
    other = solve(scene, rtol=2e-4, method="conservative")
    assert spectral.status is SolverStatus.CONVERGED
    assert other.error_estimate < 1e-3
    for i, v0 in enumerate(np.sqrt(spectral.moment(2.0))):
        v = v0 * np.logspace(-1.5, 0.6, 60)
        a, b = spectral.speed_density(v)[i], other.speed_density(v)[i]
        allowed = spectral.error_estimate + other.error_estimate
        assert np.max(np.abs(a - b)) < allowed * a.max()


def method_of(solution: Any) -> str:
    (step,) = [s for s in solution.plan if s.part == "densities"]
    return str(step.reason)


def density_scene(initial: Any, e: float = 0.5) -> Scene:
    return Scene(restitution=e, initial=initial, times=[0.0, 5.0], outputs=("speed_density",))


@pytest.mark.parametrize(
    ("initial", "method"),
    [
        ("gaussian", "spectral"),
        (Gaussian(2.0, 2.0), "spectral"),
        (lambda v: v * np.exp(-0.5 * v * v), "spectral"),
        (Beam(speeds="gaussian"), "spectral"),
        ("monoenergetic", "conservative"),
        (Beam(), "conservative"),
        (stairs, "conservative"),
        (ROUGH["noise"], "conservative"),
        (ROUGH["three peaks"], "conservative"),
    ],
)
def test_the_method_that_is_chosen(initial: Any, method: str) -> None:
    assert method in method_of(solve(density_scene(initial), rtol=1e-3))


@pytest.mark.parametrize("method", ["spectral", "conservative"])
def test_the_method_that_is_asked_for(method: str) -> None:
    solution = solve(density_scene("gaussian"), rtol=1e-3, method=method)
    assert method in method_of(solution)


@pytest.mark.parametrize("name", ["one speed", "steps", "three peaks"])
def test_too_rough_for_spectral(name: str) -> None:
    with pytest.raises(InputError, match=r"^method: .*conservative") as error:
        solve(density_scene(ROUGH[name]), rtol=1e-6, method="spectral")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("method", ["Spectral", "", 3, ("spectral",)])
def test_unknown_methods(method: Any) -> None:
    with pytest.raises(InputError, match=r"^method: got .*spectral, conservative$"):
        solve(density_scene("gaussian"), method=method)


@pytest.mark.parametrize("nodes", [0, 7, 8193, 16.0, True, "many", -100])
def test_bad_nodes(nodes: Any) -> None:
    with pytest.raises(InputError, match=r"^nodes: got .* from 8 to 8192$"):
        solve(density_scene("gaussian"), nodes=nodes)


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


def test_integral_of_the_density() -> None:
    """What the user integrates is 1, with the peak, also where f steps to zero at its top."""
    for e in (0.3, 0.9):
        scene = Scene(
            restitution=e,
            number_density=0.5,
            initial="monoenergetic",
            times=[0.0, 0.1, 1.0, 30.0],
            outputs=("speed_density",),
        )
        solution = solve(scene, rtol=1e-5)
        x = np.linspace(-20.0, 0.1, 200_001)
        v = np.exp(x)
        total = np.trapezoid(solution.speed_density(v) * v, x, axis=1) + solution.uncollided
        assert np.max(np.abs(total - 1.0)) < 1e-4


def test_harmonics_by_transforms_keep_their_sign() -> None:
    # with 3000 nodes sums go by transforms; what was negative was once cut off: 3 % too much
    scene = Scene(
        0.1, initial=Gaussian(1.0, 0.3), times=[30.0], outputs=("velocity_density",), harmonics=4
    )
    v, phi = [0.05, 0.3, 1.0], [0.0, 0.8, 1.5]
    found = solve(scene, 1e-6, method="conservative", nodes=3000).velocity_density(v, phi)
    exact = solve(scene, 1e-9, method="spectral").velocity_density(v, phi)
    assert np.max(np.abs(found / exact - 1.0)) < 2e-4


def test_rounding_does_not_fill_the_empty_top(monkeypatch: pytest.MonkeyPatch) -> None:
    # transforms leave a rounding of the largest mass everywhere: taken for mass, it kept the
    # fastest nodes alive and cost 200 times the sweeps
    sweeps = []
    inner = conservative._Axis._arriving

    def counting(self: Any, moving: Any) -> Any:
        sweeps.append(moving.size)
        return inner(self, moving)

    monkeypatch.setattr(conservative._Axis, "_arriving", counting)
    scene = Scene(0.2, times=[1e6], outputs=("speed_density",))
    counts = []
    for limit in (10**12, 0):
        monkeypatch.setattr(conservative, "_DIRECTLY", limit)
        sweeps.clear()
        solve(scene, 1e-13, method="conservative", nodes=500)
        counts.append(len(sweeps))
    assert counts[1] <= 1.05 * counts[0]


def test_the_estimate_covers_the_moments_of_a_rough_start() -> None:
    """<v> and <v^2> of the masses at t = 0 against the linear pieces of a table of spikes.

    1000 nodes do not see the spikes: the moments are 3 % off, the spacing alone would say 0.1 %.
    """
    v = np.linspace(0.0, 4.0, 400)
    f = v * np.exp(-0.5 * v * v) * np.random.default_rng(0).uniform(0.0, 2.0, v.size) ** 6
    f /= np.trapezoid(f, v)
    slope = np.diff(f) / np.diff(v)
    offset = f[:-1] - slope * v[:-1]
    held, found = solved(0.5, SpeedTable(v, f), 0, [0.0], 1000, rtol=1e-3)
    worst = 0.0
    for p in (1, 2):
        exact = np.sum(offset * np.diff(v ** (p + 1)) / (p + 1))
        exact += np.sum(slope * np.diff(v ** (p + 2)) / (p + 2))
        worst = max(worst, abs(float(held.mass[0] @ np.exp(p * held.x)) / exact - 1.0))
    assert worst > 0.02
    assert found.error_estimate >= 0.999 * worst


def test_the_estimate_of_harmonics_is_that_of_their_nodes() -> None:
    """Real harmonics m > 0 were once compared with <v> of the isotropic part: an estimate of 1."""
    scene = Scene(0.4, initial=Gaussian(1.3, 0.8), times=[1.0, 30.0], outputs=("velocity_density",))
    found = solve(scene, 1e-3, method="conservative")
    exact = solve(scene, 1e-8, method="spectral")
    assert found.status is SolverStatus.CONVERGED
    v, phi = np.linspace(0.05, 3.0, 20), np.linspace(0.0, 3.0, 7)
    f, g = found.velocity_density(v, phi) * v[:, None], exact.velocity_density(v, phi) * v[:, None]
    assert np.max(np.abs(f - g)) < 3e-3 * g.max()


@pytest.mark.parametrize("nodes", [20, 60, 300])
def test_a_table_narrower_than_a_cell(nodes: int) -> None:
    """Its mass lies between the points of the cells: once a division by zero."""
    table = SpeedTable([0.9999, 1.0, 1.0001], [0.0, 1e4, 0.0])
    held, _ = solved(0.5, table, 0, [0.0], nodes)
    assert held.mass.sum() == pytest.approx(1.0, abs=1e-12)
    assert held.mass[0] @ np.exp(2.0 * held.x) == pytest.approx(1.0, abs=1e-7)

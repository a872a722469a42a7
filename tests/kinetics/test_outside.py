"""What programs that nobody of this package wrote give, with their standard errors.

DynamO (event-driven molecular dynamics) and LAMMPS (granular, restitution .700 measured head on):
hard disks in the plane from a Gaussian start. ThunderBoltz (particle Monte Carlo of swarms): a cold
gas of fixed cross-section in space, where a tracer of mass m among scatterers of mass M at rest
loses speed as by the restitution (M - m)/(M + m). Then what text books have of neutrons.
"""

import math

import numpy as np
import pytest

from kinetics import CollisionLaw, Monoenergetic, Scene, solve, solve_field

DYNAMO: dict[tuple[float, float], dict[float, float]] = {
    (0.02, 0.4): {1: -2.6, 3: -4.6, 10: -7.0, 30: -7.9, 100: -8.6},
    (0.02, 0.7): {1: -3.0, 3: -6.1, 10: -8.6, 30: -9.8, 100: -10.5},
    (0.02, 0.9): {1: -3.9, 3: -7.0, 10: -10.2, 30: -11.3, 100: -12.0},
    (0.02, 1.0): {1: -4.0, 3: -7.8, 10: -10.5, 30: -11.0, 100: -12.0},
    (0.04, 0.4): {1.19: -4.5, 3.96: -8.8, 9.75: -12.0, 24.0: -13.9},
    (0.04, 0.7): {1.19: -5.7, 3.96: -11.7, 9.75: -14.8, 24.0: -16.9},
    (0.04, 1.0): {1.19: -7.4, 3.96: -14.3, 9.75: -17.2, 24.0: -19.2},
}
"""(n d^2, e) -> time in l/U (dilute) -> <r^2> over the dilute equation, in per cent."""


def over_dilute(n: float, e: float, times: np.ndarray) -> np.ndarray:
    """<r^2> among hard disks over that of the dilute equation, in per cent; times in d/U."""
    dense, dilute = (
        solve(Scene(e, n, times=times, outputs=("msd",), scatterers=s), 1e-8).msd
        for s in ("hard disks", "dilute")
    )
    return np.asarray(100 * (dense / dilute - 1))


@pytest.mark.parametrize(("n", "e"), list(DYNAMO))
def test_the_displacement_among_the_disks_of_dynamo(n: float, e: float) -> None:
    times, measured = (np.array(list(x)) for x in (DYNAMO[n, e].keys(), DYNAMO[n, e].values()))
    found = over_dilute(n, e, times * 0.5 / n)
    error = 1.0 if e == 1.0 else 0.4  # of the simulation
    assert np.all(np.abs(found - measured) < 2.5 * error + 10 * n)
    # the dilute equation is out by many errors
    assert np.all(np.abs(measured[times > 2]) > 4 * error)


def test_the_displacement_among_the_disks_of_lammps() -> None:
    times = np.array([1.0, 4.6, 9.8, 44.8, 95.9, 205.0, 300.0])
    measured = np.array([-1.1, -1.7, -1.6, -4.5, -6.5, -8.3, -9.3])
    apart = over_dilute(0.02, 0.7, times) - measured
    assert np.all(np.abs(apart) < 3 * 2.2)  # errors of 1.4 to 2.2
    assert abs(apart[-1]) < 2.0


@pytest.mark.parametrize(
    ("heavier", "drift", "error", "along", "across"),
    [(1, 1.14646, 3.4e-4, 0.222, 0.323), (3, 0.7396, 3.3e-4, 0.207, 0.333)],
)
def test_swarms(heavier: int, drift: float, error: float, along: float, across: float) -> None:
    """The dispersion are fits of the program without an error bar, of three digits."""
    state = solve_field(1.0, dimension=3, rtol=1e-8, mass_ratio=heavier)
    assert abs(state.drift - drift) < 3 * error
    e = (heavier - 1) / (heavier + 1)
    assert solve_field(e, dimension=3, rtol=1e-8).drift == pytest.approx(state.drift, rel=1e-8)
    assert state.diffusion_parallel == pytest.approx(along, rel=0.02)
    assert state.diffusion_perpendicular == pytest.approx(across, rel=0.02)


def placzek(u: float, least: float) -> float:
    """Collisions per lethargy at u after the first one, all intervals ln(1/least) in closed form.

    In the first it is exp(a u/(1 - a))/(1 - a).
    """
    width, rate = -math.log(least), least / (1 - least)

    def wave(k: int, x: float) -> float:
        return x**k / math.factorial(k) * math.exp(rate * x) if x >= 0 else 0.0

    intervals = range(int(u / width) + 1)
    terms = ((-rate) ** k * (wave(k, u - k * width) - least * wave(k, u - (k + 1) * width))
             for k in intervals)  # fmt: skip
    return sum(terms) / (1 - least)


def test_a_pulse_of_neutrons_has_the_steps_of_placzek() -> None:
    """v f/l over all times, per lethargy u = 2 ln(1/v), from the densities of the speed."""
    times = np.geomspace(3e-3, 300, 40)
    scene = Scene(
        1.0, 1 / np.pi, dimension=3, mass_ratio=12, initial=Monoenergetic(1.0), times=times,
        outputs=("speed_density",),
    )  # fmt: skip
    solution, law = solve(scene, rtol=1e-2), CollisionLaw(1.0, dimension=3, mass_ratio=12)
    least = law.least_ratio**2
    u = -math.log(least) * np.array([0.01, 0.5, 0.97, 1.03, 1.6, 2.5])
    v = np.exp(-u / 2)
    found = np.trapezoid(solution.speed_density(v).T * times, np.log(times)) * v**2 / 2
    np.testing.assert_allclose(found, [placzek(x, least) for x in u], rtol=2e-3)


@pytest.mark.parametrize("mass", [0.5, 2, 12])
def test_lethargy_and_slowness_over_time(mass: float) -> None:
    """Mean lethargy: xi times the mean number of collisions. <1/v>: grows by t/l times A or 1/A."""
    times = np.geomspace(0.1, 1e3, 9)
    scene = Scene(
        1.0, 1 / np.pi, dimension=3, mass_ratio=mass, initial=Monoenergetic(1.0), times=times,
        outputs=("collisions",),
    )  # fmt: skip
    solution, p = solve(scene, rtol=1e-10), 1e-4
    xi = 2 * CollisionLaw(1.0, dimension=3, mass_ratio=mass).mean_log_loss
    found = (solution.moment(-p) - solution.moment(p)) / p
    np.testing.assert_allclose(found, xi * solution.collisions, rtol=1e-5)
    np.testing.assert_allclose(solution.moment(-1.0), 1 + times * min(mass, 1 / mass), rtol=1e-8)

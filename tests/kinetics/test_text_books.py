"""Closed forms and tables of the literature, for position, baths and fields.

Each test names its source. Where a source gives a formula, the test computes it anew. Lengths are in
the free path l: the density is 1/2 in the plane and 1/pi in space.
"""

import math

import numpy as np
import pytest
from scipy.special import gamma

from kinetics import CollisionLaw, Monoenergetic, Scene, solve, solve_field, solve_steady

PLANE = 0.5
SPACE = 1.0 / math.pi


# -- positions -------------------------------------------------------------------------------------
def test_the_pulse_of_ganapol() -> None:
    """F(k = .5, t) of an elastic pulse of one speed, from AZURV1 (LA-UR-01-1854) with c = 1.

    The numbers are those of the reference script of MC/DC.
    """
    times = [1.0, 5.0, 20.0]
    scene = Scene(
        1.0,
        SPACE,
        dimension=3,
        initial=Monoenergetic(1.0),
        times=times,
        outputs="intermediate_scattering",
    )
    found = solve(scene, rtol=1e-10).intermediate_scattering([0.5])[:, 0]
    reference = [0.969669058228029, 0.7118097631677875, 0.19967109898211552]
    np.testing.assert_allclose(found, reference, rtol=1e-9)


def test_the_flux_of_a_point_pulse() -> None:
    """The density at t = 10 of W. Bennett's transport benchmarks (point source)."""
    scene = Scene(
        1.0,
        SPACE,
        dimension=3,
        initial=Monoenergetic(1.0),
        times=[10.0],
        outputs="position_density",
    )
    radii = np.array([1.0101019, 5.0505055])
    found = solve(scene, rtol=1e-5).position_density(radii)[0] / (4.0 * math.pi * radii**2)
    np.testing.assert_allclose(found, [3.6751896796e-3, 5.457258557e-4], rtol=1e-4)


def test_the_planar_walk_with_isotropic_turns() -> None:
    """Stadje (1987), Kolesnik and Orsingher: p = exp(-t + q)/(2 pi q), q = sqrt(t^2 - r^2)."""
    n_directions = 4000
    directions = math.pi * (np.arange(n_directions) + 0.5) / n_directions
    ones = np.ones(n_directions)
    law = CollisionLaw.from_samples(ones / n_directions, ones, np.cos(directions))
    scene = Scene(
        law,
        PLANE,
        initial=Monoenergetic(1.0),
        times=[0.5, 2.0],
        outputs="intermediate_scattering",
    )
    found = solve(scene, rtol=1e-9).intermediate_scattering([0.5])[:, 0]
    np.testing.assert_allclose(found, [0.9867322141823712, 0.8646814047764104], rtol=1e-7)


# -- speeds ----------------------------------------------------------------------------------------
def test_a_pulse_that_slows_down_in_hydrogen() -> None:
    """Ornstein and Uhlenbeck (1937), constant free path: n = v t exp(-v t) (2 + t (1 - v))."""
    times = np.array([0.5, 2.0, 8.0])
    scene = Scene(
        1.0,
        SPACE,
        dimension=3,
        mass_ratio=1.0,
        initial=Monoenergetic(1.0),
        times=times,
        outputs="speed_density",
    )
    speeds = np.array([0.05, 0.3, 0.7])
    t = times[:, None]
    density = speeds * t * np.exp(-speeds * t) * (2.0 + t * (1.0 - speeds))
    found = solve(scene, rtol=1e-3).speed_density(speeds)
    np.testing.assert_allclose(found, density, rtol=2e-3)


def test_random_scission() -> None:
    """At e = 0 in the plane a pulse has n = t exp(-v t) below its speed."""
    times = np.array([0.5, 2.0, 8.0])
    scene = Scene(0.0, PLANE, initial=Monoenergetic(1.0), times=times, outputs="speed_density")
    speeds = np.array([0.05, 0.3, 0.7])
    t = times[:, None]
    found = solve(scene, rtol=1e-3).speed_density(speeds)
    np.testing.assert_allclose(found, t * np.exp(-speeds * t), rtol=2e-3)


# -- baths -----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("mass_ratio", "ratio"), [(0.05, 1.0000811668), (0.25, 1.0018249732), (1.0, 1.01895)]
)
def test_tracer_diffusion_over_its_first_approximation(mass_ratio: float, ratio: float) -> None:
    """Hard spheres by KineticGas (pykingas 2.0.0) at order 6; at equal masses Pidduck's 1.01895.

    At equal masses order 6 of the expansion has not converged in the sixth digit.
    """
    state = solve_steady(1.0, 3, bath_speed=1.0, mass_ratio=mass_ratio)
    effective = (mass_ratio - 1.0) / (mass_ratio + 1.0)
    first = 3.0 * math.sqrt(math.pi) / 8.0 / math.sqrt(1.0 - effective)
    assert state.diffusion_coefficient / first == pytest.approx(
        ratio, rel=1e-5 if mass_ratio == 1.0 else 1e-6
    )


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("restitution", "mass_ratio"), [(0.5, 1.0), (0.9, 4.0), (0.2, 0.3)])
def test_the_temperature_of_martin_and_piasecki(
    restitution: float, mass_ratio: float, dimension: int
) -> None:
    """Europhys. Lett. 46 (1999) 613: T over that of the bath is (1 + e)/(2 + (1 - e) M/m)."""
    state = solve_steady(restitution, dimension, bath_speed=1.0, mass_ratio=mass_ratio)
    ratio = state.mean_square_along / mass_ratio
    expected = (1.0 + restitution) / (2.0 + (1.0 - restitution) * mass_ratio)
    assert ratio == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(
    ("dimension", "factor", "a2"), [(2, 32.0 / 3.0, 2.0 / 3.0), (3, 12.0, 0.5)]
)
def test_fermi_acceleration_by_heavy_scatterers(dimension: int, factor: float, a2: float) -> None:
    """Elastic tracers among infinitely heavy scatterers that move: <v^2> grows as w^4 t^2."""
    late = 500.0
    density = PLANE if dimension == 2 else SPACE
    scene = Scene(
        1.0,
        density,
        dimension=dimension,
        initial="rest",
        bath_speed=1.0,
        times=[late],
        outputs=("temperature", "a2"),
    )
    solution = solve(scene, rtol=1e-4)
    assert dimension * solution.temperature[0] / late**2 == pytest.approx(factor, rel=2e-2)
    assert solution.a2[0] == pytest.approx(a2, rel=2e-2)


# -- fields ----------------------------------------------------------------------------------------
def test_electrons_in_a_strong_field() -> None:
    """The distribution of Druyvesteyn, exp(-(3/4) (m/M) v^4), gives drift and D in closed form.

    Huxley and Crompton have D_T/mu over kT as 1.144; Parker and Lowke (1969) D_L/D_T as "about
    one-half".
    """
    mass_ratio = 1e6
    state = solve_field(1.0, dimension=3, mass_ratio=mass_ratio, rtol=1e-8)
    third = 0.75 / mass_ratio
    mean_square = gamma(1.25) / gamma(0.75) / math.sqrt(third)
    mean_speed = gamma(1.0) / gamma(0.75) * third**-0.25
    mean_slowness = gamma(0.5) / gamma(0.75) * third**0.25
    drift = 2.0 / 3.0 * mean_slowness
    assert state.drift == pytest.approx(drift, rel=1e-5)
    across = state.diffusion_perpendicular
    assert across == pytest.approx(mean_speed / 3.0, rel=1e-5)
    assert across / state.drift / (mean_square / 3.0) == pytest.approx(1.14414, rel=1e-4)
    assert state.diffusion_parallel / across == pytest.approx(0.4910, rel=1e-3)


def davydov_mean_square(mass_ratio: float, bath_speed: float) -> float:
    """<v^2> of exp(-int v dv/(M w^2/m + M/(3 m v^2))), the field being 1 in units of l."""
    scale = mass_ratio * bath_speed**2
    speeds = np.linspace(0.0, 14.0 * math.sqrt(scale + math.sqrt(mass_ratio)), 400_001)
    with np.errstate(divide="ignore"):
        slope = speeds / (scale + mass_ratio / (3.0 * speeds**2))
    steps = 0.5 * (slope[1:] + slope[:-1]) * np.diff(speeds)
    weight = np.exp(-np.concatenate([[0.0], np.cumsum(steps)])) * speeds**2
    return float(np.trapezoid(weight * speeds**2, speeds) / np.trapezoid(weight, speeds))


def test_electrons_in_a_warm_gas() -> None:
    """Davydov's distribution is the limit of heavy scatterers: what is left falls as m/M."""
    deviations = []
    for mass_ratio in (100.0, 1000.0):
        bath_speed = (1.0 / mass_ratio) ** 0.5
        state = solve_steady(
            1.0, 3, bath_speed=bath_speed, mass_ratio=mass_ratio, field=1.0, rtol=1e-6
        )
        expected = davydov_mean_square(mass_ratio, bath_speed)
        deviations.append(abs(state.moment(2.0) / expected - 1.0))
    assert deviations[0] < 0.05
    assert deviations[1] == pytest.approx(deviations[0] / 10.0, rel=0.3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_elastic_tracers_that_fall_for_ever(dimension: int) -> None:
    """Krapivsky and Redner (1997): <v^2> grows as t^(2/3), with these coefficients."""
    late = 1e5
    scene = Scene(
        1.0,
        PLANE if dimension == 2 else SPACE,
        dimension=dimension,
        field=1.0,
        initial="rest",
        times=[late],
        outputs="temperature",
    )
    mean_square = dimension * solve(scene, rtol=1e-4).temperature[0]
    expected = {
        2: gamma(4 / 3) / gamma(2 / 3) * (27.0 * late / 8.0) ** (2 / 3),
        3: gamma(5 / 3) * (3.0 * late) ** (2 / 3),
    }[dimension]
    assert mean_square == pytest.approx(expected, rel=5e-3)


def test_capture_from_rest() -> None:
    """Depth, time and collisions before capture, from an independent program in C (3 sigma)."""
    state = solve_steady(0.5, field=1.0, capture_speed=0.2)
    measured = [(19.822, 0.027), (32.094, 0.043), (33.377, 0.044)]
    for value, (mean, error) in zip(state.capture_from(0.0), measured, strict=True):
        assert abs(value - mean) < 3.0 * error

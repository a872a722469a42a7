"""Averages over time of spheres and of rough scatterers, against series of 60 digits."""

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from kinetics import Beam, CollisionLaw, ScalingSolution, Scene, solve
from kinetics.errors import SolverStatus

PATH = 1.0 / (math.pi * 0.04)  # of spheres of number density 0.04
PLANE = 12.5
TERMS = 160


def power(e: Any, et: Any, dimension: int, p: int) -> Any:
    """E[s^p]; in space s^2 is uniform between e^2 and et^2."""
    e = abs(e)
    if dimension == 3:
        ends = (et ** (p + 2) - e ** (p + 2)) / (p + 2) if p != -2 else mp.log(et / e)
        return 2 * ends / (et**2 - e**2)
    return e**p * mp.hyp2f1(-mp.mpf(p) / 2, 0.5, 1.5, 1 - (et / e) ** 2)


def rates(e: float, et: float, dimension: int, m: int, first: int = 0) -> list[Any]:
    """1 - E[s^p P_m(cos chi)], or with cos(m chi) in the plane, p = first, first + 1, ...

    With y^2 = (s^2 - e^2)/(et^2 - e^2), s cos(chi) is a sum of two powers of s.
    """
    e, et = mp.mpf(e), mp.mpf(et)
    powers = {p: power(e, et, dimension, p) for p in range(first - 2, first + TERMS + 3)}
    slope = (e + et) / (et**2 - e**2)
    level = -e - slope * e**2  # s cos(chi) = level + slope s^2
    found = []
    for p in range(first, first + TERMS):
        one = level * powers[p - 1] + slope * powers[p + 1]
        two = level**2 * powers[p - 2] + 2 * level * slope * powers[p] + slope**2 * powers[p + 2]
        plane = (powers[p], one, 2 * two - powers[p])
        space = (powers[p], one, (3 * two - powers[p]) / 2)
        found.append(1 - (plane if dimension == 2 else space)[m])
    return found


def series(decay: list[Any], driving: list[tuple[Any, list[Any]]], constant: int = 0) -> list[Any]:
    """Coefficients of T^k of y' = sum of driving + constant - decay y, y(0) = 0 or 1."""
    a = [mp.mpf(0 if driving or constant else 1)]
    for k in range(TERMS):
        source = mp.mpf(constant) if k == 0 else mp.mpf(0)
        source += sum(factor * other[k] for factor, other in driving)
        a.append((source - decay[k] * a[k]) / (k + 1))
    return a


def sampled(dimension: int, *samples: tuple[float, float, float]) -> tuple[CollisionLaw, Any]:
    """A law of (weight, ratio, cosine), and its rates."""

    def found(m: int, first: int) -> list[Any]:
        turned = [mp.chebyt(m, c) if dimension == 2 else mp.legendre(m, c) for _, _, c in samples]
        return [
            1 - mp.fsum(mp.mpf(w) * mp.mpf(s) ** p * x
                        for (w, s, _), x in zip(samples, turned, strict=True))
            for p in range(first, first + TERMS)
        ]  # fmt: skip

    return CollisionLaw.from_samples(*zip(*samples, strict=True), dimension), found


def bounces(
    e: float, et: float, dimension: int = 2, mass: float = math.inf
) -> tuple[CollisionLaw, Any]:
    """Disks or spheres, and their rates; scatterers that may move act by the restitution e*."""
    star = e if mass == math.inf else (1.0 + e) * mass / (1.0 + mass) - 1.0
    law = CollisionLaw(e, et, dimension, mass_ratio=mass)
    return law, lambda m, first: rates(star, et, dimension, m, first)


LAWS = {
    "smooth disks": bounces(0.7, 1.0),
    "smooth spheres": bounces(0.7, 1.0, 3),
    "light spheres": bounces(1.0, 1.0, 3, 0.01),
    "rough disks": bounces(0.7, 0.4),
    "rough spheres": bounces(0.3, 0.8, 3),
    "elastic normal to the sphere": bounces(1.0, 0.6, 3),
    "samples": sampled(2, (0.25, 0.9, 0.5), (0.75, 0.4, -0.8)),
    "samples in space": sampled(3, (0.5, 1.0, 0.25), (0.5, 0.1, -1.0)),
    "elastic spheres": (
        CollisionLaw(1.0, dimension=3), lambda m, first: [mp.mpf(min(m, 1))] * TERMS,
    ),
    "elastic disks": (
        CollisionLaw(1.0), lambda m, first: [1 + mp.mpf(1) / (4 * m * m - 1)] * TERMS,
    ),
}  # fmt: skip


@pytest.fixture(params=LAWS)
def law(request: Any) -> tuple[CollisionLaw, Any]:
    """Every kind of law, with 1 - E[s^p cos(m chi)] in mpmath."""
    return LAWS[request.param]


def test_every_output_of_a_beam_of_one_speed(law: tuple[CollisionLaw, Any]) -> None:
    """Every tracer begins with (U, 0): all outputs as power series in T = U t/l."""
    bounce, decay = law
    space = bounce.dimension == 3
    t = np.array([0.1, 1.0, 4.0, 10.0])
    path = PATH if space else PLANE
    with mp.workdps(60):
        zero, one, two = (decay(m, 0) for m in range(3))
        # along the start, <r^2>, second harmonic, third order, <r^4>: the wave number expanded
        chi = series(one, [], constant=1)
        square = series(zero, [(2, chi)])
        third = mp.mpf(1) / 3
        a, b, c, d = (2 * third, third / 2, 6 * third / 5, 40) if space else (0.25, 0.125, 0.5, 64)
        second = series(two, [(a, chi)])
        fourth = series(zero, [(d, series(one, [(b, square), (c, second)]))])
        slope = [k * x for k, x in enumerate(square)]
        coefficients = {
            "x": chi, "square": square, "fourth": fourth, "slope": slope,
            "collisions": series(zero, [], constant=1), "v": series(decay(1, 1), []),
            "v^2": series(decay(0, 2), []), "v^4": series(decay(0, 4), []),
            "turned": series(decay(2, 2), []),
        }  # fmt: skip
        exact = {
            name: np.array([float(mp.polyval(y[::-1], x)) for x in t])
            for name, y in coefficients.items()
        }
    outputs = (
        "thermal_speed", "temperature", "a2", "collisions", "msd", "kurtosis", "mean_velocity",
        "velocity_tensor", "velocity_autocorrelation", "diffusion_coefficient", "mean_displacement",
    )  # fmt: skip
    scene = Scene(bounce, initial=Beam(), times=t * path, outputs=outputs)
    found = solve(scene, rtol=1e-11)
    assert found.status is SolverStatus.CONVERGED
    dimension, energy = bounce.dimension, exact["v^2"]
    along = energy * 0.5 + 0.5 * exact["turned"]
    if space:
        along = (energy + 2.0 * exact["turned"]) / 3.0
    expected = {
        "thermal_speed": np.sqrt(energy),
        "temperature": energy / dimension,
        "a2": exact["v^4"] * dimension / ((dimension + 2.0) * energy**2) - 1.0,
        "collisions": exact["collisions"],
        "msd": path**2 * exact["square"],
        "kurtosis": exact["fourth"] / exact["square"] ** 2,
        "diffusion_coefficient": exact["slope"] / t * path / (2.0 * dimension),
        "msd_slope": exact["slope"] * path**2,
    }
    for name, values in expected.items():
        plus = 1.0 if name == "a2" else 0.0
        np.testing.assert_allclose(getattr(found, name) + plus, values + plus, rtol=1e-11)
    tensor = found.velocity_tensor
    np.testing.assert_allclose(np.trace(tensor, axis1=1, axis2=2), energy, rtol=1e-11)
    assert not found.mean_velocity[:, 1:].any()
    assert not found.mean_displacement[:, 1:].any()
    # relative to powers of the thermal speed, or to a free path
    for value, values, unit in (
        (found.mean_velocity[:, 0], exact["v"], np.sqrt(energy)),
        (found.velocity_autocorrelation, exact["v"], np.sqrt(energy)),
        (tensor[:, 0, 0], along, energy),
        (found.mean_displacement[:, 0], exact["x"] * path, path),
    ):
        assert np.max(np.abs(value - values) / unit) <= 1e-11


def test_one_ratio_goes_on_oscillating() -> None:
    """v0 t repeats itself when t is 5 times as large (et = e = 0.2): once a constant after 1e18."""
    law, times = CollisionLaw(0.2, 0.2), 1e22 * np.array([1.0, 5.0**0.5, 5.0])
    found = solve(Scene(law, times=times, outputs="thermal_speed"), rtol=1e-10)
    assert found.status is SolverStatus.CONVERGED
    first, half, again = found.thermal_speed * times
    assert again == pytest.approx(first, rel=1e-9)
    assert abs(half / first - 1.0) > 0.005


@pytest.mark.parametrize(
    ("e", "et", "dimension"),
    [(1e-4, 0.5, 3), (0.01, 0.5, 3), (0.0, 0.8, 3), (1e-10, 0.5, 2), (0.9, 0.95, 3)],
)
def test_late_slope_where_directions_are_forgotten_slowly(
    e: float, et: float, dimension: int
) -> None:
    """At e = 0, et = 0.5 in space v(0).v(t) t adds a term that falls as T^-0.38, not as 1/T."""
    law = CollisionLaw(e, et, dimension)
    scene = Scene(law, times=[1.0, 1e60], outputs="diffusion_coefficient")
    found = solve(scene, rtol=1e-11)
    assert found.status is SolverStatus.CONVERGED
    late = scene.mean_free_path**2 * ScalingSolution(law).diffusion_slope
    assert found.msd_slope[-1] == pytest.approx(late, rel=1e-11)

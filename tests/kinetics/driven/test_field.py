"""solve_field: the steady state against exact relations, limits and tables."""

import math
from functools import cache

import numpy as np
import pytest

from kinetics import CollisionLaw, FieldState, ToleranceWarning, solve_field
from kinetics.driven.steady_density import SteadyDensity
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between

FIGURES = ("drift", "mean_square_speed", "mean_square_along", "mean_speed")
COEFFICIENTS = ("diffusion_parallel", "diffusion_perpendicular")
# restitution, dimension, tangential restitution
LAWS = [
    (0.0, 2, 1.0), (0.01, 2, 1.0), (0.3, 3, 1.0), (0.5, 2, 1.0), (0.9, 3, 1.0), (0.999, 2, 1.0),
    (0.5, 2, 0.8), (0.9, 3, 0.2), (0.7, 2, 0.7), (0.4, 2, 0.4), (0.0, 2, 0.5),
]  # fmt: skip
# and mass ratio
MOVED = [(0.0, 2, 1.0, 0.5), (1.0, 3, 1.0, 0.2), (1.0, 2, 1.0, 1.0), (0.8, 3, 1.0, 3.0)]


@pytest.mark.parametrize(
    ("e", "dimension", "et", "mass"), [*((*law, math.inf) for law in LAWS), *MOVED]
)
def test_exact_relations(e: float, dimension: int, et: float, mass: float) -> None:
    """Moments of the first two rows of the equation, with averages of the collision law."""
    state = solve_field(e, dimension, et, mass_ratio=mass)
    law, moment = CollisionLaw(e, et, dimension, mass_ratio=mass), state.moment
    assert state.status.name == "CONVERGED"
    tight = 1e-11 if e >= 0.5 else 1e-10
    assert moment(2, 1) * law.harmonic_decay_rate(1.0, 1) == pytest.approx(1.0, rel=tight)
    assert 2 * state.drift == pytest.approx(law.decay_rate(2.0) * moment(3), rel=tight)
    assert moment(4) == pytest.approx(3 * moment(2, 1) / law.decay_rate(3.0), rel=tight)
    assert moment(0, 1) == pytest.approx(law.decay_rate(1.0) * moment(2), rel=tight)
    if math.isinf(law.lowest_power):
        assert moment(-1, 1) == pytest.approx(law.mean_log_loss * moment(1), rel=tight)
    if math.isinf(law.lowest_power) and law.largest_loss < 3.0:
        assert moment(-2, 1) == pytest.approx(-law.decay_rate(-1.0), rel=tight)


@pytest.mark.parametrize(
    ("e", "dimension"), [(0.0, 2), (0.8, 2), (0.3, 3), pytest.param(0.0, 3, marks=pytest.mark.slow)]
)
def test_moment_hierarchy_of_higher_harmonics(dimension: int, e: float) -> None:
    """Row m of the equation, times v^p: it meets the harmonics m - 1, m and m + 1."""
    state = solve_field(e, dimension)
    for m in (1, 2, 3, 4):
        for p in (0.5, 1.0, 2.0, 3.5):
            below, above = state.moment(p - 1, m - 1), state.moment(p - 1, m + 1)
            if dimension == 2:
                left = 0.5 * (p + m) * below + 0.5 * (p - m) * above
            else:
                left = (m * (p + m + 1) * below + (m + 1) * (p - m) * above) / (2 * m + 1)
            right = float(state.law.harmonic_decay_rate(p, m)) * state.moment(p + 1, m)
            assert left == pytest.approx(right, rel=1e-7, abs=1e-8), (m, p)


@pytest.mark.parametrize(
    ("dimension", "drift", "across", "along"),
    [(2, 0.52666478, 0.37760980, 0.176205), (3, 0.63452714, 0.41337540, 0.202982)],
)
def test_nearly_elastic(dimension: int, drift: float, across: float, along: float) -> None:
    """The constants of the limit e -> 1 and eps = 1 - e^2."""
    e = 1.0 - 1e-8
    state = solve_field(e, dimension)
    quarter = ((1.0 - e) * (1.0 + e)) ** 0.25
    assert state.status.name == "CONVERGED"
    assert state.drift / quarter == pytest.approx(drift, rel=3e-8)
    assert state.diffusion_perpendicular * quarter == pytest.approx(across, rel=1e-6)
    assert state.diffusion_parallel * quarter == pytest.approx(along, rel=1e-5)


def test_tiny_restitution_is_like_none() -> None:
    known = 0.985849365  # at e = 0, from a program of its own; other tables are in tests/golden
    assert nearly_exact(0.0).drift == pytest.approx(known, rel=5e-9)
    assert solve_field(1e-300, rtol=1e-6).drift == pytest.approx(known, rel=1e-6)


@cache
def nearly_exact(e: float) -> FieldState:
    return solve_field(e, rtol=1e-9)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("e", [0.0, 0.6, pytest.param(0.95, marks=pytest.mark.slow)])
def test_rtol_is_met(e: float, rtol: float) -> None:
    exact, state = nearly_exact(e), solve_field(e, rtol=rtol)
    assert state.status.name == "CONVERGED"
    for name in (*FIGURES, *COEFFICIENTS):
        assert getattr(state, name) == pytest.approx(getattr(exact, name), rel=rtol), name


def test_what_is_not_reached_is_said() -> None:
    state = solve_field(0.95, rtol=1e-14)
    assert state.status.name == "TOLERANCE_NOT_REACHED"
    assert 1e-14 < state.error_estimate < 1e-11
    assert "raise rtol" in state.message


@pytest.mark.parametrize("d", [2, 3])
def test_density(d: int) -> None:
    """Integral 1, the drift, and no negative values."""
    v, w = panels_between(np.array([0.0, 0.3, 1.0, 3.0, 8.4]), 8)
    state = solve_field(0.7, d)
    phi, share = panels_between(np.array([0.0, 0.2, 1.0, math.pi]), 8)
    share *= 2.0 if d == 2 else 2.0 * math.pi * np.sin(phi)
    f = state.vdf(v, phi)
    assert f.shape == (32, 24)
    assert f.min() > -1e-9
    assert (w * v ** (d - 1)) @ f @ share == pytest.approx(1.0, abs=1e-6)
    assert (w * v**d) @ f @ (share * np.cos(phi)) == pytest.approx(state.drift, abs=1e-6)
    assert np.all(state.vdf([100.0, 1e200], [0.0, 1.0, 3.0]) == 0.0)
    ray = state.vdf([1e-3, 1.0], [0.0, 1e-12, 1e-9, 1e-7])
    assert ray == pytest.approx(np.repeat(ray[:, :1], 4, axis=1), rel=1e-5)


def test_density_on_the_ray_along_the_field() -> None:
    """d_z f = gain - v f there, the gain an integral over the density of other directions."""
    state = solve_field(0.7, rtol=1e-8)
    q = state.law.quadrature_for(10.0, 8)
    z, w = panels_between(np.array([-5.0, -2.0, -0.5, 0.0, 0.3, 1.0]), 6)
    f = np.empty((z.size, q.ratio.size))
    for bounce, (ratio, deflection) in enumerate(zip(q.ratio, q.deflection, strict=True)):
        up_and_down = state.vdf(np.abs(z) / ratio, [deflection, math.pi - deflection])
        f[:, bounce] = np.where(z > 0.0, up_and_down[:, 0], up_and_down[:, 1])
    gain = np.abs(z) * (f @ (q.weight * q.ratio**-3))
    expected = (w * gain) @ np.exp(-0.5 * (1.0 - z * np.abs(z)))
    assert state.vdf([1.0], [0.0])[0, 0] == pytest.approx(expected, abs=3e-7)


def test_density_where_bounces_stop_a_tracer() -> None:
    """Infinite along the field, and what harmonics leave close to it is said."""
    state = solve_field(0.0, rtol=1e-8)
    assert np.all(np.isinf(state.vdf([0.5, 1.0], [0.0])))
    with pytest.warns(ToleranceWarning, match="vdf"):
        close = state.vdf([1.0], [1e-5, 1e-4, 1e-3, 1e-2])[0]
    assert np.diff(close) == pytest.approx(np.full(3, -0.083), rel=0.03)  # a logarithm
    with pytest.warns(ToleranceWarning, match="vdf"):
        solve_field(1e-12, rtol=1e-6).vdf([1.0], [0.0])


def test_in_units() -> None:
    found = (state := solve_field(0.7, 3)).in_units(9.81, 1e-3, 1e8)
    speed = math.sqrt(9.81 * (path := 1.0 / (math.pi * 1e-6 * 1e8)))
    for name, unit in (("drift", speed), *((name, speed * path) for name in COEFFICIENTS)):
        assert getattr(found, name) == pytest.approx(getattr(state, name) * unit, rel=1e-14)
    figures = path, math.sqrt(path / 9.81), state.mean_speed * math.sqrt(9.81 / path)
    assert (found.mean_free_path, found.time, found.collision_rate) == pytest.approx(figures)


def test_points_of_a_dataset_that_are_none_are_the_usual_ones() -> None:
    state = solve_field(0.7, rtol=1e-4)
    specified = state.to_xarray(speeds=None, angles=None)
    assert specified.equals(state.to_xarray())
    assert specified.title == repr(state).split("\n")[0]


def test_a_density_that_is_not_a_number_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def density(self: SteadyDensity, along: FloatArray, across: FloatArray) -> FloatArray:
        return np.where(along > 0.9, math.nan, 1.0)

    monkeypatch.setattr(SteadyDensity, "density", density)
    with pytest.warns(ToleranceWarning, match="vdf"):
        solve_field(0.7, rtol=1e-4).vdf([0.5, 1.0], [0.0, 2.0])

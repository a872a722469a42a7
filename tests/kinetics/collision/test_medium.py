"""Scatterers at a finite density: the law, its closed forms, and what solves for it."""

import json
import math
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
from marking import slow_but
from scipy.interpolate import BarycentricInterpolator

from kinetics import CollisionLaw, ScalingSolution, Scene, solve
from kinetics.collision import law_in_medium, medium
from kinetics.collision.return_constants import constants_at
from tests.kinetics.measurements import density, returns

LATE = 1e15
OUTPUTS = ("msd", "thermal_speed", "a2", "collisions", "diffusion_coefficient")


def late(e: float, n: float, **more: Any) -> Any:
    """Averages from which every trace of the start has gone, to 1/LATE."""
    scene = Scene(e, n, times=[LATE, 1e3 * LATE], outputs=OUTPUTS, **more)
    return solve(scene, rtol=1e-12)


@pytest.mark.parametrize("scatterers", ["overlapping", "hard disks"])
def test_the_leading_order_is_what_it_is_defined_to_be(scatterers: str) -> None:
    e, n = 0.7, 0.04
    loops = 2 * e / (1 + e) * n * math.log(1 / n)
    plain = CollisionLaw(e)
    law = law_in_medium(plain, scatterers, n, 1.0, "leading")
    for m, p in [(0, 2.0), (1, 0.0), (2, 1.0), (3, 0.5), (4, 3.0)]:
        rate = plain.harmonic_decay_rate(p, m)
        # the integral over the path, in mean free paths
        assert 1 / law.harmonic_decay_rate(p, m) == pytest.approx(
            1 / rate + (-1) ** m * e**p * loops, rel=1e-13
        )
    assert law.mean_log_loss == plain.mean_log_loss
    eta = math.pi * n / 4
    ratio = 1.0 if scatterers == "overlapping" else (1 - eta) ** 2 / (1 - 7 * eta / 16)
    assert law.mean_free_path(n, 1.0) == pytest.approx(ratio / (2 * n), rel=1e-15)


def test_longer_paths_of_the_second_order_do_not_lengthen_the_way(monkeypatch: Any) -> None:
    late_squares = []
    for longer in (medium.LONGER_PATH, 0.0):
        monkeypatch.setattr(medium, "LONGER_PATH", longer)
        one = medium.Medium("hard disks", 0.04, 0.7, "second")
        way = 1 / CollisionLaw(0.7).harmonic_decay_rate(0.0, 1) + one.returns(1)[0]
        late_squares.append(one.path_ratio**2 * way)
    assert late_squares[0] == pytest.approx(late_squares[1], rel=2e-3)


@pytest.mark.filterwarnings("ignore::kinetics.ModelWarning")
@pytest.mark.parametrize(("e", "n"), [(0.95, 0.3), (0.7, 0.04), (0.3, 0.1), (0.05, 0.02)])
@pytest.mark.parametrize("order", ["leading", "second"])
def test_averages_tend_to_the_closed_forms_of_the_operator(e: float, n: float, order: str) -> None:
    """Beyond the leading order returns take time for powers of the speed: not in the operator."""
    among: Any = {"scatterers": "overlapping", "density_order": order}
    found, exact = late(e, n, **among), ScalingSolution(e, number_density=n, **among)
    path = found.scene.mean_free_path
    assert found.diffusion_coefficient.shape == (2,)
    slope = found.msd_slope / path**2
    assert slope == pytest.approx(exact.diffusion_slope, rel=1e-10)
    square = (found.thermal_speed * found.times / path) ** 2
    near = {"rel": 1e-10, "abs": 1e-9} if order == "leading" else {"rel": 0.2 * n, "abs": n}
    assert square == pytest.approx(exact.scaled_speed_moment(2.0), rel=near["rel"])
    assert found.a2 == pytest.approx(exact.a2, abs=near["abs"])
    assert np.diff(found.collisions)[0] * found.scene.law.mean_log_loss == pytest.approx(
        math.log(1e3), rel=1e-10
    )


def test_the_elastic_gas_has_the_coefficient_of_van_leeuwen_and_weijland() -> None:
    found = []
    for n in (1e-6, 1e-7):
        value = [
            solve(Scene(1.0, n, times=[1e4 / n], outputs=("diffusion_coefficient",), **more))
            for more in ({}, {"scatterers": "overlapping", "density_order": "leading"})
        ]
        ratio = value[1].diffusion_coefficient[0] / value[0].diffusion_coefficient[0]
        found.append((ratio - 1) / (n * math.log(n)))
    assert found == pytest.approx([4 / 3, 4 / 3], rel=1e-4)


@pytest.mark.parametrize("order", ["leading", "first", "second"])
def test_a_low_density_is_the_dilute_gas(order: str) -> None:
    n = 1e-9
    times = [10 / n, 1e4 / n]
    dilute = solve(Scene(0.6, n, times=times, outputs=OUTPUTS))
    dense = solve(
        Scene(0.6, n, times=times, outputs=OUTPUTS, scatterers="hard disks", density_order=order)
    )
    for name in OUTPUTS:
        # a2 is a difference of terms of order 1
        assert getattr(dense, name) == pytest.approx(getattr(dilute, name), rel=5e-8, abs=5e-9)
        assert not np.array_equal(getattr(dense, name), getattr(dilute, name))


@pytest.mark.parametrize(
    ("e", "m", "p"),
    slow_but([(1.0, 1, 0), (0.5, 0, 1)], [(1.0, 1, 0), (0.5, 1, 0), (0.5, 2, 0), (0.5, 0, 1)]),
)
def test_the_constants_come_out_of_the_integrals_again(e: float, m: int, p: int) -> None:
    """With a sixteenth of the points: the parts that are no quadrature must be right."""
    row = returns.constants(e, points=13, shifts=4)
    known = json.loads(files("kinetics.collision").joinpath("returns.json").read_text("utf-8"))
    i = known["restitution"].index(e)
    row["d"] = [known["d"][i], 0.0]  # d alone would need more points
    value, error = returns._log_c(row, m, p)
    assert error < 0.25
    assert value == pytest.approx(known[f"ln C {m}"][i], abs=4 * error + 0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "e"), [("hard disks", 0.7), ("overlapping", 0.9)])
def test_a_simulation_meets_the_theory_and_not_the_dilute_equation(name: str, e: float) -> None:
    """<r^2> from 100 to 1000 l/U among n = 0.04; the table is measurements/density.py."""
    found = density.deviations(name, e, 0.04, 40_000)
    late = {row: 100.0 * values[0, density.TIMES >= 100.0] for row, values in found.items()}
    assert np.all(late["error"] < 1.3)
    assert np.all(np.abs(late["second"]) < 3.5 * late["error"])
    assert np.all(np.abs(late["leading"]) < 3.5 * late["error"])
    assert np.all(late["dilute"] < -9.0)


@pytest.mark.parametrize(("e", "n"), [(0.9, 0.1), (0.3, 0.02), (1.0 - 1e-9, 0.02)])
def test_the_scaled_density_has_its_moments(e: float, n: float) -> None:
    """Near e = 1 it took minutes: a step of the recurrence of moments for each of many powers."""
    exact = ScalingSolution(e, scatterers="overlapping", number_density=n)
    width = min(1.0, 12.0 * math.sqrt(1.0 - e))
    x = np.linspace(-2.5 * width, 3.0 * width, 1601)
    c = np.exp(x)
    weight = 2.0 * math.pi * c**2 * np.nan_to_num(exact.vdf(c)) * (x[1] - x[0])
    p = 6.0 if e < 0.5 else 12.0  # slow tracers, of which the operator knows nothing, do not count
    assert weight @ c**p == pytest.approx(exact.moment(p), rel=1e-7)
    if e < 0.99:
        low = exact.vdf(np.geomspace(1e-4, 0.8, 40))
        assert np.isnan(low[0])
        assert np.all(low[np.isfinite(low)] > 0)


@pytest.mark.parametrize("column", ["d", "ln C 0", "ln C 1", "ln C 2", "loops"])
def test_constants_between_those_of_the_table_are_no_straight_lines(column: str) -> None:
    """They are nearer to a polynomial through six points of the table, by a factor of two."""
    known = json.loads(files("kinetics.collision").joinpath("returns.json").read_text("utf-8"))
    values = np.array(known[column])
    points = np.array(known["restitution"])[: values.size]
    middles = np.array([0.45, 0.55, 0.65, 0.75])
    found = []
    smooth = []
    for middle in middles:
        constants = constants_at(float(middle))
        numbers = {"d": constants.more_collisions, "loops": constants.loops}
        numbers |= {f"ln C {m}": constants.log_c[m] for m in range(3)}
        found.append(numbers[column])
        nearest = np.sort(np.argsort(np.abs(points - middle))[:6])
        smooth.append(float(BarycentricInterpolator(points[nearest], values[nearest])(middle)))
    linear = np.interp(middles, points, values)
    assert np.abs(np.subtract(found, smooth)).sum() < 0.5 * np.abs(linear - smooth).sum()

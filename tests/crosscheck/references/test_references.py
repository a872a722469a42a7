"""The references for the position of the tracer, against each other."""

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath as mp
import numpy as np
import pytest

HERE = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def position(formulas: ModuleType) -> ModuleType:
    """position_references.py; it uses kinetic_references.py, loaded before."""
    spec = importlib.util.spec_from_file_location(
        "position_references", HERE / "position_references.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def table() -> Any:
    """position_references.json, written by that file."""
    return json.loads((HERE / "position_references.json").read_text(encoding="utf-8"))


def constant(first: float, second: float) -> Any:
    """Rates of a law that keeps the speed: nu_0 = 0, nu_1 and nu_2 the same at every power."""

    def rates(_: Any, count: int) -> tuple[list[Any], list[Any], list[Any]]:
        return [mp.mpf(0)] * count, [mp.mpf(first)] * count, [mp.mpf(second)] * count

    return rates


@pytest.mark.parametrize("e", [0.0, 0.4, 0.9, 1.0])
def test_the_series_is_the_hierarchy_forward_in_time(position: ModuleType, e: float) -> None:
    with mp.workdps(40):
        early = position.Early(e, 2.0)(2.0)
        forward = position.moments_forward(e, 2.0, 75)
        for a, b in zip(early, forward, strict=True):
            assert abs(a / b - 1) < 1e-35


def test_the_mean_square_is_that_of_the_other_references(
    position: ModuleType, formulas: ModuleType
) -> None:
    with mp.workdps(40):
        for e, t in ((0.05, 7.0), (0.7, 40.0)):
            assert abs(position.square(e, t) / formulas.early_square(e, t) - 1) < 1e-35


def test_flights_before_any_collision_are_straight(position: ModuleType) -> None:
    with mp.workdps(40):
        t = mp.mpf(10) ** -6
        rho, four = position.Early(0.4, 1.0)(t)
        assert abs(rho / t**2 - 1) < 1e-5
        assert abs(four / rho**2 - 1) < 1e-5


@pytest.mark.parametrize("rates", [(4 / 3, 16 / 15), (1.0, 1.0)])
def test_the_elastic_closed_form_is_the_series(
    position: ModuleType, rates: tuple[float, float]
) -> None:
    with mp.workdps(40):
        for t in (0.3, 20.0):
            series = position.Early(1, t, constant(*rates))(t)
            closed = position.elastic_inverse(t, *map(mp.mpf, rates))
            for a, b in zip(series, closed, strict=True):
                assert abs(a / b - 1) < 1e-25
    # <r^2> = 2 D' T with D' = 1/nu_1, and a Gaussian
    rho, four = position.elastic_inverse(1e10, *rates)
    assert float(rho) == pytest.approx(2e10 / rates[0], rel=1e-9)
    assert float(four / rho**2) == pytest.approx(2.0, rel=1e-8)


@pytest.mark.parametrize("t", [0.5, 6.0, 40.0])
def test_the_isotropic_walk_has_its_moments(position: ModuleType, t: float) -> None:
    with mp.workdps(60):
        ring, x = position.isotropic_ring(t), mp.mpf(t)
        series = position.Early(1, t, constant(1.0, 1.0))(t)
        for n, exact in ((2, series[0]), (4, series[1])):

            def integrand(s: Any, n: int = n) -> Any:
                # s = sqrt(t^2 - r^2), r dr = -s ds
                r = mp.sqrt((x - s) * (x + s))
                return position.isotropic_density(r, x) * r ** (n - 1) * s

            found = mp.quad(integrand, [mp.mpf(10) ** -24, x / 2, x], maxdegree=7)
            assert abs((ring * x**n + found) / exact - 1) < 1e-20
        inside = position.isotropic_share(x / 2, x)
        found = mp.quad(lambda r: position.isotropic_density(r, x), [0, x / 4, x / 2])
        assert abs(inside / found - 1) < 1e-20
        assert abs(position.isotropic_share(x, x) + ring - 1) < 1e-25


def test_the_isotropic_scattering_function_has_its_laplace_transform(position: ModuleType) -> None:
    # of F: 1/(sqrt((p+1)^2 + k^2) - 1), flights between isotropic turns
    k, p = 1.3, 2.0
    nodes, weights = np.polynomial.laguerre.laggauss(14)
    with mp.workdps(15):
        found = sum(
            w * float(position.isotropic_scattering(k, x / p)) / p
            for x, w in zip(nodes, weights, strict=True)
        )
        assert found == pytest.approx(1 / (((p + 1) ** 2 + k**2) ** 0.5 - 1), rel=1e-6)
        assert float(position.isotropic_scattering(0, 3.0)) == pytest.approx(1)


def test_the_integrals_meet_the_series(position: ModuleType, monkeypatch: Any) -> None:
    # with a step so wide that exp(-2 pi 0.2/step) = 4e-5 is missing
    monkeypatch.setattr(position, "STEP", mp.mpf(1) / 8)
    monkeypatch.setattr(position, "HALF_LENGTH", 10)
    monkeypatch.setattr(position, "WINDOW", 5)
    with mp.workdps(20):
        lines, early = position.Lines(0.7), position.Early(0.7, 30.0)
        for t in (1.0, 30.0):
            for a, b in zip(lines(t), early(t), strict=True):
                assert abs(a / b - 1) < 3e-4


@pytest.mark.slow
def test_the_integrals_meet_those_of_the_other_references_late(
    position: ModuleType, formulas: ModuleType, numbers: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr(position, "STEP", mp.mpf(1) / 32)
    monkeypatch.setattr(position, "HALF_LENGTH", 36)
    found = numbers["evolution"]["0.4"]["monoenergetic"]["msd"]
    with mp.workdps(30):
        lines = position.Lines(0.4)
        for t, msd in zip(formulas.TIMES, found, strict=True):
            if t > 10:
                value = float(lines(mp.mpf(t) / formulas.FREE_PATH)[0] * formulas.FREE_PATH**2)
                assert value == pytest.approx(msd, rel=1e-14)


# -- the table ------------------------------------------------------------------------------------

TABLED = ["0.0", "0.05", "0.4", "0.7", "0.9", "0.99"]


@pytest.mark.parametrize("e", TABLED)
def test_the_table_joins_series_and_integrals(table: Any, e: str) -> None:
    assert table[e]["series_and_integrals_apart"] < 1e-14
    for start in ("monoenergetic", "gaussian"):
        for name in ("square", "fourth"):
            values = np.array(table[e][start][name])
            assert values.shape == (113,)
            # no step where one route takes over from the other
            bend = np.diff(np.log(values), 3)
            assert np.abs(np.diff(bend)).max() < 0.05


@pytest.mark.parametrize("e", TABLED)
def test_late_in_the_table_the_slopes_are_exact(formulas: ModuleType, table: Any, e: str) -> None:
    value = float(e)
    with mp.workdps(30):
        slope = 2 / (
            formulas.mean_log_loss(value) * (1 - formulas.ratio_power_cosine(value, mp.mpf(0), 1))
        )
    late = np.log(np.array(table["T"][-5:]))
    for start in ("monoenergetic", "gaussian"):
        rho = np.array(table[e][start]["square"][-5:])
        np.testing.assert_allclose(np.diff(rho) / np.diff(late), float(slope), rtol=1e-5)
        # <r^4> = 2 slope^2 ln^2 T + ...: its second difference in ln T
        four = np.array(table[e][start]["fourth"][-5:])
        second = np.diff(four, 2) / np.diff(late)[0] ** 2
        np.testing.assert_allclose(second, 4 * float(slope) ** 2, rtol=1e-4)


def test_the_table_is_made_by_the_formulas_beside_it(position: ModuleType, table: Any) -> None:
    assert table["T"] == position.TIMES
    with mp.workdps(40):
        for e in ("0.0", "0.7"):
            early = position.Early(float(e), 30.0)
            for k in (0, 30, 59):
                pair = [float(x) for x in early(table["T"][k])]
                kept = [table[e]["monoenergetic"][name][k] for name in ("square", "fourth")]
                assert pair == pytest.approx(kept, rel=1e-15)

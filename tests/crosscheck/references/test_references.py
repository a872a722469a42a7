"""The reference values: what is stored is what the formulas give, and two ways to each agree."""

import json
from typing import Any

import collision
import cooling
import displacement
import make as script
import mpmath as mp
import numpy as np
import pytest
from collision import decay_rates

from kinetics import ScalingSolution
from kinetics.crosscheck import references

TABLES = references.load()
DISPLACEMENT = TABLES["displacement"]
TABLED = [key for key in DISPLACEMENT if key != "T"]


def moments_forward(e: float, reduced_time: float, count: int) -> tuple[Any, Any]:
    """<r^2>/l^2 and <r^4>/l^4 by the hierarchy forward in time, in `count` powers of T.

    With w = v exp(i theta) and z = x + i y, mu(p, n, a, b) = <v^p exp(i n theta) z^a conj(z)^b>,
    n = b - a by isotropy, obeys

        mu' = a mu(p+1, n+1, a-1, b) + b mu(p+1, n-1, a, b-1) - nu_n(p) mu(p+1, n, a, b).
    """
    t = mp.mpf(reduced_time)
    rates = [decay_rates(e, m, 0, count + 6) for m in (0, 1, 2)]
    keys = [(a, b) for a in range(3) for b in range(3)]
    # mu[a, b][p] is the coefficient of T^k
    mu = {key: [mp.mpf(1 if key == (0, 0) else 0)] * (count + 4) for key in keys}
    totals = [mp.mpf(0), mp.mpf(0)]
    for k in range(count):
        new = {}
        for a, b in keys:
            nu = rates[abs(a - b)]
            row = []
            for p in range(len(mu[a, b]) - 1):
                value = -nu[p] * mu[a, b][p + 1]
                if a:
                    value += a * mu[a - 1, b][p + 1]
                if b:
                    value += b * mu[a, b - 1][p + 1]
                row.append(value / (k + 1))
            new[a, b] = row
        mu = new
        power = t ** (k + 1)
        totals = [totals[0] + mu[1, 1][0] * power, totals[1] + mu[2, 2][0] * power]
    return totals[0], totals[1]


@pytest.mark.parametrize("e", [0.0, 0.4, 0.9, 1.0])
def test_the_series_of_the_displacement_is_the_hierarchy_forward_in_time(e: float) -> None:
    with mp.workdps(40):
        early = displacement.Early(e, 2.0)(2.0)
        for a, b in zip(early, moments_forward(e, 2.0, 75), strict=True):
            assert abs(a / b - 1) < 1e-35


def test_flights_before_any_collision_are_straight() -> None:
    with mp.workdps(40):
        t = mp.mpf(10) ** -6
        rho, four = displacement.Early(0.4, 1.0)(t)
        assert abs(rho / t**2 - 1) < 1e-5
        assert abs(four / rho**2 - 1) < 1e-5


@pytest.mark.slow
def test_the_integrals_of_the_displacement_meet_its_series(monkeypatch: Any) -> None:
    # with a step so wide that exp(-2 pi 0.2/step) = 4e-5 is missing
    monkeypatch.setattr(displacement, "STEP", mp.mpf(1) / 8)
    monkeypatch.setattr(displacement, "HALF_LENGTH", 10)
    monkeypatch.setattr(displacement, "WINDOW", 5)
    with mp.workdps(20):
        lines, early = displacement.Lines(0.7), displacement.Early(0.7, 30.0)
        for t in (1.0, 30.0):
            for a, b in zip(lines(t), early(t), strict=True):
                assert abs(a / b - 1) < 3e-4


@pytest.mark.slow
def test_two_integrals_of_the_mean_square_agree_late(monkeypatch: Any) -> None:
    monkeypatch.setattr(displacement, "STEP", mp.mpf(1) / 32)
    monkeypatch.setattr(displacement, "HALF_LENGTH", 36)
    stored = TABLES["evolution"]["0.4"]["monoenergetic"]["msd"]
    with mp.workdps(30):
        lines = displacement.Lines(0.4)
        for t, msd in zip(cooling.TIMES, stored, strict=True):
            if t > 10:
                value = float(lines(mp.mpf(t) / cooling.FREE_PATH)[0] * cooling.FREE_PATH**2)
                assert value == pytest.approx(msd, rel=1e-14)


@pytest.mark.parametrize("e", ["0.05", "0.7", "0.99"])
def test_stored_averages_from_integrals_are_the_power_series(e: str) -> None:
    rows = TABLES["evolution"][e]["monoenergetic"]
    k = cooling.TIMES.index(300.0)
    with mp.workdps(40):
        reduced = mp.mpf(300) / cooling.FREE_PATH
        early = cooling.early_power(float(e), 2, reduced) / reduced**2
        square = displacement.Early(float(e), reduced)(reduced)[0] * cooling.FREE_PATH**2
        collisions = cooling.early_collisions(float(e), reduced)
    for name, value in (("v^2", early), ("msd", square), ("collisions", collisions)):
        assert rows[name][k] == pytest.approx(float(value), rel=1e-15, abs=0.0)


@pytest.mark.slow
def test_stored_scaled_densities_are_made_again() -> None:
    with mp.workdps(40):
        for e in ("0.05", "0.6"):
            made, stored = collision.scaled_density(float(e), [2.0]), TABLES["scaled_density"][e]
            k = min(range(len(stored["c"])), key=lambda i: abs(stored["c"][i] - made["c"][0]))
            for name in ("c", "F"):
                assert made[name][0] == pytest.approx(stored[name][k], rel=1e-14, abs=0.0)


# -- the benchmark's table -------------------------------------------------------------------------


@pytest.mark.parametrize("start", references.STARTS)
@pytest.mark.parametrize("e", [0.0, 0.7])
def test_the_benchmarks_values_are_the_power_series(e: float, start: str) -> None:
    k = 20
    first = {"gaussian": cooling.gaussian_moment, "monoenergetic": cooling.one_speed}[start]
    t = references.times("short")[k]
    reduced = mp.mpf(float(t)) / cooling.FREE_PATH
    second, fourth = (cooling.early_power(e, p, reduced, first) / reduced**p for p in (2, 4))
    v0, a2 = (references.kept(name, e, start, "short")[k] for name in ("thermal_speed", "a2"))
    assert v0 == pytest.approx(float(second) ** 0.5, rel=1e-15)
    assert 1 + a2 == pytest.approx(float(fourth / (2 * second**2)), rel=1e-15)
    early = displacement.Early(e, 24 * reduced)
    square, quartic = early.gaussian(reduced) if start == "gaussian" else early(reduced)
    made = {"msd": square * cooling.FREE_PATH**2, "kurtosis": quartic / square**2}
    for quantity, value in made.items():
        stored = references.kept(quantity, e, start, "short")[k]
        assert stored == pytest.approx(float(value), rel=1e-15, abs=0.0)


@pytest.mark.parametrize("start", references.STARTS)
@pytest.mark.parametrize("e", references.RESTITUTIONS)
def test_the_benchmarks_values_begin_in_free_flight_and_end_in_the_scaling_state(
    e: float, start: str
) -> None:
    second, kurtosis = (2.0, 2.0) if start == "gaussian" else (1.0, 1.0)
    # collisions add terms of the order of v t/l = 0.01
    first = references.times("short")[0]
    assert references.kept("msd", e, start, "short")[0] == pytest.approx(
        second * first**2, rel=0.03
    )
    assert references.kept("kurtosis", e, start, "short")[0] == pytest.approx(kurtosis, rel=0.03)
    exact = ScalingSolution(e)
    # corrections are of the order of the value itself over the initial speed; slow tracers of the
    # Gaussian add a logarithm
    late = 2 * references.MEAN_FREE_PATH / (exact.cooling_rate * references.times("long")[-1])
    v0, a2 = (references.kept(name, e, start, "long")[-1] for name in ("thermal_speed", "a2"))
    assert v0 == pytest.approx(late, rel=5 * late)
    assert a2 == pytest.approx(exact.a2, abs=20 * late)


# -- the table of the displacement -----------------------------------------------------------------


@pytest.mark.parametrize("e", TABLED)
def test_the_displacements_join_series_and_integrals(e: str) -> None:
    assert DISPLACEMENT[e]["series_and_integrals_apart"] < 1e-14
    for start in ("monoenergetic", "gaussian"):
        for name in ("square", "fourth"):
            values = np.array(DISPLACEMENT[e][start][name])
            assert values.shape == (113,)
            # no step where one route takes over from the other
            bend = np.diff(np.log(values), 3)
            assert np.abs(np.diff(bend)).max() < 0.05


@pytest.mark.parametrize("e", TABLED)
def test_late_displacements_have_the_exact_slope(e: str) -> None:
    value = float(e)
    with mp.workdps(30):
        turn = decay_rates(value, 1, 0, 1)[0]
        slope = float(2 / (collision.mean_log_loss(value) * turn))
    late = np.log(np.array(DISPLACEMENT["T"][-5:]))
    for start in ("monoenergetic", "gaussian"):
        rho = np.array(DISPLACEMENT[e][start]["square"][-5:])
        np.testing.assert_allclose(np.diff(rho) / np.diff(late), slope, rtol=1e-5)
        # <r^4> = 2 slope^2 ln^2 T + ...: its second difference in ln T
        second = np.diff(DISPLACEMENT[e][start]["fourth"][-5:], 2) / np.diff(late)[0] ** 2
        np.testing.assert_allclose(second, 4 * slope**2, rtol=1e-4)


def test_early_displacements_are_made_again() -> None:
    assert DISPLACEMENT["T"] == displacement.TIMES
    with mp.workdps(40):
        for e in ("0.0", "0.7"):
            early = displacement.Early(float(e), 30.0)
            for k in (0, 30, 59):
                pair = [float(x) for x in early(DISPLACEMENT["T"][k])]
                row = DISPLACEMENT[e]["monoenergetic"]
                assert pair == pytest.approx([row["square"][k], row["fourth"][k]], rel=1e-15)


# -- the file --------------------------------------------------------------------------------------


def test_the_script_writes_what_the_loader_reads(monkeypatch: Any, tmp_path: Any) -> None:
    made = {"0.5": {"gaussian": [0.1, 1e-300]}}
    monkeypatch.setattr(script, "TABLES", {"made": (20, lambda: made), "other": (20, dict)})
    monkeypatch.setattr(mp.mp, "dps", 15)
    path = tmp_path / "values.json"
    path.write_text(json.dumps({"kept": {"T": [1.0]}}))
    script.main([str(path), "made"])
    assert json.loads(path.read_text()) == {"kept": {"T": [1.0]}, "made": made}
    with pytest.raises(SystemExit, match="usage"):
        script.main([str(path), "bogus"])


def test_every_table_of_the_script_is_stored() -> None:
    assert list(TABLES) == list(script.TABLES)
    with pytest.raises(KeyError):
        references.kept("thermal_speed", 0.3, "gaussian", "short")

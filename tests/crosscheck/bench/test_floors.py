"""Floors of the benchmark: counts, rates and the table. No time is asserted."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from kinetics.crosscheck.bench import floor_counts, floors
from kinetics.crosscheck.bench.rates import RATES
from kinetics.crosscheck.bench.record import FAILED, MEASURED
from kinetics.crosscheck.bench.timing import Effort

ONCE = Effort(quick=True, least=1, most=1, seconds=0.0)


@pytest.mark.parametrize("name", ["divisions", "multiply-adds", "exponentials"])
def test_rates_are_measured_once(name: str) -> None:
    rate = RATES.per_second(name)
    assert math.isfinite(rate)
    assert rate > 0.0
    assert RATES.per_second(name) == rate


def test_an_unknown_rate_is_no_rate() -> None:
    with pytest.raises(AttributeError):
        RATES.per_second("miracles")


def test_counts_of_averages() -> None:
    solution = SimpleNamespace(stats={"nodes_per_panel": 14, "initial_points": 50})
    times = np.geomspace(1.0, math.exp(9.5), 100)
    (_, weights, _), (_, sums, _) = floor_counts.averages(solution, times)
    assert weights == (16 * 10 * 50 + 100) * 14
    assert sums == 3 * weights


def test_counts_of_waves_are_the_systems_that_were_solved() -> None:
    from kinetics import Scene, solve

    solution = solve(Scene(0.7, times=[200.0], outputs=("position_density",)), 1e-2)
    counts = floor_counts.waves(solution)
    # at least one harmonic in one panel for each wave number
    assert sum(number for _, number, _ in counts) > solution.stats["wave_numbers"]
    assert all(rate == f"solves of {int(rate.split()[-1])}" for _, _, rate in counts)


def test_counts_of_densities_grow_with_the_times() -> None:
    from kinetics import Scene, solve

    totals = []
    for times in ([10.0], [10.0, 20.0, 40.0]):
        solution = solve(Scene(0.7, times=times, outputs=("speed_density",)), 1e-6)
        counts = {what: number for what, number, _ in floor_counts.densities(solution)}
        totals.append(counts["decay at every time"] / solution.stats["density_nodes_m0"])
    assert totals == [1.0, 3.0]


def test_counts_of_flights_are_those_of_a_traced_flight() -> None:
    # cells that a straight path crosses: 1 + (|dx| + |dy|)/side on average, and the mean of
    # |cos| + |sin| over directions is 4/pi; free paths of points among disks of radius 1
    from particles.grid.cells import cell_side

    run = SimpleNamespace(collision_total=1000)
    (_, cells, _), (_, bounces, _) = floor_counts.flights(run)
    assert bounces == 1000
    rng = np.random.default_rng(3)
    side, angle = cell_side(floor_counts.DENSITY), rng.uniform(0.0, 2.0 * math.pi, 200_000)
    path = rng.exponential((1 - math.pi * 0.04) / 0.08, angle.size)
    start = rng.uniform(0.0, side, (2, angle.size))
    crossed = sum(
        np.abs(np.floor((start[i] + path * f(angle)) / side))
        for i, f in enumerate((np.cos, np.sin))
    )
    # the standard error of the mean is 0.3 %
    assert cells / 1000 == pytest.approx(1.0 + crossed.mean(), rel=0.015)


def test_a_profile_names_where_the_time_goes() -> None:
    def slow() -> None:
        for _ in range(300_000):
            pass

    def quick() -> None:
        pass

    def work() -> None:
        slow()
        quick()

    (name, share), *_ = floors.profile(work)
    assert name == "test_bench_floors.slow"
    assert share > 0.5


def test_rows_and_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> None:
        raise ValueError("no such work")

    works = [
        floors.Piece("sum", "numpy", lambda: np.sum(np.ones(50_000)),
                     lambda found: [("sums", float(found), "multiply-adds")]),
        floors.Piece("broken", "numpy", broken, lambda found: []),
    ]  # fmt: skip
    monkeypatch.setattr(floors, "pieces", lambda effort: iter(works))
    good, bad = floors.floors(ONCE)
    assert good.status == MEASURED
    assert bad.status == FAILED
    assert "no such work" in bad.note
    assert good.extra["counted"][0]["number"] == 50_000
    assert good.extra["ratio"] == pytest.approx(good.seconds / good.extra["floor"])
    text = "\n".join(floors.lines([good, bad]))
    assert "| sum |" in text
    assert "5e+04 multiply-adds (sums)" in text
    assert "broken" not in text


def test_the_pieces_of_the_benchmark_can_be_counted() -> None:
    for piece in floors.pieces(ONCE):
        counts = piece.counts(piece.work())
        assert counts, piece.name
        assert all(number > 0 for _, number, _ in counts), piece.name
        assert all(RATES.per_second(rate) > 0 for _, _, rate in counts)

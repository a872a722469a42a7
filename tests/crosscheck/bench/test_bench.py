"""The benchmark measures what it says: methods, references, errors, failures, comparisons."""

import dataclasses
import itertools
import json
import math
import re
import xml.etree.ElementTree as ElementTree
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from kinetics import CollisionLaw, InputError, ScalingSolution, sonine
from kinetics.crosscheck.bench import (
    BenchReport,
    accuracy,
    analysis,
    compare_bench,
    cost,
    names,
    precision,
    references,
    run,
    run_bench,
    sonine_orders,
    straightforward,
    sweeps,
    throughput,
    timing,
)
from kinetics.crosscheck.bench.command import bench
from kinetics.crosscheck.bench.record import FAILED, MEASURED, NOT_AVAILABLE, Record, timed
from particles.grid.build import build

E = 0.7
ONCE = timing.Effort(quick=True, least=1, most=1, seconds=0.0)


def row(
    method="spectral", seconds=1.0, error=1e-9, spread=0.1, section="precision", **others
) -> Record:
    low, high = (seconds * (1 - spread), seconds * (1 + spread)) if seconds else (None, None)
    values = dict(problem="p", setting="rtol", value=1e-8, repeats=9) | others
    return Record(
        section, method=method, seconds=seconds, low=low, high=high, error=error, **values
    )


def report(*rows, **others) -> BenchReport:
    values = dict(quick=True, cases=("scaled",), machine={"processor": "x"}, seconds=1.0) | others
    return BenchReport(records=tuple(rows), **values)


# -- the methods beside the package ---------------------------------------------------------------


@pytest.mark.parametrize("e", [0.0, 0.3, 0.95])
def test_gain_matrix_keeps_mass_and_the_mean_speed_of_a_bounce(e):
    gain = straightforward.gain_matrix(e, 80)
    assert np.all(gain >= -1e-14)
    assert np.allclose(gain.sum(axis=0), 1.0, atol=1e-13)
    j = np.arange(80.0)
    # hat functions keep <v> exactly; the mean is from the law, which the matrix does not use
    mean = CollisionLaw(e).mean_speed_ratio_power(1.0)
    assert np.allclose((j @ gain)[1:] / j[1:], mean, rtol=1e-12)


def fitted_order(nodes, errors) -> float:
    return -float(np.polyfit(np.log(nodes), np.log(errors), 1)[0])


@pytest.mark.parametrize("e", [0.0, 0.2, 0.7])
def test_straightforward_scaled_solver_is_of_second_order(e):
    nodes = [101, 151, 201, 301, 401, 601]
    exact = ScalingSolution(e)
    found = [straightforward.solve_scaled(e, n, 40.0) for n in nodes]
    errors = [abs(s.cooling_rate / exact.cooling_rate - 1.0) for s in found]
    assert fitted_order(nodes, errors) == pytest.approx(2.0, abs=0.3)
    assert errors[-1] < 3e-3
    c = precision.SCALED_SPEEDS
    assert np.max(np.abs(found[-1].vdf(c) - exact.vdf(c))) < 0.05 * exact.vdf(c).max()


@pytest.mark.parametrize("start", references.STARTS)
def test_straightforward_cooling_converges_to_the_references(start):
    nodes = [33, 49, 65, 97, 129]
    times = references.times("short")
    exact = references.reference("thermal_speed", E, start, "short")
    errors = []
    for n in nodes:
        found = straightforward.solve_cooling(E, references.MEAN_FREE_PATH, start, times, n, 1e-8)
        errors.append(precision.relative(found.thermal_speed, exact))
    # second order for the smooth start, whose finest error is bounded too
    assert fitted_order(nodes, errors) > (1.7 if start == "gaussian" else 0.8)
    assert errors[-1] < 2e-3


@pytest.mark.parametrize("e", [0.65, 0.8, 0.95])
def test_first_sonine_order_is_the_printed_one(e):
    state = sonine_orders.solve_scaled(e, 1)
    assert state.a2 == pytest.approx(float(sonine.a2(e)), rel=1e-11)
    assert state.cooling_rate == pytest.approx(float(sonine.cooling_rate(e)), rel=1e-12)
    c = np.linspace(0.0, 3.0, 7)
    assert np.allclose(state.vdf(c), sonine.vdf(c, state.a2), rtol=1e-12)


def test_sonine_orders_say_when_they_have_no_real_solution():
    with pytest.raises(ValueError, match=r"order = 1: no real solution at restitution 0\.4"):
        sonine_orders.solve_scaled(0.4, 1)


def test_sonine_cooling_gets_better_up_to_order_eight_from_a_gaussian():
    times = references.times("short")
    exact = references.reference("thermal_speed", E, "gaussian", "short")
    errors = []
    for order in (1, 2, 4, 8):
        v0, _ = sonine_orders.solve_cooling(E, 12.5, "gaussian", times, order, 1e-8)
        errors.append(precision.relative(v0, exact))
    assert all(b < 0.7 * a for a, b in itertools.pairwise(errors))
    assert errors[-1] < 2e-3


# -- references -----------------------------------------------------------------------------------


@pytest.mark.parametrize("start", references.STARTS)
@pytest.mark.parametrize("e", [0.0, 0.7])
def test_kept_references_are_the_power_series(e, start):
    k = 20
    t = references.times("short")[k]
    second, fourth = (references.power_by_series(e, p, start, t) for p in (2, 4))
    v0 = references.reference("thermal_speed", e, start, "short")[k]
    a2 = references.reference("a2", e, start, "short")[k]
    assert v0 == pytest.approx(float(second) ** 0.5, rel=1e-15)
    assert 1 + a2 == pytest.approx(float(fourth / (2 * second**2)), rel=1e-15)


@pytest.mark.parametrize("start", references.STARTS)
def test_kept_displacements_are_the_power_series(start):
    k = 20
    square = references.square_displacement(E, start, references.times("short")[k])
    kept = references.reference("msd", E, start, "short")
    assert kept[k] == pytest.approx(float(square), rel=1e-15)
    # ballistic at first: <v^2> t^2 (1 - O(v t/l))
    first = references.times("short")[0]
    second = 2.0 if start == "gaussian" else 1.0
    assert kept[0] == pytest.approx(second * first**2, rel=0.03)


@pytest.mark.parametrize("e", references.RESTITUTIONS)
def test_kept_references_end_in_the_scaling_state(e):
    exact = ScalingSolution(e)
    t = references.times("long")[-1]
    for start in references.STARTS:
        v0 = references.reference("thermal_speed", e, start, "long")[-1]
        # corrections are of the order of the value itself over the initial speed; slow tracers of
        # the Gaussian add a logarithm
        late = 2 * 12.5 / (exact.cooling_rate * t)
        assert v0 == pytest.approx(late, rel=5 * late)
        a2 = references.reference("a2", e, start, "long")[-1]
        assert a2 == pytest.approx(exact.a2, abs=20 * late)


def test_histogram_error_is_the_error_that_was_put_in():
    exact = ScalingSolution(E)
    edges = np.geomspace(0.05, 6.0, 90)
    v0 = 0.3
    fine = np.linspace(edges[:-1], edges[1:], 41, axis=1)
    share = np.trapezoid(2 * np.pi * fine * exact.vdf(fine), fine, axis=1)

    def made_up(probability):
        histogram = SimpleNamespace(
            edges=edges * v0, probability=SimpleNamespace(value=probability[None])
        )
        return SimpleNamespace(
            speed_histogram=histogram, thermal_speed=SimpleNamespace(value=np.array([v0]))
        )

    assert precision.histogram_error(made_up(share), exact.vdf) < 1e-3
    largest = exact.vdf(precision.SCALED_SPEEDS).max()
    k = int(np.argmin(np.abs(edges - 1.0)))
    area = np.pi * (edges[k + 1] ** 2 - edges[k] ** 2)
    wrong = share + 0.1 * largest * area * (np.arange(share.size) == k)
    assert precision.histogram_error(made_up(wrong), exact.vdf) == pytest.approx(0.1, rel=1e-2)


# -- measuring ----------------------------------------------------------------------------------


def clock(times):
    """A clock that shows these times, one at each look."""
    ticks = iter(np.repeat(np.cumsum([0.0, *times]), 2)[1:])
    return lambda: float(next(ticks))


def test_measure_leaves_the_warm_up_apart():
    effort = timing.Effort(quick=True, least=5, most=5, seconds=0.0)
    seconds = [0.9, 0.1, 0.2, 0.3, 0.4, 0.5]
    result, found = timing.measure(lambda: 7, effort, clock(seconds), clock(seconds), gauge=None)
    assert result == 7
    assert found.repeats == 5
    assert found.warm_up == pytest.approx(0.9)
    assert [found.wall.low, found.wall.median, found.wall.high] == pytest.approx([0.2, 0.3, 0.4])
    assert found.cpu.least == pytest.approx(0.1)


def test_long_work_is_timed_once_but_never_by_its_first_call():
    _, found = timing.measure(lambda: 0, timing.FULL, clock([9.0, 3.0]), clock([9.0, 3.0]), None)
    assert (found.repeats, found.warm_up) == (1, 9.0)
    assert found.cpu.median == pytest.approx(3.0)


class Machine:
    """Work of given seconds on a machine that is slow now and then; all of it is made up."""

    def __init__(self, seconds, slow=lambda now: 1.0):
        self.now = 0.0
        self.calls = []
        self.slow = slow
        self.works = {name: self.work(name, s) for name, s in seconds.items()}

    def work(self, name, seconds):
        def run():
            self.calls.append(name)
            self.now += seconds * self.slow(self.now)
            return len(self.calls)

        return run

    def clock(self):
        return self.now

    def measure(self, effort, **others):
        return timing.measure_together(
            self.works, effort, clock=self.clock, cpu_clock=self.clock, **{"gauge": None} | others
        )


def test_repeats_of_all_are_spread_over_the_whole():
    machine = Machine({"a": 0.001, "b": 0.02, "c": 2.0})
    effort = timing.Effort(quick=True, least=3, most=12, seconds=0.05)
    kept = []
    found = machine.measure(effort, keep=lambda name, result: kept.append((name, result)))
    assert {name: t.repeats for name, t in found.items()} == {"a": 12, "b": 3, "c": 1}
    # warm-up, first repeat, then in turns: of what a has left, b has its own half apart
    assert "".join(machine.calls) == "abcabc" + "aaaabaaaaabaa"
    assert kept == list(zip(machine.calls, range(1, len(kept) + 1), strict=True))
    # the wall clock of a busy machine takes no repeats away
    busy = Machine({"a": 0.01})
    found = timing.measure_together(
        busy.works, effort, clock=lambda: 5 * busy.now, cpu_clock=busy.clock, gauge=None
    )
    assert found["a"].repeats == 5
    more = Machine({"a": 0.02, "c": 2.0})
    found = more.measure(effort, least={"a": 10, "c": 10})
    assert {name: t.repeats for name, t in found.items()} == {"a": 10, "c": 2}


def test_no_two_works_are_in_step():
    # 60 works of two turns each; those of the quick one are even in time between them
    machine = Machine({k: 0.1 for k in range(60)} | {"quick": 0.001})
    begins = []
    run = machine.works["quick"]
    machine.works["quick"] = lambda: begins.append(machine.now) or run()
    machine.measure(timing.Effort(quick=True, least=3, most=21, seconds=0.3))
    gaps = np.diff(begins[2:])
    assert gaps.max() < 1.5 * gaps.mean()


def test_a_slow_stretch_is_in_the_spread_of_all_rows_and_decides_none():
    # a third of the time everything takes twice as long
    machine = Machine({k: 0.01 for k in range(9)}, slow=lambda now: 1 + (0.5 < now < 1.1))
    effort = timing.Effort(quick=True, least=9, most=9, seconds=0.0)
    for found in machine.measure(effort).values():
        assert found.cpu.median == pytest.approx(0.01)
        assert found.cpu.high == pytest.approx(0.02)


def test_work_that_takes_too_long_is_not_repeated():
    machine = Machine({"a": 1e-3, "b": 70.0})
    found = machine.measure(timing.Effort(quick=True, least=2, most=2, seconds=0.0))
    assert found["a"].repeats == 2
    assert str(found["b"]) == "its first call took 70 s: not repeated"
    assert machine.calls.count("b") == 1


def test_an_exception_ends_one_work_and_not_the_others():
    def fails_later():
        machine.now += 0.1
        machine.calls.append("c")
        if machine.now > 0.65:
            raise ArithmeticError("lost")

    machine = Machine({"a": 0.1, "b": 0.1})
    machine.works |= {"c": fails_later, "d": lambda: 1 / 0}
    found = machine.measure(timing.Effort(quick=True, least=4, most=4, seconds=0.0))
    assert found["a"].repeats == found["b"].repeats == 4
    assert isinstance(found["c"], ArithmeticError)
    assert machine.calls.count("c") == 3  # warm-up, first, the one that failed
    assert isinstance(found["d"], ZeroDivisionError)
    with pytest.raises(ZeroDivisionError):
        timing.measure(lambda: 1 / 0, timing.QUICK)


def test_error_of_random_work_is_the_rms_over_seeds():
    seeds = {10.0: [], 20.0: []}

    def work(value, seed):
        seeds[value].append(seed)
        return float(seed)

    def sweep(seeded, work):
        return sweeps.Sweep("s", "p", "m", "samples", (10.0, 20.0), work, float, seeded)

    effort = timing.Effort(quick=True, least=1, most=5, seconds=0.0)
    for r in sweeps.run_sweeps([sweep(True, work)], effort):
        assert seeds[r.value] == list(range(1, 7))
        assert r.extra == {"seeds": 6}
        assert r.error == pytest.approx(math.sqrt(91 / 6))
    # what is certain has one error, found once
    looked = []
    certain = sweep(False, looked.append)
    certain = dataclasses.replace(certain, error=lambda _: 0.25)
    assert [r.error for r in sweeps.run_sweeps([certain], effort)] == [0.25, 0.25]


def test_failures_are_rows():
    def work(value):
        if value == 1:
            raise ValueError("too few\nnodes")
        return np.array([np.nan, 1.0]) if value == 2 else np.array([1.0, 1.0])

    sweep = sweeps.Sweep(
        "precision", "p", "m", "nodes", [1, 2, 3], work, lambda x: float(abs(x - 1).max())
    )
    rows = sweeps.run_sweeps([sweep], ONCE)
    assert [r.status for r in rows] == [FAILED, FAILED, MEASURED]
    assert rows[0].note == "ValueError: too few nodes"
    assert rows[1].note == "1 of 2 values are no finite number"
    assert rows[2].error == 0.0


@pytest.mark.parametrize(
    ("reached", "converged", "expected"),
    [
        (1e-9, True, accuracy.WITHIN),
        (0.99e-8, True, accuracy.WITHIN),
        (1.01e-8, True, accuracy.MISSED),
        (1.01e-8, False, accuracy.MISSED_AND_SAID),
        (math.nan, True, accuracy.MISSED),
        (0.9e-10, True, accuracy.BETTER),
    ],
)
def test_verdict_on_asked_and_reached(reached, converged, expected):
    assert accuracy.verdict(1e-8, reached, converged) == expected


# -- what the rows say --------------------------------------------------------------------------


def test_front_holds_what_nothing_beats():
    rows = [row(seconds=s, error=e) for s, e in [(3, 1e-3), (1, 1e-2), (2, 1e-1), (4, 1e-3)]]
    assert [(r.seconds, r.error) for r in analysis.front(rows)] == [(1, 1e-2), (3, 1e-3)]


def test_cost_at_an_error_is_measured_or_bounded_from_below_or_not_reached():
    rows = [row(seconds=1.0, error=1e-3), row(seconds=2.0, error=1e-9)]
    rows += [row("straightforward", seconds=4.0, error=1e-4), row("Sonine", error=0.1)]
    rows += [row("Monte Carlo", seconds=1.0, error=1e-2)]
    assert analysis.cost_at(rows, "spectral", 1e-6) == analysis.Cost(2.0, analysis.MEASURED_THERE)
    dense = analysis.cost_at(rows, "straightforward", 1e-8)
    assert dense.how == analysis.AT_LEAST
    assert dense.seconds == pytest.approx(4e4)
    assert analysis.cost_at(rows, "Monte Carlo", 1e-4).seconds == pytest.approx(1e4)
    assert analysis.cost_at(rows, "Sonine", 1e-3).how == analysis.NOT_REACHED
    assert analysis.cost_at(rows, "spectral", 1e-12).how == analysis.NOT_REACHED


def test_a_quicker_method_below_the_target_is_named():
    rows = [row(seconds=2.0, error=1e-9), row("straightforward", seconds=1.0, error=1e-5)]
    (line,) = analysis.left_and_below(rows, "precision", "spectral", 1e-3)
    assert "straightforward reaches 1.0e-05 in 1 s, spectral in 2 s" in line
    assert not analysis.left_and_below(rows, "precision", "spectral", 1e-6)


def test_monte_carlo_need_from_made_up_rows():
    rows = [row("Monte Carlo", seconds=1e-5 * n, error=2 / n**0.5, value=n) for n in (1e2, 1e4)]
    need = throughput.monte_carlo_need(rows)
    assert need["samples"] == pytest.approx(4e20)
    assert need["slope"] == pytest.approx(-0.5)
    assert need["years"] == pytest.approx(4e15 / throughput.YEAR)
    assert math.isnan(throughput.monte_carlo_need([])["samples"])


def test_exponent_is_fitted_over_the_upper_half():
    work = [1, 2, 4, 8, 16, 32]
    assert cost.fitted_exponent(work, [5, 5, 5, 8**1.5, 16**1.5, 32**1.5]) == pytest.approx(1.5)
    assert math.isnan(cost.fitted_exponent([1, 2], [1.0, 2.0]))


# -- comparison ------------------------------------------------------------------------------------


def changed(new: Record, old: Record, **others) -> str:
    (change,) = compare_bench(report(new, **others), report(old)).changes
    return change.mark


def test_comparison_marks_what_left_the_spread():
    old = row(seconds=1.0, spread=0.1)
    assert changed(row(seconds=1.15, spread=0.1), old) == ""
    assert changed(row(seconds=1.3, spread=0.1), old) == "slower"
    assert changed(row(seconds=0.7, spread=0.1), old) == "faster"
    # runs differ by more than the repeats within one
    sharp = row(seconds=1.0, spread=0.001)
    assert changed(row(seconds=1.15, spread=0.001), sharp) == ""
    assert changed(row(seconds=0.87, spread=0.001), sharp) == ""
    assert changed(row(seconds=1.27, spread=0.001), sharp) == "slower"
    # the shortest repeats have to differ too
    assert changed(row(seconds=1.5, least=1.1), row(seconds=1.0, least=0.99)) == ""
    assert changed(row(seconds=1.5, least=1.4), row(seconds=1.0, least=0.99)) == "slower"
    # without a spread a quarter is taken for it
    assert changed(row(seconds=1.3, spread=0.0, repeats=1), row(spread=0.0, repeats=1)) == ""
    assert changed(row(seconds=2.0, spread=0.0, repeats=1), row(spread=0.0, repeats=1)) == "slower"


def test_comparison_is_in_units_of_the_yardstick():
    # a machine of half the speed, and one where only the row got slower
    slow = row(seconds=2.0, yardstick=2e-3)
    fast = row(seconds=1.0, yardstick=1e-3)
    found = compare_bench(report(slow), report(fast))
    assert found.changes[0].ratio == pytest.approx(1.0)
    assert not found.marked()
    assert "The yardstick took 2.00 times as long" in found.markdown()
    assert changed(row(seconds=2.0, yardstick=1e-3), fast) == "slower"
    assert changed(row(seconds=1.0, yardstick=2e-3), fast) == "faster"


def test_wall_clock_times_are_not_judged_where_others_want_the_processor():
    def run(share, two_threads):
        return report(
            *(row(value=k, seconds=0.1, wall=0.1 * share) for k in range(3)),
            row(section="cores", threads=2, seconds=two_threads, wall=two_threads),
        )

    assert compare_bench(run(1.0, 3.0), run(1.01, 1.0)).marked("slower")
    found = compare_bench(run(1.6, 3.0), run(1.01, 1.0))
    assert not found.marked()
    assert "Others wanted the processor" in found.markdown()


def measured_on_a_noisy_machine(seconds, seed) -> BenchReport:
    """Repeats of 200 works scatter by 8 %; a fifth of the time all takes 1.4 times as long."""
    rng = np.random.default_rng(seed)
    begin = rng.uniform(0.0, 4.0)

    def slow(now):
        return rng.lognormal(0.0, 0.08) * (1.0 + 0.4 * (begin < now % 5.0 < begin + 1.0))

    machine = Machine(dict(enumerate(seconds)), slow)
    unit = machine.work("unit", 0.001)
    effort = timing.Effort(quick=True, least=3, most=11, seconds=0.04)
    timings = machine.measure(effort, gauge=unit)
    return report(*(timed("s", "p", "m", t, setting="n", value=k) for k, t in timings.items()))


def test_what_is_slower_by_half_is_marked_and_noise_is_not():
    seconds = np.geomspace(0.001, 0.1, 200)
    changed_rows = np.arange(0, 200, 10)
    slower = seconds.copy()
    slower[changed_rows] *= 1.5
    seen, wrong = 0, 0
    for seed in range(5):
        old = measured_on_a_noisy_machine(seconds, 2 * seed)
        new = measured_on_a_noisy_machine(slower, 2 * seed + 1)
        marked = {int(c.row.value) for c in compare_bench(new, old).marked("slower")}
        seen += len(marked & set(changed_rows))
        wrong += len(marked - set(changed_rows))
    assert seen >= 85  # of 100
    assert wrong <= 9  # of 900


def test_comparison_marks_errors_failures_and_rows_of_one_run():
    old = row(error=1e-9)
    assert changed(row(error=5e-9), old) == ""
    assert changed(row(error=2e-8), old) == "less accurate"
    assert changed(row(error=5e-13), row(error=1e-15)) == ""  # rounding
    # what is within the error asked for is accurate enough
    assert changed(row(error=2e-8, asked=1e-7), old) == ""
    assert changed(row(error=2e-7, asked=1e-7), old) == "less accurate"
    broken = row(seconds=None, error=None, status=FAILED)
    assert changed(broken, old) == "fails now"
    assert changed(old, broken) == "works now"
    found = compare_bench(report(row(value=1.0)), report(row(value=2.0)))
    assert [c.mark for c in found.changes] == ["new", "gone"]
    found = compare_bench(report(row(value=1.0), cases=("a",)), report(row(value=2.0)))
    assert [c.mark for c in found.changes] == ["new"]
    with pytest.raises(InputError, match="is a full run, this one is a quick run"):
        compare_bench(report(row()), report(row(), quick=False))


def test_comparison_prints_ratios_and_says_when_the_machine_differs():
    slow = row(seconds=3.0, error=1.0)
    text = compare_bench(report(slow), report(row())).markdown()
    assert "| p | spectral | rtol = 1e-08 | 3.00 | less accurate, slower |" in text
    assert "| precision | 1 | 3.00 |" in text
    assert "another machine" not in text
    other = report(row(), machine={"processor": "y"})
    assert "another machine" in compare_bench(report(slow), other).markdown()


# -- the report ---------------------------------------------------------------------------------


def full_report() -> BenchReport:
    rows = [row(problem=f"scaled F(c), e = {E}", seconds=1e-3, error=1e-12)]
    rows += [row("straightforward", problem=rows[0].problem, seconds=s, error=e, value=s)
             for s, e in ((0.01, 1e-2), (0.1, 1e-3))]  # fmt: skip
    rows += [row("Monte Carlo", problem=rows[0].problem, seconds=1.0, error=1e-2, value=1e4)]
    rows += [Record("precision", "G(R)", "spectral", status=NOT_AVAILABLE, note="not there yet")]
    rows += [Record("precision", "scaled h", "Sonine", status=FAILED, note="order = 1: no root")]
    rows += [row(section="accuracy", problem="1 + a2(t)", asked=1e-8, note=accuracy.MISSED,
                 seconds=None, error=3e-8, extra={"ratio": 3.0, "converged": True})]  # fmt: skip
    rows += [row(section="skipping", method=m, extra={"ratio": r}) for m, r in (("a", 1), ("b", 5))]
    rows += [row(section="cost", method="spectral", setting="nodes", value=v, seconds=v)
             for v in (10.0, 20.0)]  # fmt: skip
    rows += [Record("cost", "p", "spectral", "nodes, exponent", extra={"exponent": 1.0})]
    rows += [row(section="particles", method="particles", threads=n, extra={
                 "collisions_per_second": 2e7 * n, "placing_seconds_per_medium": 1e-3})
             for n in (1, 2)]  # fmt: skip
    rows += [row(section="cores", threads=n, seconds=1.0 / n) for n in (1, 2)]
    rows += [row(section="first use", problem="compile time", wall=2.0)]
    return report(*rows)


def test_report_lists_everything_and_what_failed():
    text = full_report().markdown()
    for expected in (
        "| scaled F(c), e = 0.7 | straightforward | 100 ms | ≥ 100 s |",
        "| scaled F(c), e = 0.7 | 100 | ≥ 1.0e+07 |",
        "| 1e-08 | 1 | 3.0e+00 | 3.0e+00 | 3.0e+00 | 1 | 0 | 0 |",
        "| p | b | 1 s | 5 |",
        "| p | spectral | nodes 10 to 20 | 10 s to 20 s | 1.00 |",
        "| p | 20.0 | 40.0 | 1 ms |",
        "| p | spectral | 1 s | 500 ms | 2.00 |",
        "| compile time | 1 s | 2 s |",
        "| not available | G(R) | spectral |  | not there yet |",
        "| failed | scaled h | Sonine |  | order = 1: no root |",
    ):
        assert expected in text
    assert "no other method is quicker" in text


def test_summary_has_a_line_for_each_family_and_method():
    rows = []
    for e, seconds in ((0.2, 3.0), (0.7, 1.0), (0.95, 2.0)):
        name = f"v0(t), a2(t), gaussian, t <= 1e+02, e = {e:g}"
        rows += [row(problem=name, seconds=seconds, error=1e-9 * seconds)]
        rows += [row("Sonine", problem=name, seconds=1e-4, error=1e-4 if e == 0.95 else 0.1)]
    text = report(*rows).markdown()
    assert text.index("## Summary") < text.index("## Run time for an error")
    # medians of three restitutions; in two of three the order never gets there
    assert "| v₀(t), a₂(t), t ≤ 10² | spectral | 2 s | 2 s | 2e-09 |" in text
    assert "| v₀(t), a₂(t), t ≤ 10² | Sonine | - | - | 1e-01 |" in text


@pytest.mark.parametrize(
    ("plain", "family", "set_out"),
    [
        ("scaled h and a2, e = 0.95", "scaled h and a2", "scaled h and a₂, e = 0.95"),
        ("<r^2>(t), monoenergetic, t <= 1e+08, e = 1e-10", "<r^2>(t), t <= 1e+08",
         "⟨r²⟩(t), monoenergetic, t ≤ 10⁸, e = 10⁻¹⁰"),
        ("hard disks, 0.04 per d^2, 10000",) * 2 + ("hard disks, 0.04 per d², 10000",),
    ],
)  # fmt: skip
def test_names_have_families_and_are_set_out(plain, family, set_out):
    assert names.family(plain) == family
    assert names.typeset(plain) == set_out


def test_report_names_what_is_too_accurate():
    def pair(problem, asked, ratio):
        note = accuracy.verdict(asked, asked * ratio, True)
        return Record("accuracy", problem, "spectral", "rtol", asked, error=asked * ratio,
                      asked=asked, note=note, extra={"ratio": ratio})  # fmt: skip

    rows = [pair("v0(t), gaussian, t <= 1e+02, e = 0.7", a, r)
            for a, r in ((1e-3, 0.5), (1e-5, 2e-3), (1e-8, 5e-4))]  # fmt: skip
    rows += [pair("scaled F(c), e = 0.7", 1e-8, 0.02)]
    text = report(*rows).markdown()
    assert "| v₀(t), t ≤ 10² | 2 of 3 | 5e-04 | v₀(t), gaussian, t ≤ 10², e = 0.7 |" in text
    assert "| scaled F(c) |" not in text


def test_report_shows_the_size_of_the_cells():
    rows = [
        row(section="particles", method="particles", problem="cells, 0.04 per d^2", value=listed,
            setting=throughput.LISTED, extra={"collisions_per_second": rate})
        for listed, rate in ((1.0, 1e7), (5.0, 2.5e7), (20.0, 2e7))
    ]  # fmt: skip
    text = report(*rows).markdown()
    assert "| cells, 0.04 per d^2 | 1 | 10.0 | 0.40 |" in text
    assert "| cells, 0.04 per d^2 | 5, the default | 25.0 | 1.00 |" in text
    assert "## Particles" not in text


def test_cells_of_the_benchmark_list_what_it_says():
    effort = dataclasses.replace(ONCE, quick=True)
    sides = []
    for _, listed, medium in throughput._cells(effort):
        side = build(medium, np.uint64(1), 0).side
        # corners counted as if circles were square; the box holds a whole number of cells
        assert medium.number_density * (side + 2) ** 2 == pytest.approx(listed, rel=0.2)
        sides.append(side)
    assert sides == sorted(sides)


def test_report_survives_json():
    before = full_report()
    text = before.to_json()
    json.loads(text, parse_constant=pytest.fail)  # strict: no NaN, no Infinity
    after = BenchReport.from_json(text)
    assert after == before
    assert not compare_bench(after, before).marked()


OTHER = report().to_json().replace("bench 1", "bench 0")


@pytest.mark.parametrize("text", ["", "[]", '{"format": "else"}', "{}", '{"records": 3}', OTHER])
def test_what_is_no_benchmark_is_refused(text):
    with pytest.raises(InputError, match="holds no benchmark"):
        BenchReport.from_json(text)


def test_figures_are_svg_with_labels_and_units():
    figures = full_report().figures()
    assert {"precision-scaled.svg", "accuracy.svg", "cost.svg", "skipping.svg"} <= set(figures)
    for text in figures.values():
        root = ElementTree.fromstring(text)
        assert root.tag.endswith("svg")
    first = figures["work-precision.svg"]
    assert len(first) < 150_000
    # real text of 10 px and more where it is 900 px wide
    assert ElementTree.fromstring(first).get("width") == "675pt"
    assert min(float(size) for size in re.findall(r"font-size: ([0-9.]+)px", first)) >= 7.5
    assert "run time, one thread [s]" in figures["precision-scaled.svg"]
    assert "largest relative error" in figures["precision-scaled.svg"]
    assert full_report().figures() == figures


def test_unknown_cases_are_refused():
    with pytest.raises(InputError, match="'scale'; known are scaled"):
        run_bench(cases=["scale"])
    with pytest.raises(InputError, match="got none"):
        run_bench(cases=[])


def test_a_case_that_dies_is_a_failed_row(monkeypatch):
    # the child process does not know this case
    monkeypatch.setitem(run.CASES, "dies", ("nowhere", "nothing", (1,)))
    found = run_bench(quick=True, cases=["dies"])
    assert [(r.status, r.section) for r in found.records] == [(FAILED, "dies")]
    assert "dies" in found.records[0].note


def test_accuracy_in_its_own_process_keeps_what_was_asked():
    stages = []
    found = run_bench(quick=True, cases=["accuracy"], progress=stages.append)
    assert stages == ["accuracy"]
    assert {r.section for r in found.records} == {"accuracy"}
    assert all(r.status == MEASURED for r in found.records)
    missed = [r for r in found.records if r.note == accuracy.MISSED]
    assert not missed, [(r.problem, r.asked, r.error) for r in missed]
    assert found.machine["cores"] >= 1


def test_command_prints_compares_and_writes(monkeypatch, tmp_path):
    made = full_report()
    monkeypatch.setattr(run, "run_bench", lambda quick, cases, tell: made)
    old = tmp_path / "old.json"
    old.write_text(made.to_json())
    runner = CliRunner()
    done = runner.invoke(bench, ["--quick", "--compare", str(old), "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "Compared with the earlier run" in done.output
    assert {p.name for p in (tmp_path / "out").iterdir()} >= {"bench.json", "bench.md", "cost.svg"}
    done = runner.invoke(bench, ["--json", "--case", "scaled"])
    assert BenchReport.from_json(done.stdout) == made
    old.write_text("{}")
    failed = runner.invoke(bench, ["--compare", str(old)])
    assert isinstance(failed.exception, ValueError)


def test_the_yardstick_is_measured_among_the_repeats():
    machine = Machine({"a": 0.01})
    effort = timing.Effort(quick=True, least=3, most=3, seconds=0.0)
    (found,) = machine.measure(effort, gauge=machine.work("unit", 0.002)).values()
    assert found.yardstick == pytest.approx(0.002)
    assert machine.calls.count("unit") == 52
    # spread over the whole: the two that a has left are half of it apart
    *_, third, last = (k for k, name in enumerate(machine.calls) if name == "a")
    assert last - third == pytest.approx(26, abs=1)


@pytest.mark.parametrize("effort", [timing.QUICK, timing.FULL])
def test_no_medium_is_measured_twice(effort):
    found = [name for name, _ in throughput._media(effort)]
    assert len(found) == len(set(found))

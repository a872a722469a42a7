"""The reference values: what is stored is what the formulas give.

That the formulas are right is seen where the solver, which shares nothing with them, meets their
values: tests/kinetics/moments, tests/kinetics/scaling, tests/kinetics/densities.
"""

import collision
import cooling
import displacement
import make as script
import mpmath as mp
import pytest

from kinetics.crosscheck import references

TABLES = references.load()
DISPLACEMENT = TABLES["displacement"]


@pytest.mark.parametrize("e", ["0.05", "0.7", "0.99"])
def test_stored_averages_from_integrals_are_the_power_series(e: str) -> None:
    rows = TABLES["evolution"][e]["monoenergetic"]
    k = cooling.TIMES.index(300.0)
    with mp.workdps(40):
        reduced = mp.mpf(300) / cooling.FREE_PATH
        early = cooling.early_power(float(e), 2, reduced) / reduced**2
        square = displacement.Early(float(e), reduced)(reduced)[0] * cooling.FREE_PATH**2
        collisions = cooling.early_power(float(e), 1, reduced, integrated=True)
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


def test_early_displacements_are_made_again() -> None:
    assert DISPLACEMENT["T"] == displacement.TIMES
    with mp.workdps(40):
        for e in ("0.0", "0.7"):
            early = displacement.Early(float(e), 30.0)
            for k in (0, 30, 59):
                pair = [float(x) for x in early(DISPLACEMENT["T"][k])]
                row = DISPLACEMENT[e]["monoenergetic"]
                assert pair == pytest.approx([row["square"][k], row["fourth"][k]], rel=1e-15)


def test_every_table_of_the_script_is_stored() -> None:
    assert list(TABLES) == list(script.TABLES)
    with pytest.raises(KeyError):
        references.kept("thermal_speed", 0.3, "gaussian", "short")

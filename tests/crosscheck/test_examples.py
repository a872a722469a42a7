"""The examples run, and their numbers are right (slow; CI runs them)."""

import runpy
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.slow
ROOT = Path(__file__).resolve().parents[2]


def test_every_example_is_tested() -> None:
    found = {p.stem for p in (ROOT / "examples").glob("*.py")}
    tested = "compare_formats localisation neutrons overview percolation sonine_convergence"
    assert found == {*tested.split()}


def test_overview_example(tmp_path: Path) -> None:
    result = runpy.run_path(str(ROOT / "examples" / "overview.py"))
    value, error = result["PARTICLES"].T
    assert np.all(error < 0.012 * result["EXACT"])
    assert np.all(abs(value - result["EXACT"]) < 4.5 * error)
    (path,) = result["RUN"].trajectories(tracers=1)
    assert len(path.speeds) > 5
    assert np.all(np.diff(path.speeds) < 0)
    result["draw"](str(tmp_path / "figure.png"))
    assert 10_000 < (tmp_path / "figure.png").stat().st_size < 200_000


def test_compare_formats_example() -> None:
    results = runpy.run_path(str(ROOT / "examples" / "compare_formats.py"))["RESULTS"]
    assert len(results) == 6
    plain = results.pop("run.csv")
    assert plain.verdict == "agrees"
    # With configurations known p-values are others.
    assert results.pop("ours.h5md").verdict == "agrees"
    for result in results.values():
        assert result.verdict == plain.verdict
        assert [test.p_value for test in result.tests] == [test.p_value for test in plain.tests]


def test_sonine_convergence_example() -> None:
    result = runpy.run_path(str(ROOT / "examples" / "sonine_convergence.py"))
    series, exact = result["SERIES"], result["EXACT"]
    # away from the exact rate for e = 0.4, near and past it for e = 0.9
    rate = {(e, n): values[0] / exact[e][0] for (e, n), values in series.items()}
    assert [round(rate[0.4, n], 2) for n in (2, 10, 20)] == [0.88, 0.61, 0.47]
    assert [round(rate[0.9, n], 2) for n in (1, 5, 10, 20)] == [1.17, 1.0, 0.93, 1.01]
    assert np.isnan(rate[0.4, 1])
    assert series[0.9, 20][1] == pytest.approx(-0.3957, abs=1e-4)


def test_percolation_example() -> None:
    result = runpy.run_path(str(ROOT / "examples" / "percolation.py"))
    unit = np.sqrt(9.81 / (np.pi * 3e-3**2 * 7.4e5))  # sqrt(g l)
    assert result["VELOCITY"] == pytest.approx(result["STATE"].drift * unit, rel=1e-12)
    assert result["SOLVER_ERROR"] < 1e-8 < result["MEASUREMENT_ERROR"] < 0.03
    value, error = result["PARTICLE_VELOCITY"]
    assert abs(value - result["VELOCITY"]) < 4 * error < 0.03
    assert result["FALL_DEPTH"][0] == pytest.approx(1.0, rel=1e-3)
    value, error = result["PARTICLE_DEPTH"]
    assert abs(value - 1.0) < 4 * error < 0.01
    assert result["PARTICLE_SPREAD"] == pytest.approx(result["SPREAD"][0], rel=0.03)


def test_neutrons_example() -> None:
    result = runpy.run_path(str(ROOT / "examples" / "neutrons.py"))
    run, solution = result["RUN"], result["SOLUTION"]
    for name in ("thermal_speed", "msd"):
        found = getattr(run, name)
        assert np.all(found.error < 0.01 * found.value)
        assert np.all(abs(found.value - getattr(solution, name)) < 4 * found.error)
    xi, cosine = 0.157768989824, 2 / 36
    assert result["AGE"] == pytest.approx(2.6**2 / (3 * xi * (1 - cosine)), rel=1e-9)


def test_localisation_example(tmp_path: Path) -> None:
    result = runpy.run_path(str(ROOT / "examples" / "localisation.py"))
    # between a Gaussian and an exponential, with a rate that goes on growing
    for e, (exponent, rate) in result["TAILS"].items():
        known = ~np.isnan(exponent)
        assert known.sum() >= (5 if e == 0.9 else 6)
        assert np.all((exponent[known] > 1.19) & (exponent[known] < 1.76))
        assert np.all(np.diff(exponent[known]) < 0)
        assert np.all(np.diff(rate[known]) > 0)
        assert rate[0] < 2.83 < rate[1]
    result["draw"](str(tmp_path / "figure.png"))
    assert (tmp_path / "figure.png").stat().st_size > 10_000

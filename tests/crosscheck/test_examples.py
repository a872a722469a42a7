"""The examples and the README's own run, and their numbers are right."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


def test_every_example_is_tested() -> None:
    assert {p.name for p in (ROOT / "examples").glob("*.py")} == {
        "compare_data.py",
        "cooling_gas.py",
        "cooling_rate.py",
        "sonine_convergence.py",
    }


def test_cooling_rate_example() -> None:
    table = runpy.run_path(str(ROOT / "examples" / "cooling_rate.py"))["TABLE"]
    for e, exact, solver, particles, sonine, fitted in table:
        assert solver == pytest.approx(exact, rel=1e-10)
        # 50 000 tracers give 1/v0 to 0.3 %: 2 % is 6 sigma
        assert particles == pytest.approx(exact, rel=0.02)
        assert np.isnan(sonine) == (e < 0.58)
        assert fitted == pytest.approx(exact, rel=0.1)


def test_cooling_gas_example() -> None:
    result = runpy.run_path(str(ROOT / "examples" / "cooling_gas.py"))
    # 7 times each, correlated: 4.5 sigma is passed by chance once in 10 000 seeds.
    assert np.abs(result["speed_sigmas"]).max() < 4.5
    assert np.abs(result["msd_sigmas"]).max() < 4.5


def test_compare_data_example() -> None:
    result = runpy.run_path(str(ROOT / "examples" / "compare_data.py"))
    assert result["RIGHT"].verdict == "agrees"
    assert result["WRONG"].verdict == "differs"
    explaining = [item for item in result["WRONG"].explanations if item.outcome == "explains"]
    assert explaining[0].name == "restitution"
    assert explaining[0].value == pytest.approx(0.75, abs=0.004)
    found = result["FOUND"].parameters
    assert found["restitution"].value == pytest.approx(0.75, abs=0.01)
    assert found["number_density"].value == pytest.approx(0.04, rel=0.03)


def test_sonine_convergence_example(tmp_path: Path) -> None:
    result = runpy.run_path(str(ROOT / "examples" / "sonine_convergence.py"))
    series, exact = result["SERIES"], result["EXACT"]
    # the elastic coefficient converges, from below
    elastic = np.array(list(result["ELASTIC"].values())) / result["ELASTIC_EXACT"]
    assert np.all(np.diff(elastic) > 0)
    assert elastic[0] == pytest.approx(0.849, abs=1e-3)
    assert elastic[-1] == pytest.approx(0.9974, abs=1e-4)
    # the cooling rate does not: away for e = 0.4, near and past it for e = 0.9
    rate = {(e, n): values[0] / exact[e][0] for (e, n), values in series.items()}
    assert [round(rate[0.4, n], 2) for n in (2, 10, 20)] == [0.88, 0.61, 0.47]
    assert [round(rate[0.9, n], 2) for n in (1, 5, 10, 20)] == [1.17, 1.0, 0.93, 1.01]
    assert np.isnan(rate[0.4, 1])
    assert series[0.9, 20][1] == pytest.approx(-0.3957, abs=1e-4)
    result["draw"](str(tmp_path / "figure.png"))
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_the_example_of_the_readme_prints_what_it_says(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})
        printed = capsys.readouterr().out.splitlines()
        said = re.findall(r"# prints (.*)", block)
        assert said
        assert printed == said


def test_the_two_commands_of_the_readme_stand_alone_on_their_lines() -> None:
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert "python -m pip install -e . && lorentz report" in lines
    assert "python -m pip install -e '.[test]' && python -m pytest" in lines

"""The examples and the README's own run, and their numbers are right."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


def test_every_example_is_tested() -> None:
    assert {p.name for p in (ROOT / "examples").glob("*.py")} == {
        "cooling_gas.py",
        "cooling_rate.py",
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

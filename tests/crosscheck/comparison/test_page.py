"""The page, the JSON and the figures of a comparison, and the command that writes them."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pages import Page, check_alone, check_in_browser

from kinetics import Scene, solve
from kinetics.crosscheck import Comparison, compare
from kinetics.crosscheck.comparison.page import render
from kinetics.crosscheck.comparison.result import OBSERVABLES, OUTCOMES
from particles import BoltzmannGrad, simulate

TIMES = np.array([0.0, 2.0, 20.0, 200.0])
EVIL = "<script>alert('x')</script>&\""
COLUMNS = "time,x,y,vx,vy,tracer,medium"


def run_of(seed: int = 4) -> Any:
    return simulate(
        BoltzmannGrad(0.04), restitution=0.75, times=TIMES, media=40, tracers=50, seed=seed,
        workers=1, observables=("positions", "velocities"),
    )  # fmt: skip


@pytest.fixture(scope="module")
def csv(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """2000 tracers at four times."""
    run = run_of()
    n = 2000
    label = np.tile(np.arange(n), TIMES.size)
    table = np.column_stack(
        [np.repeat(TIMES, n), run.positions.reshape(-1, 2), run.velocities.reshape(-1, 2), label,
         label // 50]
    )  # fmt: skip
    path = tmp_path_factory.mktemp("data") / "data.csv"
    np.savetxt(path, table, delimiter=",", header=COLUMNS, comments="", fmt="%.12g")
    return path


@pytest.fixture(scope="module")
def differing() -> Comparison:
    """With a wrong density, so that there is something to explain."""
    outputs = ("thermal_speed", "a2", "msd", "kurtosis", "speed_density")
    return compare(solve(Scene(0.75, 0.06, times=TIMES, outputs=outputs), rtol=1e-6), run_of())


@pytest.fixture(scope="module")
def text(differing: Comparison) -> str:
    """Drawn once: that takes most of the time of these tests."""
    return render(differing, "page.json")


def test_the_page_needs_nothing_beside_it(differing: Comparison, text: str) -> None:
    assert check_alone(text, len(differing.figures)).tags.count("math") == 3


def test_every_number_is_in_the_page_and_in_the_json(differing: Comparison, text: str) -> None:
    from kinetics.crosscheck.numerals import number, numeral

    document = json.loads(differing.to_json(), parse_constant=lambda c: pytest.fail(c))
    assert document == differing.document()
    assert document["schema"] == "inelastic-lorentz/comparison/1"
    text = Page(text).words
    wanted = {"observable", "time", "value", "error", "theory", "sigmas", "verdict"}
    for row in document["rows"]:
        assert wanted <= set(row)
        assert row["observable"] in OBSERVABLES
        assert number(row["value"], row["error"]) in text
    for test in document["tests"]:
        assert numeral(test["chi_square"], ".4g") in text
        assert numeral(test["p_value"], ".2g") in text
    for item in document["explanations"]:
        assert item["text"] in text
        assert OUTCOMES[item["outcome"]] in text
    names = {"thermal-speed", "a2", "msd", "kurtosis", "sigmas", "speed-density"}
    assert set(document["figures"]) == names
    for data in document["figures"].values():
        assert data["x"]["label"]
        for series in data["series"]:
            assert len(series["x"]) == len(series["y"]) > 1
            assert series["error"] is None or len(series["error"]) == len(series["x"])


def test_the_page_opens_with_the_cause_and_draws_it(differing: Comparison, text: str) -> None:
    found = Page(text)
    words = found.words
    best = differing.explanations[0]
    assert best.outcome == "explains"
    cause = words.index(f"The likeliest cause: {best.headline}; it explains the difference.")
    assert words.index("Differs. They differ;") < cause < words.index("How to read the verdicts")
    # the average that fits least leads, with the best explanation over the equation below it
    averages = [t for t in differing.tests if t.time is None]
    least = max(averages, key=lambda t: t.sigmas).observable.replace("_", "-")
    figures = [i for i in found.ids if i.startswith("figure-")]
    assert figures[0] == f"figure-{least}"
    below = differing.figures[least]["ratio"]["series"]
    assert [s["source"] for s in below] == ["zero", "data", "best explanation"]
    row = next(r for r in differing.observable(least.replace("-", "_")) if r.time > 0)
    assert below[1]["y"][0] == pytest.approx(row.value / row.theory)
    assert below[1]["error"][0] == pytest.approx(row.error / row.theory)


def test_verdicts_are_words_that_are_explained_first(text: str) -> None:
    shown = re.findall(r'<span class="verdict \w+">([^<]*)</span>', text)
    assert shown[0] == "Differs."
    assert set(shown[1:]) <= {"no difference", "unclear", "differs"}
    assert set(shown[1:4]) == {"no difference", "unclear", "differs"}
    assert re.search(r'no difference</span><span class="more">, better than \d', text)


def test_texts_from_the_data_are_escaped(differing: Comparison) -> None:
    figures = {"msd": differing.figures["msd"]}
    evil = replace(
        differing, names=(EVIL,), warnings=(EVIL,), initial=EVIL, summary=EVIL, figures=figures
    )
    text = render(evil, EVIL)
    assert "<script" not in text
    assert Page(text).text.count(EVIL) >= 6


def test_the_command_prints_rows_as_json(csv: Path, lorentz: Any) -> None:
    before = csv.read_bytes()
    document = lorentz.json("compare", str(csv), "-e", "0.75", "--number-density", "0.04")
    assert document["verdict"] == "agrees"
    assert document["data"] == {
        "names": ["data.csv"], "samples": 2000, "groups": 40, "grouping": "medium",
    }  # fmt: skip
    speeds = [row for row in document["rows"] if row["observable"] == "thermal_speed"]
    assert [row["time"] for row in speeds] == TIMES.tolist()
    for row in speeds:
        assert row["sigmas"] == pytest.approx((row["value"] - row["theory"]) / row["error"])
        assert row["verdict"] == "agrees"
    assert csv.read_bytes() == before


def test_the_command_prints_a_table(csv: Path, lorentz: Any) -> None:
    text = lorentz("compare", str(csv), "-e", "0.6", "--number-density", "0.04")
    assert text.startswith("They differ; e = 0.7")
    assert re.search(r"^thermal_speed +200 .*differs$", text, re.MULTILINE)
    assert "restitution (explains the difference): Another restitution: e = 0.7" in text


def test_the_command_writes_a_page(csv: Path, tmp_path: Path, lorentz: Any) -> None:
    output = tmp_path / "new" / "page.html"
    output.parent.mkdir()
    arguments = ["compare", str(csv), "-e", "0.75", "--number-density", "0.04"]
    document = lorentz.json(*arguments, "-o", str(output), "--figures", "png")
    assert json.loads(output.with_suffix(".json").read_text(encoding="utf-8")) == document
    assert output.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    names = {p.name for p in output.parent.iterdir()}
    assert "<code>page.json</code>" in output.read_text(encoding="utf-8")
    figures = {f"page-{name}.png" for name in document["figures"]}
    assert names == {"page.html", "page.json"} | figures


def test_an_ensemble_file_says_what_it_is(tmp_path: Path, lorentz: Any) -> None:
    path = tmp_path / "run.h5"
    run_of().save(path)
    document = lorentz.json("compare", str(path))
    assert document["verdict"] == "agrees"
    assert document["parameters"]["restitution"]["value"] == 0.75
    assert document["parameters"]["number_density"]["value"] == 0.04
    damaged = bytearray(path.read_bytes())
    damaged[len(damaged) // 2] ^= 0xFF
    path.write_bytes(bytes(damaged))
    assert "damaged" in lorentz.refused("compare", str(path))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-e", "1.5"], "restitution: got 1.5"),
        (["--number-density", "-1", "-e", "0.7"], "number_density: got -1"),
        (["--speed-unit", "U"], "'--speed-unit': 'U': it must be a number, or data"),
        (["--speed-unit", "nan"], "speed_unit: got nan"),
        (["--speed-unit", "1e308"], "it must be a number from 1e-100 to 1e+100"),
        (["--length-unit", "1e120"], "it must be a number from 1e-100 to 1e+100"),
        (["--diameter", "0"], "diameter: got 0"),
        (["--figures", "pdf"], "they need --output"),
        (["--columns", "time=x"], "column 'x' cannot be time and x"),
        (["--columns", "time=a,time=b"], "'time' stands twice"),
        (["-o", "page.txt"], "it must end in .html"),
        (["-o", "data.html"], "is a folder"),
        (["-o", "missing/page.html"], "its folder does not exist"),
        (["-o", ""], "'--output': '' is no path"),
    ],
)
def test_bad_arguments_are_one_line(
    csv: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    lorentz: Any,
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data.html").mkdir()
    assert message in lorentz.refused("compare", str(csv), *arguments)
    assert [p.name for p in tmp_path.iterdir()] == ["data.html"]


def test_one_file_is_not_two_runs(csv: Path, lorentz: Any) -> None:
    assert "stands twice" in lorentz.refused("compare", str(csv), str(csv))


def test_the_output_never_takes_the_place_of_the_data(
    csv: Path, tmp_path: Path, lorentz: Any
) -> None:
    data = tmp_path / "page.json"
    data.write_bytes(csv.read_bytes())
    page = str(tmp_path / "page.html")
    assert "is one of the data" in lorentz.refused("compare", str(data), "-o", page)
    assert data.read_bytes() == csv.read_bytes()


@pytest.fixture(scope="module")
def saved(text: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [360, 800, 1400])
def test_the_page_in_a_browser(
    saved: Path, differing: Comparison, browser: Any, width: int, dark: bool
) -> None:
    check_in_browser(browser, saved, len(differing.figures), width, dark)

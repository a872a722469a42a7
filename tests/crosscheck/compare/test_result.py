"""A comparison as a value, as tables, as a page with its numbers, and the command."""

import json
import pickle
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import questions
from made_data import Run, columns_of
from pages import Page

from kinetics import compare, load
from kinetics.crosscheck import Comparison
from kinetics.crosscheck.compare.result import render
from kinetics.errors import InputError

EVIL = "<script>alert('x')</script>&\""
KEYS = {
    "schema", "title", "data", "verdict", "summary", "parameters", "initial", "warnings", "tests",
    "explanations", "rows", "medium", "covariance",
}  # fmt: skip


@pytest.fixture(scope="module")
def differing(run: Run) -> Comparison:
    """With a wrong density, so that there is something to explain."""
    return compare(columns_of(run), 0.75, 0.06)


def test_it_is_a_value(differing: Comparison, tmp_path: Path) -> None:
    with pytest.raises(FrozenInstanceError):
        differing.verdict = "agrees"  # type: ignore[misc, assignment]
    assert pickle.loads(pickle.dumps(differing)) == differing
    differing.save(tmp_path / "result.h5")
    again = load(tmp_path / "result.h5")
    assert again == differing
    assert again.to_json() == differing.to_json()
    assert replace(differing, samples=3) != differing
    rows = differing.rows
    rows.loc[0, "value"] = 17.0  # a copy
    assert differing.rows["value"][0] != 17.0
    assert str(differing.verdict) in repr(differing)


def test_its_rows_are_a_data_frame(differing: Comparison) -> None:
    rows = differing.rows
    assert list(rows.columns) == [
        "observable", "time", "value", "error", "theory", "sigmas", "verdict", "corrected_sigmas",
        "samples", "low", "high",
    ]  # fmt: skip
    known = rows.dropna(subset="sigmas")
    averages = known[known["low"].isna()]
    sigmas = (averages["value"] - averages["theory"]) / averages["error"]
    np.testing.assert_allclose(averages["sigmas"], sigmas)
    dataset = differing.to_xarray()
    np.testing.assert_array_equal(dataset["value"], rows["value"])
    assert dataset.attrs["status"] == "differs"
    assert differing.to_dataframe().equals(rows)
    speeds = differing.to_dataframe("speed_density")
    share = speeds["value"] * (speeds["high"] - speeds["low"]).fillna(1.0)
    np.testing.assert_allclose(share.groupby(speeds["time"]).sum(), 1.0)
    for test in differing.tests:
        assert differing.p_value(test.observable, test.time) == test.p_value
    with pytest.raises(KeyError):
        differing.p_value("msd", 3.0)


def test_its_document_is_strict_json(differing: Comparison) -> None:
    document = json.loads(differing.to_json(), parse_constant=lambda c: pytest.fail(c))
    assert document == differing.to_dict()
    assert set(document) == KEYS
    assert set(document["parameters"]) == {"restitution", "number_density", "mean_free_path"}
    assert {*document["tests"][0]} == {
        "observable", "time", "chi_square", "dof", "p_value", "groups", "sigmas", "verdict",
        "within",
    }  # fmt: skip
    assert {*document["explanations"][0]} >= {"name", "outcome", "text", "value", "error"}


def test_every_figure_is_drawn(differing: Comparison) -> None:
    from matplotlib import pyplot

    assert {"thermal-speed", "a2", "msd", "kurtosis", "speed-density"} <= {*differing.figures}
    for name in differing.figures:
        ax = differing.plot(name)
        assert ax.get_xlabel()
        assert ax.get_legend_handles_labels()[0]
        pyplot.close(ax.figure)
    with pytest.raises(InputError, match="msd"):
        differing.plot("nothing")
    assert len(differing.plot()) == len(differing.figures)
    pyplot.close("all")


def test_the_page_says_the_verdict_first_and_every_number(differing: Comparison) -> None:
    from kinetics.crosscheck.words import number, numeral

    page = Page(render(differing, "page.json"))
    assert all(one[0] == "#" for one in page.references)  # nothing beside it is needed
    assert "script" not in page.tags
    words = page.words
    best = differing.explanations[0]
    assert words.index("Differs.") < words.index(best.headline) < words.index("Chi-squares")
    for row in differing.to_dict()["rows"]:
        assert number(row["value"], row["error"]) in words
    for test in differing.tests:
        assert numeral(test.p_value, ".2g") in words
    for item in differing.explanations:
        assert item.text in words


def test_texts_of_the_data_are_escaped(differing: Comparison) -> None:
    evil = replace(
        differing, names=(EVIL,), warnings=(EVIL,), initial=EVIL, summary=EVIL, numbers=()
    )
    page = Page(render(evil, EVIL))
    assert "script" not in page.tags
    assert page.words.count(EVIL) >= 5


TOLD = ("-e", "0.75", "--number-density", "0.04")


def test_the_command_writes_a_page_and_may_fail_on_a_difference(
    csv: Path, tmp_path: Path, lorentz: Any, capsys: Any
) -> None:
    from kinetics.cli import main

    output = tmp_path / "page.html"
    document = lorentz.json("compare", str(csv), *TOLD, "-o", str(output))
    assert document == compare(csv, 0.75, 0.04).to_dict()
    assert json.loads(output.with_suffix(".json").read_text(encoding="utf-8")) == document
    assert output.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert {p.name for p in tmp_path.iterdir()} == {"page.html", "page.json"}
    told = ["compare", str(csv), "-e", "0.6", "--number-density", "0.04", "--fail-on", "differs"]
    assert main(told) == 1
    text = capsys.readouterr().out
    assert text.startswith("They differ; e = 0.7")
    assert max(map(len, text.splitlines())) <= 100


def test_the_page_of_few_tracers(tmp_path: Path, lorentz: Any) -> None:
    """A density that has no bin between the first and the last has no figure."""
    questions.write_table(tmp_path / "few.csv", *questions.trajectories())
    told = ("compare", str(tmp_path / "few.csv"), *TOLD, "-o", str(tmp_path / "page.html"))
    lorentz.json(*told, "--figures", "png")
    assert (tmp_path / "page-msd.png").exists()
    assert "<svg" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-e", "1.5"], "restitution: got 1.5"), (["--speed-unit", "U"], "--speed-unit"),
        (["--figures", "pdf"], "--output"), (["--columns", "time=x"], "for two"),
        (["-o", "page.txt"], "must end in .html"), (["-o", "folder.html"], "is a folder"),
        (["-o", "missing/page.html"], "does not exist"), (["-o", ""], "--output"),
    ],
)  # fmt: skip
def test_bad_arguments_are_one_line(
    csv: Path, tmp_path: Path, monkeypatch: Any, lorentz: Any, arguments: Any, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.html").mkdir()
    assert words in lorentz.refused("compare", str(csv), *arguments)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.html"]

"""A comparison as a value, as ten lines, as tables, as figures and a page, and the two commands."""

import json
import pickle
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import questions
from made_data import Run, columns_of
from pages import Page

from kinetics import compare, fit, load
from kinetics.crosscheck import Comparison
from kinetics.crosscheck.compare.page import render
from kinetics.crosscheck.compare.result import Explanation, Parameter, Row
from kinetics.crosscheck.compare.tables import tables
from kinetics.crosscheck.compare.text import answer_text
from kinetics.crosscheck.words import Verdict, number
from kinetics.errors import InputError

#: A text that a browser would run if it were not escaped.
EVIL = "<script>alert('x')</script>&\""
#: Keys of the JSON document, on which programs of users rely.
KEYS = {
    "schema",
    "title",
    "data",
    "verdict",
    "summary",
    "parameters",
    "initial",
    "warnings",
    "tests",
    "explanations",
    "rows",
    "medium",
    "covariance",
    "overall_p_value",
    "chi_square",
    "dof",
    "dimension",
    "cannot_tell",
    "media",
    "undecided",
    "next_step",
}
KEYS_OF_DATA = {
    "names",
    "samples",
    "groups",
    "grouping",
    "n_times",
    "first_time",
    "last_time",
    "units",
    "unit_names",
}
#: The numbers with which `made_data` was simulated, on the command line.
TRUTH = ("-e", "0.75", "--number-density", "0.04", "--scatterers", "dilute")


@pytest.fixture(scope="module")
def differing(run: Run) -> Comparison:
    """With a wrong density, so that there is something to explain."""
    return compare(columns_of(run), 0.75, 0.06, scatterers="dilute")


@pytest.fixture(scope="module")
def fitted(run: Run) -> Comparison:
    return fit(columns_of(run), scatterers="dilute")


def row(observable: str, value: float, error: float, theory: float, **changed: Any) -> Row:
    """A row at time 5 that deviates by `value - theory`."""
    sigmas = (value - theory) / error if error else None
    numbers = Row(
        observable, 5.0, value, error, theory, sigmas, Verdict.AGREES, abs(sigmas or 0.0) / 2, 100
    )
    return numbers._replace(**changed)


@pytest.fixture
def positions_alone() -> Comparison:
    """Tracks in mm and s, to which e, l, U and the error of a position were fitted."""
    source = "fitted to positions"
    between_frames = [
        row("displacement_between_frames", 4.0 * (time - since), 0.1, 4.0, time=time, since=since)
        for since in (0.0, 2.0)
        for time in (3.0, 5.0, 9.0)
    ]
    return Comparison(
        verdict=Verdict.AGREES,
        summary="No difference seen.",
        parameters={
            "restitution": Parameter(0.7, 0.01, source),
            "number_density": Parameter(0.04, 0.002, source),
            "mean_free_path": Parameter(12.5, 0.6, source),
            "speed_unit": Parameter(3.0, 0.03, source),
            "position_error": Parameter(0.1, 0.004, source),
        },
        initial="a Gaussian start",
        samples=1000,
        groups=251,
        grouping="tracer",
        names=("tracks.csv",),
        warnings=("7 rows were left out.",),
        tests=(),
        explanations=(),
        numbers=tuple(between_frames),
        covariance=((1e-4, 0.0), (0.0, 2e-3)),
        overall_p_value=0.31,
        chi_square=23.0,
        dof=20,
        units={"length": 2.0, "speed": 3.0, "time": 2.0 / 3.0},
        unit_names={"length": "mm", "time": "s"},
        cannot_tell=("The start is not known.",),
        media={"dilute": (23.0, 20), "hard disks": (24.0, 20)},
        undecided=("hard disks",),
        n_times=40,
        first_time=0.0,
        last_time=600.0,
        next_step="Measure longer tracks.",
    )


# -- a value ---------------------------------------------------------------------------------------
def test_a_comparison_cannot_be_changed(differing: Comparison) -> None:
    with pytest.raises(FrozenInstanceError):
        differing.verdict = "agrees"  # type: ignore[misc, assignment]
    rows = differing.rows
    rows.loc[0, "value"] = 17.0
    assert differing.rows["value"][0] != 17.0


def test_a_pickled_comparison_is_equal(positions_alone: Comparison) -> None:
    assert pickle.loads(pickle.dumps(positions_alone)) == positions_alone
    assert replace(positions_alone, samples=3) != positions_alone


@pytest.mark.parametrize("name", ["differing", "positions_alone"])
def test_a_saved_comparison_is_loaded_equal(name: str, request: Any, tmp_path: Path) -> None:
    comparison = request.getfixturevalue(name)
    comparison.save(tmp_path / "result.h5")
    loaded = load(tmp_path / "result.h5")
    assert loaded == comparison
    assert loaded.to_json() == comparison.to_json()


def test_files_without_the_later_fields_are_loaded(positions_alone: Comparison) -> None:
    """As versions before 2026 wrote them: twelve fields, rows of eleven numbers."""
    stored = positions_alone._to_storage()
    later = [
        "overall_p_value",
        "chi_square",
        "dof",
        "units",
        "unit_names",
        "dimension",
        "cannot_tell",
    ]
    later += ["media", "undecided", "n_times", "first_time", "last_time", "next_step"]
    old = {name: value for name, value in stored.items() if name not in later}
    old["numbers"] = tuple(tuple(numbers)[:11] for numbers in old["numbers"])
    loaded = Comparison._from_storage(old)
    assert loaded.overall_p_value is None
    assert loaded.rows["since"].isna().all()
    assert loaded.parameters == positions_alone.parameters


def test_the_title_says_what_was_done(differing: Comparison, fitted: Comparison) -> None:
    assert "compared" in differing.title
    assert "fitted" in fitted.title
    assert not differing.is_fitted
    assert fitted.is_fitted


# -- rows and documents ----------------------------------------------------------------------------
def test_sigmas_are_differences_in_standard_errors(differing: Comparison) -> None:
    averages = differing.rows.dropna(subset="sigmas")
    averages = averages[averages["low"].isna()]
    sigmas = (averages["value"] - averages["theory"]) / averages["error"]
    np.testing.assert_allclose(averages["sigmas"], sigmas)
    assert np.all(averages["corrected_sigmas"] <= np.abs(sigmas) + 1e-9)


def test_shares_of_a_density_add_up_to_one(differing: Comparison) -> None:
    speeds = differing.to_dataframe("speed_density")
    share = speeds["value"] * (speeds["high"] - speeds["low"]).fillna(1.0)
    np.testing.assert_allclose(share.groupby(speeds["time"]).sum(), 1.0)


def test_rows_are_a_data_frame_and_a_dataset(differing: Comparison) -> None:
    rows = differing.rows
    assert list(rows.columns) == list(Row._fields)
    pd.testing.assert_frame_equal(differing.to_dataframe(), rows)
    dataset = differing.to_xarray()
    np.testing.assert_array_equal(dataset["value"], rows["value"])
    assert dataset.attrs["status"] == "differs"


def test_p_values_are_found_by_observable_and_time(differing: Comparison) -> None:
    for test in differing.tests:
        assert differing.p_value(test.observable, test.time) == test.p_value
    with pytest.raises(KeyError):
        differing.p_value("msd", 3.0)


def test_the_document_is_strict_json(positions_alone: Comparison) -> None:
    text = positions_alone.to_json()
    document = json.loads(text, parse_constant=lambda constant: pytest.fail(constant))
    assert document == positions_alone.to_dict()
    assert set(document) == KEYS
    assert set(document["data"]) == KEYS_OF_DATA
    assert document["media"]["hard disks"] == [24.0, 20]
    assert document["rows"][0]["since"] == 0.0


# -- the answer in words ---------------------------------------------------------------------------
def test_the_answer_is_short(differing: Comparison, fitted: Comparison) -> None:
    for comparison in (differing, fitted):
        lines = answer_text(comparison).splitlines()
        assert len(lines) <= 14  # twelve, and two that are continued
        assert max(len(line) for line in lines) <= 100


def test_the_answer_begins_with_the_verdict(differing: Comparison, fitted: Comparison) -> None:
    assert "differ" in answer_text(differing).splitlines()[0]
    assert "agree" in answer_text(fitted).splitlines()[0]


def test_values_are_in_the_units_of_the_data_and_in_d(positions_alone: Comparison) -> None:
    text = answer_text(positions_alone)
    assert "0.700 ± 0.010" in text
    assert "12.50 ± 0.60 d = 25.0 ± 1.2 mm" in text
    assert "0.0400 ± 0.0020 d⁻² = 0.01000 ± 0.00050 mm⁻²" in text
    assert "3.000 ± 0.030 mm/s" in text
    assert "0.0500 ± 0.0020 d = 0.1000 ± 0.0040 mm" in text
    assert "from 0 to 600 d/U (0 to 400 s)" in text


def test_densities_in_space_are_per_volume(positions_alone: Comparison) -> None:
    text = answer_text(replace(positions_alone, dimension=3))
    assert "0.0400 ± 0.0020 d⁻³ = 0.00500 ± 0.00025 mm⁻³" in text


def test_data_in_d_and_U_have_no_second_value(fitted: Comparison) -> None:
    lines = answer_text(fitted).splitlines()
    path = next(line for line in lines if line.startswith("mean free path"))
    assert "=" not in path


def test_the_answer_says_what_the_fields_of_the_comparison_say(positions_alone: Comparison) -> None:
    text = " ".join(answer_text(positions_alone).split())
    for words in (
        *positions_alone.warnings,
        *positions_alone.cannot_tell,
        positions_alone.next_step,
        "do not exclude hard disks",
        "1000 tracers at 40 times",
        "p-value: 0.31",
        "chi-square 23 with 20 degrees of freedom",
    ):
        assert words in text


def test_a_number_without_a_value_says_why(positions_alone: Comparison) -> None:
    parameters = dict(positions_alone.parameters)
    parameters["restitution"] = Parameter(None, None, "no value: the model does not fit")
    text = answer_text(replace(positions_alone, parameters=parameters))
    assert "restitution e: no value: the model does not fit" in text


def test_the_largest_deviation_is_that_beyond_chance(positions_alone: Comparison) -> None:
    """Of many rows one deviates by chance: what counts is the deviation that allows for these."""
    likely = row("msd", 14.1, 1.0, 10.0, corrected_sigmas=1.2)
    unlikely = row("thermal_speed", 1.3, 0.1, 1.0, corrected_sigmas=2.2)
    text = answer_text(replace(positions_alone, numbers=(likely, unlikely)))
    line = next(line for line in text.splitlines() if line.startswith("largest deviation"))
    assert "Thermal speed" in line


def test_a_difference_without_scatter_is_the_largest(positions_alone: Comparison) -> None:
    scattered = row("msd", 14.1, 1.0, 10.0)
    exact = row("a2", -0.5, 0.0, -0.4, verdict=Verdict.DIFFERS)
    text = answer_text(replace(positions_alone, numbers=(scattered, exact)))
    line = next(line for line in text.splitlines() if line.startswith("largest deviation"))
    assert "−0.5" in line


def test_all_causes_that_explain_are_named(positions_alone: Comparison) -> None:
    causes = (
        Explanation("free path", "explains", "", headline="l = 9 d"),
        Explanation("restitution", "explains", "", headline="e = 0.8"),
        Explanation("noise", "in part", "", headline="noise of 0.2 d"),
    )
    differing = replace(positions_alone, verdict=Verdict.DIFFERS, explanations=causes)
    text = answer_text(differing)
    assert "l = 9 d or e = 0.8" in text
    assert "noise" not in text


def test_warnings_that_are_not_shown_are_counted(positions_alone: Comparison) -> None:
    warnings = tuple(f"warning {number}" for number in range(6))
    many = replace(positions_alone, warnings=warnings)
    assert "3 more" in answer_text(many)
    for warning in warnings:
        assert (answer_text(many) + tables(many)).count(warning) == 1


# -- tables ----------------------------------------------------------------------------------------
def cells(text: str, *beginning: str) -> list[str]:
    """The cells of the line of a table that begins with these."""
    lines = [line.split() for line in text.splitlines()]
    return next(line for line in lines if line[: len(beginning)] == list(beginning))


def test_tables_have_all_averages_and_tests(differing: Comparison) -> None:
    text = tables(differing)
    for average in differing.numbers:
        if average.low is None:
            assert number(average.value, average.error) in text
    for test in differing.tests:
        assert cells(text, test.observable)
    assert max(len(line) for line in text.splitlines()) <= 105


def test_a_row_shows_the_deviation_that_its_verdict_is_on(positions_alone: Comparison) -> None:
    """A row of 4.1 standard errors may agree, as one of many: the table shows both."""
    numbers = (row("msd", 14.1, 1.0, 10.0, corrected_sigmas=2.3),)
    shown = cells(tables(replace(positions_alone, numbers=numbers)), "msd", "5")
    assert shown[-3:] == ["+4.1", "2.3", "agrees"]


@pytest.mark.parametrize(
    ("theory", "error", "text"),
    [
        (-5.4e-9, 0.02, "0"),
        (-5.4e-9, 0.0, "0"),
        (0.98749, 0.01, "0.987"),
        (1852.02, 43.0, "1852"),
        (270.917, 6.4, "270.9"),
        (1.41421356, 0.0, "1.41421"),
        (-0.0059718, 0.02, "−0.006"),
    ],
)
def test_the_theory_has_the_decimals_of_the_error(
    positions_alone: Comparison, theory: float, error: float, text: str
) -> None:
    numbers = (row("msd", theory + 0.1, error, theory),)
    shown = cells(tables(replace(positions_alone, numbers=numbers)), "msd", "5")
    assert text in shown


def test_rows_between_frames_have_both_times(positions_alone: Comparison) -> None:
    assert cells(tables(positions_alone), "displacement_between_frames", "9", "2")


# -- figures and the page --------------------------------------------------------------------------
def test_every_figure_has_labels_and_the_medium(differing: Comparison) -> None:
    from matplotlib import pyplot

    assert {"thermal-speed", "a2", "msd", "kurtosis", "speed-density"} <= {*differing.figures}
    for name in differing.figures:
        ax = differing.plot(name)
        assert ax.get_xlabel()
        assert ax.get_ylabel()
        assert differing.medium in " ".join(ax.get_legend_handles_labels()[1])
        pyplot.close(ax.figure)


def test_all_figures_are_drawn_without_a_name(differing: Comparison) -> None:
    from matplotlib import pyplot

    assert len(differing.plot()) == len(differing.figures)
    pyplot.close("all")


def test_an_unknown_figure_is_refused_with_those_that_exist(differing: Comparison) -> None:
    with pytest.raises(InputError, match="msd"):
        differing.plot("nothing")


def test_displacements_between_frames_are_drawn_over_the_time_between(
    positions_alone: Comparison,
) -> None:
    from matplotlib.figure import Figure

    ax = Figure().subplots()
    positions_alone.plot("displacement_between_frames", ax=ax)
    theory = [line for line in ax.lines if line.get_linestyle() == "-"]
    assert [line.get_xdata().tolist() for line in theory] == [[3.0, 5.0, 9.0], [1.0, 3.0, 7.0]]
    assert theory[0].get_color() != theory[1].get_color()


@pytest.fixture(scope="module")
def page(differing: Comparison) -> Page:
    return Page(render(differing, "page.json"))


def test_the_page_stands_alone_and_begins_with_the_answer(
    differing: Comparison, page: Page
) -> None:
    assert all(reference.startswith("#") for reference in page.references)
    assert "script" not in page.tags
    assert page.tags.count("svg") == len(differing.figures)
    assert len(page.ids) == len(set(page.ids))
    assert {reference[1:] for reference in page.references} <= set(page.ids)
    words = page.words
    headline = differing.explanations[0].headline
    assert words.index("differ") < words.index(headline) < words.index("Tests")


def test_the_page_has_every_number(differing: Comparison, page: Page) -> None:
    words = page.words
    for numbers in differing.numbers:
        assert number(numbers.value, numbers.error) in words
    for item in differing.explanations:
        assert (item.headline or item.text) in words


def test_texts_of_the_data_are_escaped(positions_alone: Comparison) -> None:
    evil = replace(
        positions_alone, names=(EVIL,), warnings=(EVIL,), initial=EVIL, unit_names={"length": EVIL}
    )
    page = Page(render(evil, EVIL))
    assert "script" not in page.tags
    assert page.words.count(EVIL) >= 5


# -- the commands ----------------------------------------------------------------------------------
def test_the_command_writes_a_page_and_its_numbers(csv: Path, tmp_path: Path, lorentz: Any) -> None:
    output = tmp_path / "page.html"
    document = lorentz.json("compare", str(csv), *TRUTH, "-o", str(output))
    assert document == compare(csv, 0.75, 0.04, scatterers="dilute").to_dict()
    assert json.loads(output.with_suffix(".json").read_text(encoding="utf-8")) == document
    assert output.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert {path.name for path in tmp_path.iterdir()} == {"page.html", "page.json"}


def test_a_difference_may_end_with_a_status(csv: Path, capsys: Any) -> None:
    from kinetics.cli import main

    wrong = ["compare", str(csv), "-e", "0.6", *TRUTH[2:]]
    assert main([*wrong, "--fail-on", "differs"]) == 1
    assert capsys.readouterr().out.startswith("Data and theory differ")
    assert main(wrong) == 0


def test_rows_are_printed_where_they_are_asked_for(csv: Path, lorentz: Any) -> None:
    short = lorentz("fit", str(csv), "--scatterers", "dilute")
    long = lorentz("fit", str(csv), "--scatterers", "dilute", "--rows")
    assert long.startswith(short.rstrip("\n"))
    assert "speed_density" not in short
    assert "speed_density" in long


def test_the_start_is_named_by_either_word(csv: Path, lorentz: Any) -> None:
    by_start = lorentz.json("compare", str(csv), *TRUTH, "--start", "one-speed")
    by_initial = lorentz.json("compare", str(csv), *TRUTH, "--initial", "monoenergetic")
    assert by_start == by_initial
    assert by_start["verdict"] == "differs"


def test_fit_takes_no_restitution(csv: Path, lorentz: Any) -> None:
    assert "-e" in lorentz.refused("fit", str(csv), "-e", "0.7")


def test_the_page_of_few_tracers(tmp_path: Path, lorentz: Any) -> None:
    """A density that has no bin between the first and the last has no figure."""
    questions.write_table(tmp_path / "few.csv", *questions.trajectories())
    page = str(tmp_path / "page.html")
    lorentz.json("compare", str(tmp_path / "few.csv"), *TRUTH, "-o", page, "--figures", "png")
    assert (tmp_path / "page-msd.png").exists()
    assert "<svg" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-e", "1.5"], "restitution: got 1.5"),
        (["--speed-unit", "U"], "--speed-unit"),
        (["--localisation-error", "x"], "--localisation-error"),
        (["--start", "slow"], "--start"),
        (["--fps", "0"], "fps"),
        (["--fps", "2", "--frame-interval", "1"], "--frame-interval"),
        (["--figures", "pdf"], "--output"),
        (["--columns", "time=x"], "for two"),
        (["-o", "page.txt"], "must end in .html"),
        (["-o", "folder.html"], "is a folder"),
        (["-o", "missing/page.html"], "does not exist"),
        (["-o", ""], "--output"),
    ],
)
def test_bad_arguments_are_one_line(
    csv: Path, tmp_path: Path, monkeypatch: Any, lorentz: Any, arguments: Any, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.html").mkdir()
    assert words in lorentz.refused("compare", str(csv), *arguments)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.html"]

"""Figures draw what their data hold, and nothing else; each can stand in a page beside others."""

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from pages import Page

from kinetics.crosscheck.report.all_figures import PAPER_FIGURES, all_figures
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.drawing import draw
from kinetics.crosscheck.report.figures import svg
from kinetics.crosscheck.report.layout import _apart, arranged
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.report.strokes import (
    COLOURS,
    FAINT,
    INK,
    colours_of,
    legend_entries,
    stroke_of,
)

MakeCase = Callable[..., Case]


@pytest.fixture(scope="module")
def figures(make_case: MakeCase, scans: Scans, settings: ReportSettings) -> dict[str, Any]:
    return all_figures([make_case(restitution=0.4), make_case(restitution=0.7)], scans, settings)


NAMES = [
    *PAPER_FIGURES, "cooling-rate", "inverse-speed", "a2", "approach", "vdf-tail", "msd-slope",
    "kurtosis", "tail-exponent", "msd-ratio", "density", "traps",
]  # fmt: skip


def test_every_figure_is_there(figures: dict[str, Any]) -> None:
    assert list(figures) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_figure_draws_its_series_and_nothing_else(figures: dict[str, Any], name: str) -> None:
    data = figures[name] | {"series": [s | {"x_range": []} for s in figures[name]["series"]]}
    axis = Figure().add_subplot()
    draw(data, axis)
    assert len(axis.lines) == len(data["series"])
    for line, series in zip(axis.lines, data["series"], strict=True):
        x, y = (np.array(series[k], dtype=float) for k in "xy")
        np.testing.assert_array_equal(line.get_xdata(), x)
        np.testing.assert_array_equal(line.get_ydata(), y)
    bars = [s for s in data["series"] if s["error"] is not None]
    assert len(axis.collections) == len(bars)
    for collection, series in zip(axis.collections, bars, strict=True):
        lengths = [np.ptp(s[:, 1]) for s in collection.get_segments() if len(s)]
        expected = [2 * e for e in series["error"] if e is not None]
        np.testing.assert_allclose(lengths, expected, rtol=1e-9)
    assert not axis.patches
    assert not axis.texts
    assert not axis.images


@pytest.mark.parametrize("name", NAMES)
def test_axes_are_labelled_and_series_named(figures: dict[str, Any], name: str) -> None:
    data = figures[name]
    axis = Figure().add_subplot()
    draw(data, axis)
    for label, spec in ((axis.get_xlabel(), data["x"]), (axis.get_ylabel(), data["y"])):
        assert spec["label"] in label
        assert spec["unit"] in label
    entries = [label for label, _ in legend_entries(data)]
    assert len(entries) == len(set(entries))
    # a panel's title or the axis of x names the restitutions elsewhere
    elsewhere = data.get("panels") or "restitution" in data["x"]["label"]
    for series in data["series"]:
        assert (series["source"] in entries) == (series["source"] != "zero")
        if series["restitution"] is not None and not elsewhere:
            assert f"e = {series['restitution']:g}" in entries


def test_a_restitution_has_one_colour_and_one_marker_in_all_figures(
    figures: dict[str, Any],
) -> None:
    looks: dict[float, set[tuple[str, str]]] = {}
    for data in figures.values():
        every = [*data["series"], *data.get("ratio", {"series": []})["series"]]
        for one, colour in zip(every, colours_of(data, every), strict=True):
            if one["restitution"] is not None and one["error"] is not None:
                marker = stroke_of(data, one)["marker"]
                looks.setdefault(one["restitution"], set()).add((colour, marker))
            elif one["restitution"] is None and one["group"] is None:
                assert colour == INK
            elif one["group"] is not None:
                assert colour not in COLOURS
    assert looks == {0.4: {(COLOURS[0], "o")}, 0.7: {(COLOURS[1], "s")}}


def test_a_figure_of_one_restitution_keeps_its_colour(figures: dict[str, Any]) -> None:
    # soninediffuse lacks e = 0.4, whose a2 the paper does not have
    data = figures["soninediffuse"]
    assert {s["restitution"] for s in data["series"]} == {0.7, None}
    assert colours_of(data, data["series"])[0] == COLOURS[1]


@pytest.mark.parametrize("name", ["inelasticposi", "inverse-speed", "scalev", "tail-exponent"])
def test_small_multiples_have_a_panel_for_each_restitution(
    figures: dict[str, Any], name: str
) -> None:
    data = figures[name]
    panels = arranged(data).axes
    assert [panel.get_title("left") for panel in panels] == ["e = 0.4", "e = 0.7"]
    assert len({panel.get_xlim() for panel in panels}) == 1
    assert len({panel.get_ylim() for panel in panels}) == 1
    spans = len(data.get("spans", ())) // 2
    for panel, e in zip(panels, (0.4, 0.7), strict=True):
        shown = [s for s in data["series"] if s["restitution"] in (e, None)]
        assert len(panel.lines) == len(shown) + spans


@pytest.mark.parametrize("name", ["v0re", "msdtheory", "soninediffuse", "hetomu2", "msd-ratio"])
def test_ratios_stand_in_a_panel_below(figures: dict[str, Any], name: str) -> None:
    data = figures[name]
    upper, lower = arranged(data).axes
    assert upper.get_xlim() == lower.get_xlim()
    assert lower.get_position().y1 < upper.get_position().y0
    assert len(lower.lines) == len(data["ratio"]["series"])
    # the made-up Boltzmann-Grad run is half an error of 1 % above the equation, its a half of h
    (points, *_) = [s for s in data["ratio"]["series"] if s["source"] == "Boltzmann-Grad"] or [None]
    if points is not None and name in ("msdtheory", "soninediffuse"):
        np.testing.assert_allclose(points["y"], 1.005)


def test_the_range_of_an_average_is_drawn(figures: dict[str, Any]) -> None:
    (slope, *_) = [s for s in figures["msd-slope"]["series"] if s["error"] is not None]
    ((low, high),) = slope["x_range"]
    assert low < slope["x"][0] < high
    assert high == pytest.approx(10 * low, rel=0.5)
    axis = Figure().add_subplot()
    draw(figures["msd-slope"] | {"series": [slope]}, axis)
    bars = [s for c in axis.collections for s in c.get_segments()]
    assert any(np.ptp(bar[:, 0]) == pytest.approx(high - low) for bar in bars)
    assert [s["high"] for s in figures["inverse-speed"]["spans"]] == [1000.0, 1000.0]


@pytest.mark.parametrize("wanted", [[0.5] * 4, [0.0, 0.01, 0.98, 1.2], [-0.3, 0.2, 0.2], [0.4]])
def test_labels_keep_apart_and_inside(wanted: list[float]) -> None:
    placed = _apart(wanted, 0.1)
    assert all(b - a > 0.1 - 1e-12 for a, b in pairwise(placed))
    assert min(placed) >= 0
    assert max(placed) <= 1 + 1e-12
    assert _apart([0.2, 0.6], 0.1) == pytest.approx([0.2, 0.6])  # none is moved without need


def test_every_line_is_named_beside_it_or_in_the_legend(figures: dict[str, Any]) -> None:
    drawn = arranged(figures["kurtosis"])
    (axis,) = drawn.axes
    assert {t.get_text() for t in axis.texts} == {
        "e = 0.4", "e = 0.7", "Gaussian", "paper's integral"
    }  # fmt: skip
    named = {t.get_text() for t in drawn.legends[0].get_texts()}
    assert named == {"kinetic equation", "Boltzmann-Grad", "hard disks"}


@pytest.mark.parametrize("name", ["cooling-rate", "vdf-tail"])
def test_the_element_stands_alone(figures: dict[str, Any], name: str) -> None:
    text = svg(name, figures[name])
    page = Page(text)
    tag, attributes = page.elements[0]
    assert tag == "svg"
    assert attributes["role"] == "img"
    ids = page.ids
    assert len(ids) == len(set(ids))
    assert all(i.startswith(f"fig-{name}-") for i in ids)
    labels = attributes["aria-labelledby"]
    assert labels is not None
    assert set(labels.split()) <= set(ids)
    # every reference, in an attribute or in a style, is to an id of this element
    references = re.findall(r'(?:url\(|href=")([^")]*)', text)
    assert references
    assert {r.removeprefix("#") for r in references} <= set(ids)
    assert all(r.startswith("#") for r in references)
    assert "http" not in text
    # every colour became a variable of the page
    assert not [colour for colour in (INK, FAINT, *COLOURS) if colour in text]


def test_the_same_data_give_the_same_text(figures: dict[str, Any]) -> None:
    assert svg("approach", figures["approach"]) == svg("approach", figures["approach"])


def test_titles_are_escaped(figures: dict[str, Any]) -> None:
    data = figures["approach"] | {"title": "<script>", "description": "a & <b>"}
    text = svg("approach", data)
    assert "<script>" not in text
    assert "&lt;script&gt;" in text
    assert "a &amp; &lt;b&gt;" in text


def test_a_gap_breaks_the_line(figures: dict[str, Any]) -> None:
    sonine = next(s for s in figures["cooling-rate"]["series"] if s["source"] == "Sonine")
    assert sonine["y"][0] is None
    axis = Figure().add_subplot()
    draw(figures["cooling-rate"] | {"series": [sonine]}, axis)
    assert np.isnan(np.asarray(axis.lines[0].get_ydata())[0])


def test_the_description_names_where_no_trap_was_found(figures: dict[str, Any]) -> None:
    # the made-up scan of 1000 tracers has none at e = 0.6 and the lower density
    assert (
        "None was caught at ρ₀d² = 0.04: e = 0.6 (95 % limit 0.003)."
        in (figures["traps"]["description"])
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_title_is_one_line_and_a_description_ends(figures: dict[str, Any], name: str) -> None:
    data = figures[name]
    assert data["title"]
    assert not data["title"].endswith(".")
    assert data["description"].endswith(".")
    for text in (data["title"], data["description"]):
        assert "  " not in text
        assert "{" not in text
        assert "nan" not in text


@pytest.mark.parametrize(
    ("name", "observable"),
    [("v0re", "thermal_speed"), ("inverse-speed", "thermal_speed"), ("kurtosis", "kurtosis"),
     ("inelasticposi", "position"), ("scalev", "vdf"), ("tail-exponent", "tail_exponent")],
)  # fmt: skip
def test_points_without_a_usable_error_are_left_out(
    make_case: MakeCase, settings: ReportSettings, name: str, observable: str
) -> None:
    def shown(case: Case) -> list[float]:
        lines = all_figures([case], None, settings)[name]["series"]
        return next(s["x"] for s in lines if s["source"] == case.free.name)

    case = make_case()
    measured = getattr(case.free, observable)
    error = measured.error.copy()
    error[3] = 0.0 if observable == "kurtosis" else 1e3
    bad = replace(case.free, **{observable: replace(measured, error=error)})
    every, rest = shown(case), shown(replace(case, free=bad))
    assert len(rest) == len(every) - 1
    assert set(rest) < set(every)

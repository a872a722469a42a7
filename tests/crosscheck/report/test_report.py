"""Reports of all systems: what they compare, what a reader gets, and what is in the files."""

import csv
import json
import math
import re
from collections import Counter
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from pages import Page, check_alone, check_in_browser
from scipy.stats import t

from kinetics.crosscheck.report import algebra, estimates, rows
from kinetics.crosscheck.report.cases import Measured
from kinetics.crosscheck.report.estimates import scaled_density
from kinetics.crosscheck.report.sheet import VARIABLES
from kinetics.crosscheck.report.systems import DRIVES, Cooling, Driven

KINDS: tuple[Any, ...] = ("paper", "spheres", "elastic", "field", "heated")
LATE = ("rough", "bath", "viscoelastic")
KINDS += tuple(pytest.param(name, marks=pytest.mark.slow) for name in LATE)
MOST_WORDS = 260  # before the first figure


@pytest.fixture(params=KINDS)
def each(request: Any, made: Callable[[str], Any]) -> Any:
    return made(request.param)


def test_the_golden_rows(made: Any) -> None:
    found = made("paper").report
    strict = found.table[found.table.source == "Boltzmann-Grad"]
    assert not (strict.verdict == "differs").any()
    assert set(found.table[found.table.kind == "numerical"].verdict) == {"agrees"}
    known = {
        ("cooling_rate", 0.4, "solver", "exact"): 0.8472488,
        ("cooling_rate", 0.7, "Sonine", "exact"): 0.4537167,
        ("a2", 0.4, "solver", "exact"): 0.4272511,
        ("msd_slope", 0.4, "paper's fit", "exact"): 473.2213,
        ("kurtosis", 0.7, "paper's integral", "kinetic equation"): 4.0,
    }
    keys = ["observable", "restitution", "source", "against"]
    values = found.table.set_index(keys).value
    for key, value in known.items():
        assert values[key] == pytest.approx(value, rel=1e-5), key
    assert len(found.table) == 64
    counted = found.document["verdict_counts"]
    assert counted == Counter(row["verdict"] for row in found.document["rows"])
    assert counted["agrees"] + counted["not tested"] > 30


def test_every_system_gives_the_same_table(each: Any) -> None:
    table = each.report.table
    assert list(table.columns) == list(rows.COLUMNS)
    assert not table.duplicated(["system", "observable", "restitution", "source", "against"]).any()
    compared = table[table.kind == "statistical"]
    assert (compared.error > 0).all()
    sigmas = (compared.value - compared.theory) / compared.error
    np.testing.assert_allclose(compared.sigmas, sigmas)
    assert (compared.groups >= 10).all()
    assert each.report.results.system.stages == len(each.stages) + 1  # and that of writing


@pytest.mark.parametrize(
    ("value", "error", "looks", "verdict"),
    [
        (1.02, 0.02, 1, "agrees"),
        (1.02, 0.05, 1, "not tested"),
        (1.3, 0.2, 1, "not tested"),
        (1.3, 0.09, 1, "unclear"),
        (1.3, 0.02, 1, "differs"),
        (1.06, 0.02, 1, "unclear"),
        (1.06, 0.02, 40, "agrees"),  # three errors in 40 looks are nothing
    ],
)
def test_what_could_not_have_been_seen_is_not_tested(
    value: float, error: float, looks: int, verdict: str
) -> None:
    measured = Measured(np.append(value, np.ones(looks - 1)), np.full(looks, error))
    question = rows.Question("msd", "a", "b")
    (row,) = rows.statistical_rows(question, measured, 1.0, groups=100, place=None)
    assert row["verdict"] == verdict
    assert row["within"] == pytest.approx(abs(value - 1) + t.ppf(0.975, 99) * error)


def test_two_media_that_differ_from_a_theory_by_less_than_students_limit_are_not_tested() -> None:
    measured = Measured(np.array([1.0]), np.array([0.02]))
    question = rows.Question("msd", "a", "b")
    (row,) = rows.statistical_rows(question, measured, 1.0, groups=2, place=None)
    assert row["verdict"] == "not tested"
    assert row["within"] == pytest.approx(12.706 * 0.02, rel=1e-3)


def test_the_page_is_whole_by_itself(each: Any) -> None:
    text = each.page.read_text(encoding="utf-8")
    assert len(check_alone(text, len(each.report.figures)).tags) > 300
    head = re.sub(
        r"<math.*?</math>|<style>.*?</style>", "", text[: text.index("<figure")], flags=re.S
    )
    assert len(re.sub(r"<[^>]+>", " ", head[head.index("<main>") :]).split()) <= MOST_WORDS


def test_findings_stand_before_figures_and_details_are_folded(made: Any) -> None:
    text = made("paper").page.read_text(encoding="utf-8")
    order = ['class="strip"', "Findings", "<figure", 'id="claims"', "<details"]
    places = [text.index(part) for part in order]
    assert places == sorted(places)
    assert Page(text).words.count("1.45") <= 3  # found, judged, and nowhere else


def test_the_files(each: Any) -> None:
    document = json.loads((each.folder / f"{each.name}.json").read_text(encoding="utf-8"))
    assert {"headline", "claims", "rows", "verdict_counts", "algebra"} <= set(document)
    assert set(document["headline"]) == {"compared", "findings", "line"}
    judged = each.report.results.system.is_papers_law and each.report.results.inelastic
    assert len(document["claims"]) == (7 if judged else 0)
    assert {c["status"] for c in document["algebra"]} <= {"verified", "erratum"}
    with open(each.folder / f"{each.name}-rows.csv", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [line["verdict"] for line in lines] == [row["verdict"] for row in document["rows"]]
    drawn = [figure["name"] for figure in document["figures"]]
    files = sorted(p.stem.split("-", 1)[1] for p in each.folder.glob("*.png"))
    assert files in ([], sorted(drawn))
    assert (each.folder / f"{each.name}-points.csv").stat().st_size > 1000


def test_every_figure_has_words_units_and_ticks_that_do_not_collide(each: Any) -> None:
    dimensional = {"t", "r^2", "u", "v_z", "v^2", "D", "x", "y"}
    for drawn in each.report.figures:
        assert len(drawn.title) > 8
        assert len(drawn.caption) > 30
        assert "{" not in drawn.caption
        labels = [f() for ax in drawn.figure.axes for f in (ax.get_xlabel, ax.get_ylabel) if f()]
        assert len(labels) >= 2
        for label in labels:
            symbol = re.search(r"\$⟨?(\\langle )?([\w^]+)", label)
            if symbol and symbol[2] in dimensional and "/" not in label.split("[")[0]:
                assert re.search(r"\[.+\]", label), label
        assert overlaps(drawn.figure) == [], drawn.name


def overlaps(figure: Any) -> list[tuple[str, str]]:
    """Pairs of tick labels of the figure of which one covers a part of the other."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    boxes = []
    for ax in figure.axes:
        for side in (ax.xaxis, ax.yaxis):
            low, high = sorted(side.get_view_interval())
            for tick in side.get_major_ticks():
                at = tick.get_loc()
                for label in (tick.label1, tick.label2):
                    if label.get_visible() and label.get_text() and low <= at <= high:
                        boxes.append((label.get_text(), label.get_window_extent(renderer)))
    return [
        (one, other)
        for k, (one, box) in enumerate(boxes)
        for other, against in boxes[k + 1 :]
        if box.overlaps(against)
    ]


def test_a_sheet_has_a_variable_for_every_colour_of_the_figures(each: Any) -> None:
    style = (files("kinetics.crosscheck") / "templates" / "report.css").read_text("utf-8")
    sheets = re.findall(r":root \{(.*?)\}", style, flags=re.DOTALL)
    assert len(sheets) == 2  # light, on paper too, and dark
    for sheet in sheets:
        for variable in VARIABLES.values():
            assert sheet.count(variable[4:-1] + ":") == 1, variable
    for drawn in each.report.figures:
        known = {c.lower() for c in re.findall(r"#[0-9a-fA-F]{6}\b", drawn.svg())}
        assert known <= {"#ffffff"}, drawn.name


@pytest.mark.parametrize(("width", "dark"), [(390, False), (1400, True)])
def test_the_page_in_a_browser(made: Any, browser: Any, width: int, dark: bool) -> None:
    for kind in ("paper", "field", "heated"):
        found = made(kind)
        asked = {"high": "document.documentElement.scrollHeight", "ink":
                 "getComputedStyle(document.querySelector('figure svg text')).fill"}  # fmt: skip
        drawn = len(found.report.figures)
        seen = check_in_browser(browser, found.page, drawn, width, dark, asked)
        assert (seen["ink"] == "rgb(231, 234, 238)") is dark


def test_labels_of_the_paper_become_its_numbers() -> None:
    assert algebra.cite("see ad8#2, eq. msd and msd") == "see eq. (C9), eq. (22) and msd"
    assert algebra.cite("beyond:slope, sonine9") == "beyond:slope, eq. (B15)"


@pytest.mark.parametrize("kind", DRIVES)
def test_driven_tracers_are_judged_over_time_and_in_the_steady_state(made: Any, kind: str) -> None:
    table = made(kind).report.table.set_index(["observable", "source"])
    names = {"drift_from_rest"} if kind == "field" else {"thermal_speed", "a2", "msd"}
    assert names | {"collisions"} <= set(table.index.get_level_values(0))
    assert not (table.verdict == "differs").any()
    exact = table[table.kind == "numerical"]
    assert set(exact.verdict) == (set() if kind == "viscoelastic" else {"agrees"})
    state = made(kind).report.results.driven[0].state
    if kind == "field":
        assert table.theory["drift", "Boltzmann-Grad"] == pytest.approx(0.617488570787, rel=1e-8)
    if kind == "bath":  # w^2 (1 + e)/(1 - e), in both directions
        assert table.theory["steady_speed", "solver"] == pytest.approx(math.sqrt(6.0))
    if kind in ("bath", "heated"):
        drift = table.theory["weak_drift", "Boltzmann-Grad"]
        assert drift == pytest.approx(state.mobility, rel=0.05)


def test_the_report_lists_every_erratum_with_what_it_changes(made: Any) -> None:
    document = made("paper").report.document
    errata = {check["label"] for check in document["algebra"] if check["status"] == "erratum"}
    assert len(errata) == 9
    assert {erratum["label"] for erratum in document["errata"]} == errata
    words = Page(made("paper").page.read_text(encoding="utf-8")).words
    for erratum in document["errata"]:
        assert erratum["place"].startswith("eq. (")
        assert " ".join(erratum["change"].split()[:5]) in words


def test_each_claim_stands_beside_the_words_of_the_paper(made: Any) -> None:
    page = Page(made("paper").page.read_text(encoding="utf-8")).words
    for claim in made("paper").report.document["claims"]:
        assert claim["place"]
        assert claim["words"] in page


def test_bins_are_merged_until_each_expects_enough_samples_for_a_test() -> None:
    shares = np.array([0.01, 0.04, 0.3, 0.3, 0.2, 0.1, 0.03, 0.009, 0.001])
    edges = estimates.merge_bins(shares, 50_000)
    assert edges is not None
    expected = 50_000 * np.add.reduceat(shares[: edges[-1]], edges[:-1])
    assert np.all(expected >= estimates.MIN_SAMPLES_PER_TEST)
    assert list(edges) == [0, 2, 3, 4, 5, 6]
    assert estimates.merge_bins(shares, 5_000) is None


def test_densities_of_dilute_tracers_are_tested(made: Any) -> None:
    # 2000 tracers are too few, and called so; what is tested could show a tenth
    table = made("paper").report.table
    densities = table[table.observable.isin(["scaled_vdf", "position"])]
    statistical = densities[(densities.kind == "statistical")]
    assert set(statistical.verdict) <= {"not tested", "agrees", "unclear", "differs"}
    assert (statistical[statistical.verdict == "agrees"].within <= 0.1).all()


def test_a_quick_report_is_of_the_same_system() -> None:
    assert Cooling().quick().media < Cooling().media
    assert Driven((0.3, 0.8), name="field").quick().restitutions == (0.3, 0.8)


def test_the_scaled_density_of_gaussian_velocities_and_its_errors() -> None:
    # F = exp(-c^2)/pi whatever the unit of the speeds; 300 repeats show the true spread
    edges = np.array([0.0, 0.3, 0.8, 1.2, 2.0])
    area = math.pi * np.diff(edges**2)
    exact = -np.diff(np.exp(-(edges**2))) / area
    rng = np.random.default_rng(2)
    samples = [np.hypot(*rng.normal(0, 7.0, (2, 25, 40))) for _ in range(300)]
    runs = [scaled_density(each, edges, area) for each in samples]
    values, errors = (np.array([getattr(r, k) for r in runs]) for k in ("value", "error"))
    spread = values.std(axis=0)
    assert np.all(np.abs(values.mean(axis=0) - exact) < 5 * spread / math.sqrt(300))
    # 300 repeats know the spread to 4 %; the jackknife is a little conservative
    np.testing.assert_allclose(np.sqrt((errors**2).mean(axis=0)), spread, rtol=0.2)

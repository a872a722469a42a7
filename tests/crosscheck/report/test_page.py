"""The page and the JSON file: nothing external, nothing unescaped, nothing that the other lacks."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from kinetics.crosscheck.report.all_figures import PAPER_FIGURES
from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.equations import FORMULAS
from kinetics.crosscheck.report.page import deviation, number, render, verdict_table
from kinetics.crosscheck.report.report import build_document, write_report
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.strict_json import dumps, plain
from kinetics.crosscheck.text_tables import columns

MakeCase = Callable[..., Case]
CHECKS = [
    {
        "label": "sonine9",
        "title": "M2",
        "status": "verified",
        "proof": "exact",
        "printed": "Eq(M_2, 1)",
        "derived": "Eq(M_2, 1)",
        "note": "",
        "numbers": {},
        "printed_mathml": "<math><mi>M</mi></math>",
        "derived_mathml": "<math><mi>M</mi></math>",
    }
]


@pytest.fixture
def document(make_case: MakeCase, scans: Scans, settings: ReportSettings) -> dict[str, Any]:
    cases = [make_case()]
    rows = [row for case in cases for row in rows_of_case(case, settings)]
    return build_document(settings, cases, scans, rows, CHECKS)


class Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.references: list[str] = []
        self.ids: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)

    VOID = frozenset({"meta", "br", "use", "path"})

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name in ("href", "src", "srcset", "data", "action", "poster"):
                self.references.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_page_needs_nothing_beside_it(document: dict[str, Any]) -> None:
    text = render(document)
    page = Page(text)
    assert page.open == []
    assert not {"script", "link", "iframe", "img", "object", "embed", "base"} & set(page.tags)
    assert all(r.startswith("#") for r in page.references)
    assert {r.removeprefix("#") for r in page.references} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert "@import" not in text
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", text))
    assert not re.findall(r"https?:|//[a-z]", text)


def test_every_figure_of_the_document_is_in_the_page(document: dict[str, Any]) -> None:
    page = Page(render(document))
    assert page.tags.count("svg") == len(document["figures"]) == page.tags.count("figure")
    for name, data in document["figures"].items():
        assert f"figure-{name}" in page.ids
        assert data["title"] in page.text
    assert page.tags.count("math") == sum(map(len, FORMULAS.values())) + 2


def test_every_row_is_in_the_page_with_its_verdict_and_numbers(document: dict[str, Any]) -> None:
    page = Page(render(document))
    text = " ".join(page.text.split())
    for row in document["rows"]:
        assert number(row["value"], row["error"]) in text
        assert deviation(row) in text
        assert row["verdict"] in text
        assert row["note"] in text


def test_texts_are_escaped(document: dict[str, Any]) -> None:
    evil = "<script>alert('x')</script>&\""
    document["title"] = document["summary"] = evil
    document["findings"] = [evil]
    document["answers"] = [{"question": evil, "answer": evil, "numbers": []}]
    document["rows"][0]["note"] = document["rows"][0]["source"] = evil
    document["algebra"] = [CHECKS[0] | {"label": evil, "note": evil}]
    document["figures"]["kurtosis"]["title"] = evil
    document["figures"]["kurtosis"]["description"] = evil
    document["software"]["numpy"] = evil
    text = render(document)
    assert "<script" not in text
    assert Page(text).text.count(evil) >= 12


def test_the_json_is_strict_and_round_trips(document: dict[str, Any]) -> None:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} in the JSON")

    text = dumps(document)
    assert json.loads(text, parse_constant=refuse) == document
    assert document["schema"] == "inelastic-lorentz/report/1"


def test_the_document_names_what_it_needs(document: dict[str, Any]) -> None:
    assert set(document) == {
        "schema", "title", "summary", "units", "software", "settings", "verdicts",
        "verdict_counts", "multiple_comparisons", "findings", "rows", "algebra", "cases", "figures",
        "answers", "scans",
    }  # fmt: skip
    names = {
        "observable", "restitution", "kind", "source", "against", "value", "theory", "deviation",
        "error", "time", "c", "distance", "sigmas", "corrected_sigmas", "looks", "groups",
        "verdict", "note",
    }  # fmt: skip
    for row in document["rows"]:
        assert set(row) == names
        assert row["verdict"] in document["verdicts"]
        assert row["note"] is not None
    assert sum(document["verdict_counts"].values()) == len(document["rows"])
    for data in document["figures"].values():
        for series in data["series"]:
            assert len(series["x"]) == len(series["y"])
            assert series["error"] is None or len(series["error"]) == len(series["x"])


def test_both_files_are_written(document: dict[str, Any], tmp_path: Path) -> None:
    stages: list[str] = []
    paths = write_report(document, tmp_path / "out", stages.append)
    assert [p.name for p in paths] == ["report.json", "report.html"]
    assert json.loads(paths[0].read_text(encoding="utf-8")) == document
    assert paths[1].read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert stages == ["writing"]


def test_the_printed_table_has_a_verdict_per_comparison(document: dict[str, Any]) -> None:
    lines = verdict_table(document).splitlines()
    assert len(lines) == 1 + len(document["rows"])  # one restitution
    assert all(any(w in line for w in document["verdicts"]) for line in lines[1:])
    assert max(len(line) for line in lines) <= 120


def test_findings_are_paragraphs_with_their_numbers(document: dict[str, Any]) -> None:
    path, density, cap, rate = document["findings"]
    # 12.5 d with half an error of 0.02 d; six quantities remain, each off by half its error
    assert path.startswith(
        "e = 0.7: hard disks have the mean free path 12.510 ± 0.020 d, +0.1 ± 0.2 %"
    )
    assert path.count("(agrees)") == 6
    assert path.endswith("kurtosis +0.5 ± 1.0 % (agrees).")
    assert "free path 1.000 ± 0.010, thermal speed 1.000 ± 0.010, ⟨r²⟩ 1.000 ± 0.010; 1" in density
    assert cap.endswith("The most that any had is 40; the cap would have cut none.")
    assert "1.340 ± 0.013; Boltzmann-Grad particles, at the same times, 1.340 ± 0.013;" in rate
    assert rate.endswith("the exact scaling state has 1.3333.")


def test_the_summary_counts_what_agrees(document: dict[str, Any]) -> None:
    assert "agree with its solution in 10 of 10 comparisons" in document["summary"]
    assert "the solver meets the closed forms in 3 of 3. 1 printed" in document["summary"]
    assert document["summary"].endswith("re-derived; all hold.")


def test_trapped_tracers_and_the_cap_are_among_the_findings(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case()
    statuses = {"finished": 9_990, "trapped": 10, "escaped": 0}
    disks = replace(case.hard, statuses=statuses, most_collisions=200, above_cap=0.01)
    rows = rows_of_case(case, settings)
    found = build_document(settings, [replace(case, hard=disks)], None, rows, CHECKS)["findings"]
    assert "200; up to 1.00% had more than 100, which the cap would have cut." in found[1]
    assert "counted as at rest there: 10 of 10000 at e = 0.7. The many bounces" in found[2]


def test_numbers_show_their_error() -> None:
    assert number(12.34567, 0.0123) == "12.346 ± 0.012"
    assert number(1234.5, 123.0) == "1234 ± 123"
    assert number(None) == "–"
    assert number(0.123456789) == "0.123457"


def test_columns_are_aligned() -> None:
    assert columns(["t", "v0"], [[1.0, 10.0], [0.5, 123456.0]]).splitlines() == [
        " t      v0",
        " 1     0.5",
        "10  123456",
    ]


def test_plain_leaves_no_numpy_and_no_nan() -> None:
    import numpy as np

    value = {"a": np.array([1.0, np.nan]), "b": (np.float64(2), np.int32(3)), "c": float("inf")}
    assert plain(value) == {"a": [1.0, None], "b": [2.0, 3], "c": None}


def test_figures_are_written_as_files(document: dict[str, Any], tmp_path: Path) -> None:
    document["figures"] = {name: document["figures"][name] for name in ("v0re", "traps")}
    paths = write_report(document, tmp_path / "out", formats=("svg", "pdf", "png", "png"))
    assert [p.name for p in paths[2:]] == [
        f"report-{name}.{kind}" for name in ("v0re", "traps") for kind in ("svg", "pdf", "png")
    ]
    starts = {".svg": b"<?xml", ".pdf": b"%PDF", ".png": b"\x89PNG"}
    for path in paths[2:]:
        assert path.read_bytes().startswith(starts[path.suffix])


def test_the_paper_s_figures_come_first_under_a_heading(document: dict[str, Any]) -> None:
    page = Page(render(document))
    names = [i.removeprefix("figure-") for i in page.ids if i.startswith("figure-")]
    assert tuple(names[:7]) == PAPER_FIGURES
    assert "The paper's figures" in page.text
    assert "Figures that the paper lacks" in page.text


def test_every_answer_is_in_the_page_with_its_numbers(document: dict[str, Any]) -> None:
    assert len(document["answers"]) == 5
    text = " ".join(Page(render(document)).text.split())
    for item in document["answers"]:
        assert item["question"] in text
        assert item["answer"] in text
        for n in item["numbers"]:
            assert n["name"] in text
            assert number(n["value"], n["error"]) in text


@pytest.mark.parametrize(("width", "dark"), [(360, False), (800, True), (1400, False)])
def test_the_report_in_a_browser(
    document: dict[str, Any], browser: Any, tmp_path: Path, width: int, dark: bool
) -> None:
    path = tmp_path / "report.html"
    path.write_text(render(document), encoding="utf-8")
    boxes = (
        "[...document.querySelectorAll('figure svg')].map(s => {"
        "const b = s.getBoundingClientRect(); return [b.left, b.right, b.width, b.height]})"
    )
    questions = {
        "boxes": boxes,
        "wide": "document.documentElement.scrollWidth",
        "background": "getComputedStyle(document.body).backgroundColor",
        "cut": "(b => b.scrollWidth - b.clientWidth)(document.querySelector('.wide'))",
    }
    seen = browser.visit(path, width, questions, dark)
    assert seen.complaints == []
    assert seen.requests == [path.resolve().as_uri()]
    assert len(seen.answers["boxes"]) == len(document["figures"]) == 17
    for left, right, across, down in seen.answers["boxes"]:
        assert left >= 0
        assert right <= width + 0.5
        assert across > 0.8 * min(width, 370)
        assert down > 200
    assert seen.answers["wide"] <= width  # only tables scroll, in boxes of their own
    assert (seen.answers["background"] == "rgb(20, 23, 27)") is dark
    if width >= 1400:  # the notes of every comparison are seen whole
        assert seen.answers["cut"] <= 0

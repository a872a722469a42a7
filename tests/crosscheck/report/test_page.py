"""The page and the JSON file: nothing external, nothing unescaped, nothing that the other lacks."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from pages import Page, check_alone

from kinetics.crosscheck.numerals import number
from kinetics.crosscheck.report.all_figures import PAPER_FIGURES
from kinetics.crosscheck.report.case import Case
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.citations import cited, with_numbers
from kinetics.crosscheck.report.equations import FORMULAS
from kinetics.crosscheck.report.page import deviation, render, verdict_table, verdict_words
from kinetics.crosscheck.report.picture import picture
from kinetics.crosscheck.report.report import build_document, write_report
from kinetics.crosscheck.report.settings import ReportSettings
from kinetics.crosscheck.strict_json import dumps
from kinetics.crosscheck.verdicts import EXPLAINED, WORDS

MakeCase = Callable[..., Case]


def test_the_page_needs_nothing_beside_it(built: dict[str, Any], text: str) -> None:
    page = check_alone(text, len(built["figures"]))
    assert len(text.encode()) < 3e6
    for name, data in built["figures"].items():
        assert f"figure-{name}" in page.ids
        assert data["title"] in page.text
    assert page.tags.count("math") == sum(map(len, FORMULAS.values())) + 2


def test_headings_are_in_order(text: str) -> None:
    levels = [int(tag[1]) for tag, _ in Page(text).elements if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(later - before <= 1 for before, later in pairwise(levels))


def test_the_contents_name_every_section(text: str) -> None:
    page = Page(text)
    contents = {r.removeprefix("#") for r in page.references if not r.startswith("#fig-")}
    sections = [a["id"] for tag, a in page.elements if tag == "h2"]
    assert contents == set(sections) - {"result", "contents", "words"}
    # the findings, how to read, the paper's claims and causes stand before all numbers
    assert sections[:5] == ["result", "contents", "words", "claims", "causes"]
    assert sections[-1] == "method"


def test_long_tables_are_folded(built: dict[str, Any], text: str) -> None:
    for folded in ("rows", "algebra", "verdicts"):
        section = text[text.index(f'<h2 id="{folded}">') :]
        table, details = section.index("<table"), section.index("<details")
        assert details < table < section.index("</details>")


def test_the_first_screen_says_what_was_compared_and_what_came_out(
    built: dict[str, Any], text: str
) -> None:
    page = Page(text)
    words = page.words
    first = words[words.index("A tracer flies") : words.index("Contents")]
    assert "Compared for e = 0.7: the kinetic equation, solved to 10⁻¹⁰" in first
    assert "200 000 trajectories in the dilute limit, and 10 000 among hard disks" in first
    # made up: both runs half an error of 1 % above the equation, the corrected equation 0.9 of it
    assert "no difference in 10 of 10 comparisons" in first
    assert "h/(1 − e) falls from 1.43 to 4/3 and is 1.333 at" in first
    assert "at the last time ⟨r²⟩ is 0.5 % above it" in first
    assert "differs by +12 %" in first
    assert 4 <= len(built["headline"]["findings"]) <= 5
    heads = [i for i in page.ids if i.startswith("figure-")][:2]
    assert heads == ["figure-cooling-rate", "figure-msd-ratio"]
    assert page.ids.index(heads[1]) < page.ids.index("contents")


def test_the_picture_of_the_system_stands_in_the_head(document: dict[str, Any]) -> None:
    drawn = picture(ReportSettings((0.7,), count=200, final_times=(30.0,)))
    assert drawn is not None
    assert picture(ReportSettings((0.7,), dimension=3)) is None
    page = Page(drawn["svg"])
    assert {"svg", "title", "desc"} <= set(page.tags)
    assert all(i.startswith("fig-picture-") for i in page.ids)
    document["figures"] = {"kurtosis": document["figures"]["kurtosis"]}
    page = Page(render(document | {"picture": drawn}))
    assert page.ids.index("figure-picture") < page.ids.index("contents")
    assert drawn["description"] in page.text


def test_the_causes_of_the_fitted_rate_are_computed(built: dict[str, Any], text: str) -> None:
    # made up: exact h = 0.4, the same slope at all times; disks half an error of 1 % above it
    (step,) = built["causes"]
    assert step["exact"] == pytest.approx(0.4 / 0.3)
    assert step["same_times"] == pytest.approx(0.4 / 0.3)
    assert step["start"] == pytest.approx(0.0, abs=1e-12)
    assert step["density"]["value"] == pytest.approx(0.005)
    assert step["density"]["error"] == pytest.approx(0.01)
    assert step["predicted"] == pytest.approx(0.0, abs=1e-12)
    assert step["free_path"]["value"] == pytest.approx(0.0008)
    assert step["fit_off"] == pytest.approx(1.45 * 0.3 / 0.4 - 1)
    assert "+0.5 ± 1.0 %" in Page(text).words


def test_the_claims_of_the_paper_are_judged(built: dict[str, Any]) -> None:
    found = {item["claim"]: item for item in built["claims"]}
    assert found["The tracer is localized for e < 1."]["judgement"] == "does not hold"
    # made up: <r^2> = 800 ln(1 + t/30) until 1000 d/U, constant beyond; the limit is 9 l^2
    assert "adds 3240 d²" in found["The tracer is localized for e < 1."]["text"]
    walk = found["The random walk becomes identical with the simulation as time goes on."]
    assert walk["place"] == "after eq. (22)"
    assert re.search(r"⟨r²⟩ of hard disks is [+−]\d+\.\d ± \d\.\d % from eq\. \(22\)", walk["text"])
    assert {item["judgement"] for item in built["claims"]} <= {
        "holds", "holds in part", "does not hold"
    }  # fmt: skip


def test_equations_are_cited_by_number_with_the_label_as_a_tooltip(text: str) -> None:
    page = Page(text)
    for label in ("ad8", "gammatailg", "vchange", "inelaslorentz2", "hsimu", "soninediffuse"):
        assert label not in page.text
    tooltips = {a["title"] for tag, a in page.elements if tag == "abbr"}
    assert {"label msd of the paper", "label gammatailg of the paper"} <= tooltips
    assert with_numbers("see eq. ad8, ad8#2 and sonine9; if N is large") == (
        "see eq. (C8), eq. (C9) and eq. (B15); if N is large"
    )
    assert str(cited("<b> eq. (22)")) == (
        '&lt;b&gt; <abbr title="label msd of the paper">eq. (22)</abbr>'
    )


def test_words_of_verdicts_are_explained_before_their_first_use(text: str) -> None:
    page = Page(text).words
    explained = page.index("How to read the verdicts")
    for word in EXPLAINED:
        assert page.index(word, explained) < page.index("The paper’s claims, judged", explained)
    shown = set(re.findall(r'<span class="verdict \w+">([^<]*)</span>', text))
    assert shown <= {*EXPLAINED, "off by", "no value", "verified",
                     "holds", "holds in part", "does not hold"}  # fmt: skip
    assert "agrees" not in page


def test_no_difference_says_what_would_have_been_seen(built: dict[str, Any], text: str) -> None:
    row = next(r for r in built["rows"] if r["observable"] == "msd" and r["verdict"] == "agrees")
    # half an error of 1 % off, and 1.96 errors
    assert row["within"] == pytest.approx(0.005 + 0.0196)
    assert verdict_words(row) == {
        "word": "no difference", "more": "better than 2.5 %", "style": "agrees"
    }  # fmt: skip
    assert verdict_words(row | {"within": 0.3})["style"] == "weak"
    assert verdict_words(row | {"verdict": "differs"})["more"] == ""
    assert "no difference, better than 2.5 %" in Page(text).words


def test_numbers_are_typeset(text: str) -> None:
    page = Page(text).text
    assert not re.findall(r"\d[eE][+-]?\d", page)
    assert "np.float" not in page
    assert not re.findall(r"(?<![\w)])-\d", page)  # true minus signs


def test_every_row_is_in_the_page_with_its_verdict_and_numbers(
    built: dict[str, Any], text: str
) -> None:
    page = Page(text).words
    for row in built["rows"]:
        assert number(row["value"], row["error"]) in page
        assert deviation(row) in page
        assert WORDS[row["verdict"]] in page
        assert row["note"] in page


def test_texts_are_escaped(document: dict[str, Any]) -> None:
    evil = "<script>alert('x')</script>&\""
    document["title"] = document["summary"] = evil
    document["findings"] = [evil]
    document["answers"] = [{"question": evil, "answer": evil, "numbers": []}]
    document["rows"][0]["note"] = document["rows"][0]["source"] = evil
    document["algebra"] = [document["algebra"][0] | {"label": evil, "note": evil}]
    document["figures"] = {"kurtosis": document["figures"]["kurtosis"]}
    document["headline"] = {"compared": evil, "findings": [evil], "line": evil}
    document["claims"] = [{"claim": evil, "place": evil, "judgement": "holds", "text": evil}]
    document["figures"]["kurtosis"]["title"] = evil
    document["figures"]["kurtosis"]["description"] = evil
    document["software"]["numpy"] = evil
    text = render(document)
    assert "<script" not in text
    assert Page(text).text.count(evil) >= 17


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
        "answers", "scans", "headline", "claims", "causes",
    }  # fmt: skip
    names = {
        "observable", "restitution", "kind", "source", "against", "value", "theory", "deviation",
        "error", "time", "c", "distance", "sigmas", "corrected_sigmas", "looks", "groups",
        "verdict", "note", "within",
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
    document["figures"] = {"traps": document["figures"]["traps"]}
    paths = write_report(document, tmp_path / "out", stages.append)
    assert [p.name for p in paths] == ["report.json", "report.html"]
    assert json.loads(paths[0].read_text(encoding="utf-8")) == document
    assert paths[1].read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert stages == ["writing"]


def test_the_printed_table_has_a_line_per_comparison(document: dict[str, Any]) -> None:
    document["rows"][0] |= {"verdict": "differs"}
    lines = verdict_table(document).splitlines()
    observables = {row["observable"] for row in document["rows"]}
    # the legend, an empty line, the restitutions, a line for each observable and each comparison
    assert len(lines) == 3 + len(observables) + len(document["rows"])
    (first, *_) = [line for line in lines if line.startswith("  ")][1:]
    assert "! +" in first
    # six restitutions stand in two tables
    many = document["settings"] | {"restitutions": [0.7, 0.1, 0.2, 0.3, 0.4, 0.5]}
    assert len(verdict_table(document | {"settings": many}).splitlines()) == 2 * len(lines) - 1
    for text in (verdict_table(document | {"settings": many}), document["headline"]["line"]):
        assert max(map(len, text.splitlines())) <= 100
    assert document["headline"]["line"].startswith("Finding: h/(1 − e) is 1.33, not 1.45; ⟨r²⟩ of")


def test_findings_are_paragraphs_with_their_numbers(document: dict[str, Any]) -> None:
    path, density, cap, rate = document["findings"]
    # 12.5 d with half an error of 0.02 d; six quantities remain, each off by half its error
    assert path.startswith(
        "e = 0.7: hard disks have the mean free path 12.510 ± 0.020 d, +0.1 ± 0.2 %"
    )
    assert path.count("(no difference)") == 6
    assert path.endswith("⟨r⁴⟩/⟨r²⟩² +0.5 ± 1.0 % (no difference).")
    assert "free path 1.000 ± 0.010, thermal speed 1.000 ± 0.010, ⟨r²⟩ 1.000 ± 0.010; 1" in density
    assert cap.endswith("The most that any had is 40; the cap would have cut none.")
    assert "1.340 ± 0.013; Boltzmann-Grad particles, at the same times, 1.340 ± 0.013;" in rate
    assert "the kinetic equation, at the same times too, 1.3333;" in rate
    assert rate.endswith("the exact scaling state, later than all of them, has 1.3333.")


def test_the_summary_counts_what_agrees(document: dict[str, Any]) -> None:
    assert "show no difference from its solution in 10 of 10 comparisons" in document["summary"]
    assert "the solver meets the closed forms in 3 of 3. 1 printed" in document["summary"]
    assert document["summary"].endswith("re-derived; all hold.")


def test_trapped_tracers_and_the_cap_are_among_the_findings(
    make_case: MakeCase, settings: ReportSettings, built: dict[str, Any]
) -> None:
    case = make_case()
    statuses = {"finished": 9_990, "trapped": 10, "escaped": 0}
    disks = replace(case.hard, statuses=statuses, most_collisions=200, above_cap=0.01)
    rows = rows_of_case(case, settings)
    found = build_document(settings, [replace(case, hard=disks)], None, rows, built["algebra"])[
        "findings"
    ]
    assert "200; up to 1.00% had more than 100, which the cap would have cut." in found[1]
    assert "counted as at rest there: 10 of 10000 at e = 0.7. The many bounces" in found[2]


@pytest.mark.slow
def test_figures_are_written_as_files(document: dict[str, Any], tmp_path: Path) -> None:
    document["figures"] = {name: document["figures"][name] for name in ("a2", "traps")}
    paths = write_report(document, tmp_path / "out", formats=("svg", "pdf", "png", "png"))
    assert [p.name for p in paths[2:]] == [
        f"report-{name}.{kind}" for name in ("a2", "traps") for kind in ("svg", "pdf", "png")
    ]
    starts = {".svg": b"<?xml", ".pdf": b"%PDF", ".png": b"\x89PNG"}
    for path in paths[2:]:
        assert path.read_bytes().startswith(starts[path.suffix])


def test_the_paper_s_figures_come_first_under_a_heading(text: str) -> None:
    page = Page(text)
    names = [i.removeprefix("figure-") for i in page.ids if i.startswith("figure-")]
    assert tuple(names[2:9]) == PAPER_FIGURES
    assert "The paper's figures" in page.text
    assert "Figures that the paper lacks" in page.text


def test_every_answer_is_in_the_page_with_its_numbers(built: dict[str, Any], text: str) -> None:
    assert len(built["answers"]) == 5
    page = Page(text).words
    for item in built["answers"]:
        assert item["question"] in page
        assert item["answer"] in page
        for n in item["numbers"]:
            assert n["name"].replace(" - ", " − ").replace("a2", "a₂") in page
            digits = {"%": 3, "d/U": 3, "σ": 3}.get(n["unit"], 5)
            assert number(n["value"], n["error"], digits=digits) in page

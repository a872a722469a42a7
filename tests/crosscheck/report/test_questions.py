"""The answers to the paper's questions follow from the numbers of a made-up case."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kinetics.crosscheck.report.case import Case
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.questions import all_answers
from kinetics.crosscheck.report.settings import ReportSettings

MakeCase = Callable[..., Case]


def numbers_of(answer: dict[str, Any]) -> dict[tuple[str, float | None], tuple[float, float]]:
    return {(n["name"], n["restitution"]): (n["value"], n["error"]) for n in answer["numbers"]}


@pytest.fixture
def answers(make_case: MakeCase, settings: ReportSettings) -> list[dict[str, Any]]:
    cases = [make_case(restitution=0.4), make_case(2.0, restitution=0.7)]
    rows = [row for case in cases for row in rows_of_case(case, settings)]
    return all_answers(cases, rows, settings)


def test_the_questions_are_those_of_the_paper(answers: list[dict[str, Any]]) -> None:
    words = ["proportional", "Gaussian", "ln t", "exponential", "approximation"]
    assert len(answers) == len(words)
    for word, answer in zip(words, answers, strict=True):
        assert word in answer["question"]
        assert "nan" not in answer["answer"]


def test_h_over_inelasticity_with_its_error(answers: list[dict[str, Any]]) -> None:
    found = numbers_of(answers[0])
    # h = 0.4 and two errors of 1 % of it, at e = 0.7
    value, error = found["h/(1 - e), Boltzmann-Grad", 0.7]
    assert value == pytest.approx(1.02 * 0.4 / 0.3)
    assert error == pytest.approx(0.01 * 0.4 / 0.3)
    # the shape of h(e)/(1-e) is exact, whatever the cases: sqrt(2), a maximum, 4/3
    assert "1.4142" in answers[0]["answer"]
    assert "1.4297" in answers[0]["answer"]
    assert "7.2 %" in answers[0]["answer"]


def test_the_vdf_is_no_gaussian_where_a2_passes_through_zero(
    answers: list[dict[str, Any]],
) -> None:
    found = numbers_of(answers[1])
    assert found["e at which the exact a2 is 0", None][0] == pytest.approx(0.5929, abs=1e-4)
    # These particles follow a Gaussian to half an error and two errors: nothing speaks against it.
    assert found["its sigmas, corrected for the bins looked at", 0.4][0] == 0
    assert found["its sigmas, corrected for the bins looked at", 0.7][0] < 1


def test_the_late_slope_and_when_it_is_reached(answers: list[dict[str, Any]]) -> None:
    found = numbers_of(answers[2])
    # the made-up state has 9 l^2, the made-up <r^2> 800 d^2, so that 99 % are never reached
    assert found["late slope, exact", 0.4][0] == pytest.approx(9 * 12.5**2)
    value, error = found["mean slope over the last decade, Boltzmann-Grad", 0.4]
    theory = found["mean slope over the last decade, kinetic equation", 0.4][0]
    assert value == pytest.approx(1.005 * theory)
    assert error == pytest.approx(0.01 * theory)


def test_an_exponential_tail_is_called_one(answers: list[dict[str, Any]]) -> None:
    found = numbers_of(answers[3])
    assert found["n at R = 4, kinetic equation", 0.4][0] == 1
    assert answers[3]["answer"].startswith("Nearly so")


def test_a_steeper_tail_is_not_called_exponential(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case()
    position: Any = case.position
    position.position_tail = lambda r: (np.full((1, len(r)), 1.3), 2.0 * np.asarray(r)[None])
    answer = all_answers([replace(case, position=position)], [], settings)[3]
    assert answer["answer"].startswith("Not where it can be seen")
    assert "grows by 100 %" in answer["answer"]


def test_deviations_are_those_of_the_rows(
    answers: list[dict[str, Any]], make_case: MakeCase, settings: ReportSettings
) -> None:
    found = numbers_of(answers[4])
    rows = [r for r in rows_of_case(make_case(), settings) if r.kind == "approximation"]
    assert {r.observable for r in rows} == {
        "cooling_rate", "a2", "msd", "msd_slope", "kurtosis", "position"
    }  # fmt: skip
    fit = found["paper's fit for h(e), against exact", 0.7][0]
    assert fit == pytest.approx(100 * (1.45 * 0.3 / 0.4 - 1))
    assert len(found) == 2 * len(rows)


def test_nothing_is_answered_where_nothing_cools(
    make_case: MakeCase, settings: ReportSettings
) -> None:
    case = make_case(restitution=1.0)
    assert all_answers([case], rows_of_case(case, settings), settings) == []

"""One report of a made-up case, and its page: drawing it takes most of the time of its tests."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from kinetics.crosscheck.report.case import Case, Scans
from kinetics.crosscheck.report.case_rows import rows_of_case
from kinetics.crosscheck.report.page import render
from kinetics.crosscheck.report.report import build_document
from kinetics.crosscheck.report.settings import ReportSettings

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


@pytest.fixture(scope="session")
def built(make_case: MakeCase, scans: Scans, settings: ReportSettings) -> dict[str, Any]:
    cases = [make_case()]
    rows = [row for case in cases for row in rows_of_case(case, settings)]
    return build_document(settings, cases, scans, rows, CHECKS)


@pytest.fixture
def document(built: dict[str, Any]) -> dict[str, Any]:
    """A copy that a test may change."""
    return deepcopy(built)


@pytest.fixture(scope="session")
def text(built: dict[str, Any]) -> str:
    """The page of the document as it is: drawing it takes most of the time of these tests."""
    return render(built)

"""The labels that the report shows: all derived, with the verdicts that a reader should see."""

import derivations
from derivations import Status, report_subset, verify


def test_the_report_subset_has_its_verdicts() -> None:
    checks = {check.label: check for check in verify(report_subset)}
    assert len(checks) == 16
    errata = {label for label, check in checks.items() if check.status is not Status.VERIFIED}
    assert errata == {"ad8"}
    for check in checks.values():
        assert check.steps
        assert check.printed_latex
        assert check.derived_latex


def test_public_names_exist() -> None:
    for name in derivations.__all__:
        assert getattr(derivations, name) is not None

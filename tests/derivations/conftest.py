"""What the tests of the derivations share."""

import pytest

from derivations import Check, verify


@pytest.fixture(scope="session")
def checks() -> tuple[Check, ...]:
    """All rows, derived once and not while the tests are collected: it takes ten seconds."""
    return verify()


@pytest.fixture(scope="session")
def rows(checks: tuple[Check, ...]) -> dict[str, Check]:
    return {row.label: row for row in checks}

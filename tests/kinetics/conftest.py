"""What the tests of the solver share."""

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # for example_values.py and others that several tests import


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A missed tolerance warns; the tests of this folder look at the status."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.filterwarnings("ignore::kinetics.ToleranceWarning"))

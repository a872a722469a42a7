"""What the tests of the solver share: the reference values, and the formulas behind them."""

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import collision
import cooling
import pytest

from kinetics.crosscheck.references import load

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # for example_values.py and others that several tests import


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A missed tolerance warns; the tests of this folder look at the status."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.filterwarnings("ignore::kinetics.ToleranceWarning"))


@pytest.fixture(scope="session")
def formulas() -> SimpleNamespace:
    """Closed forms of one collision, and series and integrals in time, in mpmath."""
    return SimpleNamespace(**{**vars(collision), **vars(cooling)})


@pytest.fixture(scope="session")
def numbers() -> Any:
    """The tables of `kinetics.crosscheck.references`."""
    return load()

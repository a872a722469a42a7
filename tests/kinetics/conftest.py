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
sys.path.insert(0, str(HERE))  # for example_values.py, which several test files import


@pytest.fixture(scope="session")
def formulas() -> SimpleNamespace:
    """Closed forms of one collision, and series and integrals in time, in mpmath."""
    return SimpleNamespace(**{**vars(collision), **vars(cooling)})


@pytest.fixture(scope="session")
def numbers() -> Any:
    """The tables of `kinetics.crosscheck.references`."""
    return load()

"""What the tests of the solver share: the reference values, and the formulas behind them."""

import signal
import sys
from collections.abc import Iterator
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


@pytest.fixture
def no_hang() -> Iterator[None]:
    """A test that is stuck fails, and does not stop the suite; five minutes for a few cases."""

    def stop(*_: Any) -> None:
        raise TimeoutError("the run did not end")

    if not hasattr(signal, "SIGALRM"):
        yield
        return
    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(300)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)

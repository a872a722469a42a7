"""What all tests share."""

import os
import sys
from pathlib import Path
from typing import Any

import pytest

# the matrices are small: threads of the linear algebra only get into each other's way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# the formulas behind the reference values: collision.py, cooling.py, displacement.py, densities.py
sys.path.insert(0, str(Path(__file__).with_name("references")))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """The tests of a file run in one process, which prepares what they share once."""
    from xdist.scheduler import LoadFileScheduling

    return LoadFileScheduling(config, log)

"""Debian's Chromium for the tests of pages, where it is installed."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # for chromium.py and pages.py

from chromium import Browser, found


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Debian's Chromium; skips where there is none."""
    program = found()
    if program is None:
        pytest.skip("no Chromium on PATH")
    with Browser(program) as opened:
        yield opened

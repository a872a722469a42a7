"""Debian's Chromium for the tests of pages, where it is installed."""

import shutil
from collections.abc import Iterator
from typing import Any

import pytest
from chromium import Browser


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Debian's Chromium; skips where there is none."""
    names = ("chromium", "chromium-browser", "google-chrome")
    program = next(filter(None, map(shutil.which, names)), None)
    if program is None:
        pytest.skip("no Chromium on PATH")
    opened = Browser(program, str(tmp_path_factory.mktemp("profile")))
    yield opened
    opened.close()

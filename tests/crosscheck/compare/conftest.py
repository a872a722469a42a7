"""Fixtures of made data, see made_data.py."""

from pathlib import Path

import pytest
from made_data import Run, place_in, write_csv


@pytest.fixture(scope="session")
def runs() -> dict[int, Run]:
    """Absolute positions and velocities in the plane and in space."""
    return {2: place_in(2), 3: place_in(3)}


@pytest.fixture(scope="session")
def run(runs: dict[int, Run]) -> Run:
    return runs[2]


@pytest.fixture(scope="session")
def csv(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("data") / "data.csv"
    write_csv(path, run)
    return path

"""A run that is killed at any moment, also before it has saved anything, is resumed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("kill_runs.py")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
@pytest.mark.parametrize("kills", [3, 200])
def test_killed_runs_are_resumed_to_the_same_bits(kills: int, tmp_path: Path) -> None:
    command = [sys.executable, str(PROGRAM), str(tmp_path), str(kills), "7"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["killed"] == kills
    assert found["finished"] > 0
    assert found["wrong"] == [], done.stderr

"""The references of these tests: formulas in mpmath, and numbers that they gave."""

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # for example_values.py, which several test files import


@pytest.fixture(scope="session")
def formulas() -> ModuleType:
    """kinetic_references.py: closed forms and series in mpmath."""
    path = HERE / "kinetic_references.py"
    spec = importlib.util.spec_from_file_location("kinetic_references", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def numbers() -> Any:
    """kinetic_references.json, written by that file."""
    return json.loads((HERE / "kinetic_references.json").read_text(encoding="utf-8"))

"""The scripts of this folder name constants that exist, and restore what they change."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

HERE = Path(__file__).parent


def load(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(HERE))
    spec = importlib.util.spec_from_file_location(f"measurements_{name}", HERE / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("script", "lists"), [("scaling", ["CONSTANTS"])])
def test_every_constant_is_a_number_of_its_module(
    script: str, lists: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = load(script, monkeypatch)
    for name in lists:
        for constant in getattr(module, name):
            assert isinstance(getattr(constant.module, constant.name), int | float)


def test_a_scan_tries_each_value_and_restores_it(
    monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    scan = load("scan", monkeypatch)
    room = ModuleType("room")
    room.WIDTH = 4.0  # type: ignore[attr-defined]
    seen = []

    def measure() -> Any:
        seen.append(room.WIDTH)
        return scan.Outcome({"f": room.WIDTH}, 0.5, 10.0, 0)

    monkeypatch.setattr(sys, "argv", ["script"])
    scan.scan([scan.Constant(room, "WIDTH", (0.5, 2.0))], measure, "nodes")
    assert seen == [4.0, 2.0, 8.0]
    assert room.WIDTH == 4.0
    assert "4*" in capsys.readouterr().out

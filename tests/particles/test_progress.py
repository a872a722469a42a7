"""The bar of `simulate(progress=True)`: on a terminal, in a notebook, and in neither."""

import sys
from types import ModuleType

import pytest

from particles import BoltzmannGrad, simulate


def run(progress: object) -> None:
    simulate(BoltzmannGrad(0.04), 0.7, times=[1.0], media=3, tracers=1, progress=progress)


def test_a_terminal_shows_a_bar_that_ends_full(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    run(progress=True)
    shown = capsys.readouterr().err
    assert "3/3" in shown.split("\r")[-1]
    assert shown.endswith("\n")


def test_a_notebook_shows_a_bar(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shell = type("ZMQInteractiveShell", (), {})()
    ipython = ModuleType("IPython")
    ipython.get_ipython = lambda: shell  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    run(progress=True)
    assert "3/3" in capsys.readouterr().err


@pytest.mark.parametrize("progress", [True, False, None])
def test_a_file_has_no_bar(progress: object, capsys: pytest.CaptureFixture[str]) -> None:
    run(progress=progress)
    assert capsys.readouterr().err == ""


def test_a_function_is_called_with_what_is_done() -> None:
    calls = []
    run(progress=lambda done, total: calls.append((done, total)))
    assert calls[0] == (0, 3)
    assert calls[-1] == (3, 3)


def test_what_shows_no_progress_is_refused() -> None:
    with pytest.raises(ValueError, match="progress"):
        run(progress="bar")

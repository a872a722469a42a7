"""The pages of the documentation and the README: their blocks print what they say."""

import importlib.util
import re
import shlex
from pathlib import Path

import click
import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "examples" / "docs"

_spec = importlib.util.spec_from_file_location("cells", DOCS / "_ext" / "cells.py")
assert _spec is not None
assert _spec.loader is not None
cells = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(cells)

PAGES = [page.relative_to(DOCS).as_posix() for page in sorted(DOCS.rglob("*.md"))]
WITH_BLOCKS = [name for name in PAGES if list(cells.cells(DOCS / name))]


@pytest.fixture(autouse=True)
def _no_window() -> None:
    import matplotlib

    matplotlib.use("Agg")


@pytest.mark.slow  # the same blocks are run when the pages are built
@pytest.mark.parametrize("name", WITH_BLOCKS)
def test_a_page_prints_what_it_says(name: str, tmp_path: Path) -> None:
    cells.run_page(DOCS / name, tmp_path)
    figures = re.findall(r"generated/([\w.]+)\)", (DOCS / name).read_text(encoding="utf-8"))
    saved = {path.name for path in tmp_path.iterdir() if path.suffix in (".svg", ".gif")}
    assert saved == set(figures)


def test_the_readme_prints_what_it_says(tmp_path: Path) -> None:
    assert list(cells.cells(ROOT / "README.md"))
    cells.run_page(ROOT / "README.md", tmp_path)


def test_every_file_that_a_page_names_exists() -> None:
    for name in ("README.md", *(f"examples/docs/{page}" for page in PAGES)):
        text = (ROOT / name).read_text(encoding="utf-8")
        for path in re.findall(r"`((?:examples|kinetics|tests|particles)/[\w./]+)`", text):
            assert (ROOT / path).exists(), f"{name}: {path}"


def test_the_commands_of_the_pages_have_the_options_that_they_use() -> None:
    from kinetics.cli import cli

    found = 0
    for name in PAGES:
        for block in re.findall(r"```sh\n(.*?)```", (DOCS / name).read_text("utf-8"), re.DOTALL):
            for line in block.splitlines():
                words = shlex.split(line)
                if words[0] == "lorentz":
                    command = cli.get_command(click.Context(cli), words[1])
                    assert command is not None
                    command.make_context(words[1], words[2:])
                    found += 1
    assert found >= 8

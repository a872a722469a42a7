"""Runs the Python blocks of a page, and holds what they print against what the page says.

The blocks of one page that open with ```python run one after another, as one script. Where a block
```text follows at once, it must hold exactly what the Python block prints; a Python block without
one must print nothing. Used when the pages are built, and by the tests, which also run the README
this way.
"""

import contextlib
import io
import os
import re
from collections.abc import Iterator
from pathlib import Path

_BLOCK = re.compile(
    r"^```python\n(.*?)^```$(?:\n\n?```text\n(.*?)^```$)?", re.DOTALL | re.MULTILINE
)
FIGURES = "generated"
"""Folder of the pages where the blocks save their figures."""


def cells(page: Path) -> Iterator[tuple[int, str, str]]:
    """Line number, source, and expected output of every Python block of a page."""
    text = page.read_text(encoding="utf-8")
    for found in _BLOCK.finditer(text):
        yield text.count("\n", 0, found.start()) + 2, found[1], found[2] or ""


def run_page(page: Path, folder: Path) -> None:
    """Run the blocks of a page in the folder. Raises AssertionError where the output differs."""
    names = {"__name__": "__main__"}
    with contextlib.chdir(folder):
        for line, source, expected in cells(page):
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile("\n" * (line - 1) + source, str(page), "exec"), names)
            assert printed.getvalue() == expected, (
                f"{page.name}, line {line}: the block prints\n{printed.getvalue()}"
                f"but the page says\n{expected}"
            )


def _run_all(app, config) -> None:
    import matplotlib

    matplotlib.use("Agg")
    here = Path(app.srcdir)
    folder = here / FIGURES
    folder.mkdir(exist_ok=True)
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")  # no dates in the figures
    for page in sorted(here.rglob("*.md")):
        run_page(page, folder)


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("config-inited", _run_all)
    return {"parallel_read_safe": True}

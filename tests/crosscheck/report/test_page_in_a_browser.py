"""What the page of the report looks like: contrast of its colours, and the page in a browser."""

import re
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from marking import slow_but
from pages import check_in_browser

from kinetics.crosscheck.report.strokes import CSS_VARIABLE


@pytest.mark.parametrize("scheme", ["light", "dark", "print"])
def test_texts_have_enough_contrast(scheme: str) -> None:
    """WCAG AA: 4.5 to 1, of every colour that is used for words, those in figures included."""
    style = (files("kinetics.crosscheck") / "templates" / "style.css.j2").read_text("utf-8")
    blocks = re.findall(r":root \{(.*?)\}", style, flags=re.DOTALL)
    assert len(blocks) == 3
    colours = dict(re.findall(r"--([\w-]+): (#\w+);", blocks[0]))
    if scheme != "light":
        colours |= dict(re.findall(r"--([\w-]+): (#\w+);", blocks[1 if scheme == "dark" else 2]))
    papers = [_luminance(colours.pop(name)) for name in ("paper", "panel")]
    del colours["faint"]  # of rules and grids only
    assert len(colours) >= 16
    for name, colour in colours.items():
        light = _luminance(colour)
        for paper in papers[: 1 if name[:6] in ("series", "group-") else 2]:
            low, high = sorted((light, paper))
            assert (high + 0.05) / (low + 0.05) >= 4.5, (scheme, name)


def _luminance(colour: str) -> float:
    if len(colour) == 4:
        colour = "#" + "".join(2 * digit for digit in colour[1:])
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    r, g, b = (x / 12.92 if x <= 0.03928 else ((x + 0.055) / 1.055) ** 2.4 for x in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def test_a_sheet_has_a_variable_for_every_colour_of_the_figures() -> None:
    style = (files("kinetics.crosscheck") / "templates" / "style.css.j2").read_text("utf-8")
    for sheet in re.findall(r":root \{(.*?)\}", style, flags=re.DOTALL):
        for variable in CSS_VARIABLE.values():
            assert sheet.count(variable[4:-1] + ":") == 1, variable


QUESTIONS = {
    "cut": "[...document.querySelectorAll('.scroll')].map(b => b.scrollWidth - b.clientWidth)",
    "hints": "[...document.querySelectorAll('.swipe')].filter(p => p.offsetHeight > 0).length",
    "head": "document.querySelector('.head svg').getBoundingClientRect().top",
    "overlaps": "[...document.querySelectorAll('.claims td')].every(t => t.offsetHeight > 10)",
}


@pytest.fixture(scope="module")
def page_file(text: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("width", "dark", "media"),
    slow_but(
        [(390, True, "screen"), (1400, False, "screen"), (1000, True, "print")],
        [(390, False, "screen"), (390, True, "screen"), (800, True, "screen"),
         (1400, False, "screen"), (1400, True, "screen"), (1000, False, "print"),
         (1000, True, "print")],
    ),
)  # fmt: skip
def test_the_report_in_a_browser(
    built: dict[str, Any], browser: Any, page_file: Path, width: int, dark: bool, media: str
) -> None:
    figures = len(built["figures"])
    found = check_in_browser(browser, page_file, figures, width, dark, media, QUESTIONS)
    assert found["overlaps"]
    if width >= 1400:  # no table is cut, and the first figure begins on the first screen
        assert max(found["cut"]) <= 0
        assert found["head"] < 700
    if width < 500:
        assert max(found["cut"]) > 0
        assert found["hints"] == len(found["cut"])


def test_the_browser_sees_errors_and_requests(browser: Any, tmp_path: Path) -> None:
    """The check itself can fail."""
    path = tmp_path / "bad.html"
    path.write_text("<img src='http://127.0.0.1:9/x.png'><script>nothing()</script>")
    seen = browser.visit(path, 400, {})
    assert any("127.0.0.1" in request for request in seen.requests)
    assert any("nothing is not defined" in text for text in seen.complaints)

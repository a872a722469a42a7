"""What every page of the package must be: whole by itself, well formed, readable at any width."""

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

FORBIDDEN = {"script", "link", "iframe", "img", "object", "embed", "base"}
VOID = {"meta", "br", "use", "path", "input"}
QUESTIONS = {
    "open": "[...document.querySelectorAll('details')].map(d => d.open = true).length",
    "boxes": "[...document.querySelectorAll('figure svg')].map(s => {"
    "const b = s.getBoundingClientRect(); return [b.left, b.right, b.width, b.height]})",
    "paths": "[...document.querySelectorAll('figure svg')].map("
    "s => s.querySelectorAll('path').length)",
    "maths": "[...document.querySelectorAll('.equation math')].map("
    "m => m.getBoundingClientRect().height)",
    "wide": "document.documentElement.scrollWidth",
    "background": "getComputedStyle(document.body).backgroundColor",
}


class Page(HTMLParser):
    """The elements of a page, its text, and what it refers to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.by_id: dict[str, str] = {}  # the text within
        self.open: list[tuple[str, str]] = []  # tag and id
        self.feed(text)
        assert self.open == []
        self.tags = [tag for tag, _ in self.elements]
        self.ids = [attrs["id"] or "" for _, attrs in self.elements if "id" in attrs]
        sources = ("href", "src", "srcset", "data", "action", "poster")
        self.references = [a[k] or "" for _, a in self.elements for k in sources if k in a]
        self.words = " ".join(self.text.split())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append((tag, dict(attrs).get("id") or ""))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop()[0] == tag

    def handle_data(self, data: str) -> None:
        tag, name = self.open[-1] if self.open else ("", "")
        if tag != "style":
            self.text += data
            self.by_id[name] = self.by_id.get(name, "") + data


def check_alone(text: str, figures: int) -> Page:
    """The page needs nothing beside it, and each of its figures has alternative text."""
    page = Page(text)
    assert not FORBIDDEN & set(page.tags)
    targets = [*page.references, *re.findall(r"url\(([^)]*)\)", text)]
    assert all(target.startswith(("#", "data:image/png")) for target in targets)
    assert {target[1:] for target in targets if target[0] == "#"} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert not re.findall(r"https?:|//[a-z]|@import", text)
    drawn = [attrs for tag, attrs in page.elements if tag == "svg"]
    assert len(drawn) == page.tags.count("figure") == figures
    for attrs in drawn:
        assert attrs["role"] == "img"
        title, description = (attrs["aria-labelledby"] or "").split()
        assert len(page.by_id[title]) > 5
        assert len(page.by_id[description]) > 50
    return page


def check_in_browser(
    browser: Any, path: Path, figures: int, width: int, dark: bool, more: dict[str, str]
) -> dict[str, Any]:
    """Nothing is loaded or complained of, and only tables scroll sideways, in boxes of their own.

    Returns the answers to QUESTIONS and to `more`, expressions of JavaScript.
    """
    seen = browser.visit(path, width, QUESTIONS | more, dark)
    found: dict[str, Any] = seen.answers
    assert seen.complaints == []
    assert [r for r in seen.requests if not r.startswith("data:")] == [path.resolve().as_uri()]
    assert len(found["boxes"]) == figures
    for left, right, across, down in found["boxes"]:
        assert left >= 0
        assert right <= width + 0.5
        assert across > 0.8 * min(width, 370)
        assert down > 200
    assert min(found["paths"]) > 5
    assert min(found["maths"], default=20) > 10
    assert found["wide"] <= width
    assert (found["background"] == "rgb(20, 23, 27)") is dark
    return found

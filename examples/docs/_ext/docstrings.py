"""Docstrings of the project as reStructuredText: they are written to be read as plain text.

Sections with a line of dashes, and paragraphs of lines ``name: text``, become lists; signs that
reStructuredText reads as markup, as in <v^2> or |v|, are escaped.
"""

import re

_CODE = re.compile(r"(``.+?``|:\w+:`[^`]+`|`[^`]+`)")
_ITEM = re.compile(r"^([\w*][\w*.]*(?:, [\w*]+)*(?: \([^)]*\))?) ?: (.*)$")
_LISTS = ("Parameters", "Attributes", "Returns", "Raises")


def _escaped(text: str) -> str:
    parts = _CODE.split(text)
    parts[::2] = [re.sub(r"([*_|\\])", r"\\\1", part) for part in parts[::2]]
    return "".join(parts)


def _items(lines: list[str]) -> list[str]:
    """Lines ``name : text``, each with its indented lines, as a list."""
    joined: list[str] = []
    for line in lines:
        if line.startswith(" ") and joined:
            joined[-1] += " " + line.strip()
        else:
            joined.append(line)
    matched = [(_ITEM.match(line), line) for line in joined]
    return [
        f"- **{_escaped(m[1])}**: {_escaped(m[2])}" if m else f"- {_escaped(line)}"
        for m, line in matched
    ]


def _paragraph(lines: list[str]) -> list[str]:
    head = lines[0].strip()
    if head.startswith(">>>"):
        return lines
    if len(lines) > 1 and set(lines[1].strip()) == {"-"}:
        return [f"**{head}**", "", *(_items(lines[2:]) if head in _LISTS else lines[2:])]
    if all(line.startswith(" ") or _ITEM.match(line) for line in lines) and len(lines) > 1:
        return _items(lines)
    return [_escaped(line.strip()) for line in lines]


def restructured(lines: list[str]) -> list[str]:
    """The lines of a docstring as reStructuredText."""
    paragraphs: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            paragraphs[-1].append(line)
        elif paragraphs[-1]:
            paragraphs.append([])
    found: list[str] = []
    for paragraph in filter(None, paragraphs):
        found += [*_paragraph(paragraph), ""]
    return found


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""

    def process(app, what, name, obj, options, lines) -> None:
        lines[:] = restructured(lines)

    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True}

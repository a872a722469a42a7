"""Docstrings of the project as reStructuredText: they are written to be read as plain text.

Sections with a line of dashes, and paragraphs of lines ``name: text``, become lists; signs that
reStructuredText reads as markup, as in <v^2> or |v|, are escaped.
"""

import re
from html import escape

_CODE = re.compile(r"(``.+?``|:\w+:`[^`]+`|`[^`]+`)")
_ITEM = re.compile(r"^([\w*][\w*.]*(?:, [\w*]+)*(?: \([^)]*\))?) ?: (.*)$")
_NAMES = re.compile(r"^[\w*.\[\], ]+$")
_LISTS = ("Parameters", "Attributes", "Returns", "Raises", "Warns")


#: Symbols whose names are words in docstrings.
_SYMBOLS = {"rho_0": "ρ₀", "rho0": "ρ₀", "d\\^-2": "d⁻²", "d\\^-3": "d⁻³", "D_v": "Dᵥ"}
_ROOT = re.compile(r"sqrt\((<[^<>]+>)\)")
_AVERAGE = re.compile(r"<(?:[rvNEc](?:_[ij])?(?:\^[0-9p])?|v\(0\)\.v|v_i v_j|exp\(i k\.r\))>")
_LABEL = re.compile(r"\blabel (\w+)")
_FORWARD_REFERENCE = re.compile(
    r'<span class="pre">TypeAliasForwardRef</span>'
    r'<span class="p"><span class="pre">\(</span></span>'
    r"<span class=\"s\"><span class=\"pre\">'(\w+)'</span></span>"
    r'<span class="p"><span class="pre">\)</span></span>'
)


def _escaped(text: str) -> str:
    parts = _CODE.split(mathematics(text))
    parts[::2] = [re.sub(r"([*_|\\])", r"\\\1", part) for part in parts[::2]]
    # a role must stand apart from what is beside it: an escaped blank does so without a gap
    parts[1::2] = [f"\\ {part}\\ " if part.startswith(":math:") else part for part in parts[1::2]]
    return "".join(parts)


def _items(lines: list[str]) -> list[str]:
    """Entries, each with its indented lines, as a list with the names in bold.

    An entry is ``name : text``, or a name alone on its line with the text below it.
    """
    entries: list[list[str]] = []
    for line in lines:
        if line.startswith(" ") and entries:
            entries[-1].append(line.strip())
        else:
            entries.append([line])
    return [_item(head, " ".join(text)) for head, *text in entries]


def _item(head: str, text: str) -> str:
    match = _ITEM.match(head)
    if match:
        return f"- **{_escaped(match[1])}**: {_escaped(f'{match[2]} {text}'.strip())}"
    if text and _NAMES.match(head):
        return f"- **{_escaped(head)}**: {_escaped(text)}"
    return f"- {_escaped(f'{head} {text}'.strip())}"


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


def mathematics(text: str) -> str:
    """The averages and labels of a line as formulas and as the paper's equation numbers."""
    text = _ROOT.sub(lambda m: f":math:`\\sqrt{{{_tex(m[1])}}}`", text)
    text = _AVERAGE.sub(lambda m: f":math:`{_tex(m[0])}`", text)
    for name, symbol in _SYMBOLS.items():
        text = re.sub(rf"\b{name}\b", symbol, text)
    return _LABEL.sub(_number_of, text)


def _tex(average: str) -> str:
    """An average such as <v(0).v> as TeX."""
    inner = average.strip("<>").replace("(0).", "(0)\\cdot ")
    return f"\\langle {inner}\\rangle"


def in_html(text: str) -> str:
    """A line with averages, powers and the paper's equation numbers, as HTML."""
    html = escape(_LABEL.sub(_number_of, text))
    html = (
        html.replace("sqrt(&lt;v^2&gt;)", "√&lt;v^2&gt;").replace("&lt;", "⟨").replace("&gt;", "⟩")
    )
    html = re.sub(r"\^(\d)", r"<sup>\1</sup>", html)
    return re.sub(r"_([ijxyz])\b", r"<sub>\1</sub>", html)


def _number_of(label: re.Match[str]) -> str:
    """The equation number of a label of the paper, where the algebra has it."""
    from derivations import printed_equation

    try:
        return f"eq. ({printed_equation(label[1]).number})"
    except ValueError:
        return label[0]


def without_forward_references(body: str) -> str:
    """A page whose signatures name types as they are, not as autodoc holds them."""
    return _FORWARD_REFERENCE.sub(r'<span class="pre">\1</span>', body)


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""

    def process(app, what, name, obj, options, lines) -> None:
        lines[:] = restructured(lines)

    def show(app, page, template, context, doctree) -> None:
        if "body" in context:
            context["body"] = without_forward_references(context["body"])

    app.connect("autodoc-process-docstring", process)
    app.connect("html-page-context", show)
    return {"parallel_read_safe": True}

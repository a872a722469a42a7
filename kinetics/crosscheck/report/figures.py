"""Figures: the data of one, as it stands in the JSON file, and the files drawn from it.

A figure's data are plain lists and strings:

    {"title", "description", "x": {"label", "unit", "scale", "limits"}, "y": {...},
     "series": [{"source", "restitution", "group", "x", "y", "error"}]}

`source` is who says so and decides the stroke; `restitution` decides colour and marker, None is
ink. A series may have a "group" (a text, or None) instead, which then decides the colour, and an
"x_range" [[low, high], ...], the range of x over which each point is an average.

Where it helps, a figure has also

- "order": the restitutions of the report, which have the same colours in all its figures;
- "panels": true for one panel for each restitution;
- "ratio": {"y": {...}, "series": [...]}, drawn in a panel below;
- "spans": [{"restitution", "low", "high"}], ranges of x over which a rate is averaged.
"""

import io
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinetics.crosscheck.report.layout import arranged
from kinetics.crosscheck.report.strokes import CSS_VARIABLE, STYLE
from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.strict_json import plain

Data = dict[str, Any]
FigureData = Mapping[str, Any]


def axis(
    label: str, unit: str = "", scale: str = "linear", limits: tuple[float, float] | None = None
) -> Data:
    """One axis; limits None leaves them to what is drawn."""
    ends = None if limits is None else list(limits)
    return {"label": label, "unit": unit, "scale": scale, "limits": ends}


def series(
    source: str,
    x: ArrayLike,
    y: ArrayLike,
    error: ArrayLike | None = None,
    restitution: float | None = None,
    group: str | None = None,
    x_range: ArrayLike | None = None,
) -> Data:
    """One line, or points with their standard errors; x, y and error of one length.

    x_range (n, 2): the range of x that each point is an average over.
    """
    ranges = {} if x_range is None else {"x_range": plain(np.asarray(x_range, dtype=float))}
    return {
        "source": source,
        "restitution": restitution,
        "group": group,
        "x": _floats(x),
        "y": _floats(y),
        "error": None if error is None else _floats(error),
        **ranges,
    }


def figure(
    name: str,
    x: Data,
    y: Data,
    lines: Sequence[Data],
    template: str = "figures.txt.j2",
    **values: Any,
) -> Data:
    """The data of one figure; `values` fill its title and description, which the template has."""
    title, description = paragraphs(template, name.replace("-", "_"), **values)
    return {"title": title, "description": description, "x": x, "y": y, "series": list(lines)}


def _floats(values: ArrayLike) -> list[float | None]:
    """Floats, and None for what has no finite value: JSON has no NaN."""
    floats: list[float | None] = plain(np.atleast_1d(np.asarray(values, dtype=float)))
    return floats


def svg(name: str, data: FigureData) -> str:
    """One figure as an `<svg>` element that can stand in a page beside others.

    Its ids carry the figure's name, its colours are the page's CSS variables, its text alternative
    is the title and description of the data, and the same data give the same text.
    """
    return embeddable(_drawn(data, "svg").decode(), name, data["title"], data["description"])


def figure_files(
    figures: Mapping[str, FigureData], prefix: str, formats: Iterable[str]
) -> dict[str, bytes]:
    """Every figure in every format, by the name of its file: PREFIX-NAME.FORMAT."""
    return {
        f"{prefix}-{name}.{kind}": figure_file(data, kind)
        for name, data in figures.items()
        for kind in dict.fromkeys(formats)
    }


def figure_file(data: FigureData, kind: str) -> bytes:
    """One figure as a file of its own, in the page's light colours: kind "svg", "pdf" or "png"."""
    drawn = _drawn(data, kind)
    if kind != "svg":
        return drawn
    head, body = drawn.decode().split("<svg", 1)
    attributes, rest = body.split(">", 1)
    alternative = _alternative(data["title"], data["description"])
    return f'{head}<svg{attributes} role="img">{alternative}{rest}'.encode()


def _alternative(title: str, description: str, prefix: str | None = None) -> str:
    """What a reader hears who cannot see the figure, with ids if there is a prefix for them."""
    ids = ("", "") if prefix is None else (f' id="{prefix}title"', f' id="{prefix}desc"')
    return f"<title{ids[0]}>{escape(title)}</title><desc{ids[1]}>{escape(description)}</desc>"


def _drawn(data: FigureData, kind: str) -> bytes:
    """The figure as matplotlib's file."""
    import matplotlib as mpl

    buffer = io.BytesIO()
    with mpl.rc_context(STYLE):
        figure = arranged(data)
        dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        figure.savefig(buffer, format=kind, metadata=dates[kind], dpi=200)
    return buffer.getvalue()


def embeddable(text: str, name: str, title: str, description: str) -> str:
    """Matplotlib's file as an element: own ids, own colours, no metadata, a text alternative."""
    prefix = f"fig-{name}-"
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", text).replace("xlink:href=", "href=")
    text = re.sub(r'\b(id="|href="#)(?=[^"])', rf"\1{prefix}", text)
    text = text.replace("url(#", f"url(#{prefix}")
    for colour, variable in CSS_VARIABLE.items():
        text = text.replace(colour, variable)
    head, body = text.split(">", 1)
    # The page gives the size; the view box keeps the proportions.
    head = re.sub(r'\s(width|height)="[^"]*"', "", head)
    return (
        f'{head} role="img" aria-labelledby="{prefix}title {prefix}desc">'
        f"{_alternative(title, description, prefix)}{body.strip()}"
    )

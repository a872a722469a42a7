"""Figures of a comparison, drawn with matplotlib from their data."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np


def draw(data: Any, ax: Any) -> None:
    """Draw one figure on matplotlib's axes: lines for theory, points with bars for data."""
    groups = [*dict.fromkeys(s["group"] for s in data["series"] if s["source"] != "zero")]
    for s in data["series"]:
        colour, label = f"C{groups.index(s['group']) if s['group'] in groups else 0}", s["group"]
        x, y = (np.array(s[name], float) for name in ("x", "y"))
        if s["source"] == "data":
            style = {"color": colour if len(groups) > 1 else "black", "ms": 4, "lw": 1}
            error = np.array(s["error"], float)
            ax.errorbar(x, y, error, fmt="o", label=label or "data", **style)
        elif s["source"] == "zero":
            ax.axhline(0.0, color="gray", lw=0.8)
        else:
            style = (
                {"color": "C1", "ls": "--"}
                if s["source"] == "best explanation"
                else {"color": colour}
            )
            ax.plot(x, y, label=None if label else s["source"], lw=1.2, **style)
    for name in ("x", "y"):
        unit = f" / {data[name]['unit']}" if data[name]["unit"] else ""
        ax.set(**{f"{name}label": data[name]["label"] + unit, f"{name}scale": data[name]["scale"]})
    ax.tick_params(axis="x", which="minor", labelsize="x-small", labelrotation=40)
    ax.set_title(data["title"], fontsize="medium")
    ax.legend(fontsize="small", frameon=False)


def drawn(figures: Sequence[Any], kind: str = "svg") -> bytes:
    """Figures in two columns as one picture, in a format of matplotlib's."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    wide = min(2, len(figures))
    high = -(-len(figures) // wide)
    figure = Figure(figsize=(4.6 * wide, 3.2 * high), layout="constrained")
    FigureCanvasAgg(figure)
    for k, data in enumerate(figures, 1):
        draw(data, figure.add_subplot(high, wide, k))
    buffer = io.BytesIO()
    dated: Any = (
        {} if kind == "png" else {"metadata": {"Date" if kind == "svg" else "CreationDate": None}}
    )
    figure.savefig(buffer, format=kind, dpi=150, **dated)
    return buffer.getvalue()

"""The figures of a comparison, drawn from its rows: data beside theory, and all deviations."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetics.crosscheck.compare.theory import OBSERVABLES

_DECADES = 30.0  # largest over smallest value from which on an axis is logarithmic
_REGIONS = {"68 %": 1.515, "95 %": 2.448}  # Radii that hold so much of a Gaussian of two numbers


def figures_of(result: Any) -> list[str]:
    """Each observable, "sigmas", and "confidence", the region of e and l, if both were fitted."""
    rows = result.rows[result.rows["time"] > 0]
    bins = rows[rows["high"].notna() & (rows["low"] > 0) & (rows["value"] > 0)]
    seen = {*rows[rows["low"].isna()]["observable"], *bins["observable"]}
    found = [name.replace("_", "-") for name in OBSERVABLES if name in seen]
    found += ["sigmas"] if len(rows[rows["low"].isna()]) else []
    both = np.shape(result.covariance) == (2, 2) and result.parameters["restitution"].value
    return found + (["confidence"] if both else [])


def draw(result: Any, figure: str, ax: Any) -> None:
    """Draw one figure on matplotlib's axes: lines for theory, points with bars for data."""
    name, rows = figure.replace("-", "_"), result.rows[result.rows["time"] > 0]
    bars = {"fmt": "o", "ms": 4, "lw": 1}
    labels, log = ["time $t$ / (d/U)", ""], [True, False]
    if name == "confidence":
        title, log = "Restitution and mean free path together", [False, False]
        labels = ["restitution $e$", "mean free path $l$ / d"]
        e, path = (result.parameters[k].value for k in ("restitution", "mean_free_path"))
        angle, root = np.linspace(0, 2 * np.pi, 121), np.linalg.cholesky(result.covariance)
        x, y = root @ np.stack([np.cos(angle), np.sin(angle)])
        for share, radius in _REGIONS.items():
            ax.plot(e + radius * x, path * np.exp(radius * y), label=share)
        ax.plot(e, path, "ko", ms=4, label="fitted")
    elif name == "sigmas":
        title, labels[1] = "Differences in standard errors", "difference / standard error"
        ax.axhline(0.0, color="gray", lw=0.8)
        averages = rows[rows["low"].isna()].dropna(subset="sigmas")
        for one, mine in averages.groupby("observable", sort=False):
            ax.errorbar(mine["time"], mine["sigmas"], 1.0, label=OBSERVABLES[one].symbol, **bars)
    else:
        seen, mine = OBSERVABLES[name], rows[rows["observable"] == name]
        title, unit = seen.title, f" / {seen.unit}" if seen.unit else ""
        labels[1] = seen.symbol + unit
        if seen.measured is None:
            labels, log = [seen.symbol + unit, f"density / (1/{seen.unit})"], [True, True]
            bins = mine[(mine["low"] > 0) & mine["high"].notna() & (mine["value"] > 0)]
            for k, (at, body) in enumerate(bins.groupby("time")):
                middle, colour = np.sqrt(body["low"] * body["high"]), f"C{k}"
                ax.plot(middle, body["theory"], color=colour)
                mark = {"color": colour, "label": f"t = {at:.4g}", **bars}
                ax.errorbar(middle, body["value"], body["error"], **mark)
        else:
            both = mine[["value", "theory"]].to_numpy()
            log[1] = bool(both.min() > 0 and both.max() > _DECADES * both.min())
            ax.plot(mine["time"], mine["theory"], label="kinetic equation")
            shown = {"color": "black", "label": "data", **bars}
            ax.errorbar(mine["time"], mine["value"], mine["error"], **shown)
    ax.set(xlabel=labels[0], ylabel=labels[1])
    for side, is_log in zip("xy", log, strict=True):
        if is_log:
            ax.set(**{f"{side}scale": "log"})
    ax.set_title(title, fontsize="medium")
    ax.legend(fontsize="small", frameon=False)


def drawn(result: Any, names: Sequence[str], kind: str = "svg") -> bytes:
    """Figures in two columns as one picture, in a format of matplotlib's."""
    from matplotlib.figure import Figure

    wide = min(2, len(names))
    high = -(-len(names) // wide)
    figure, buffer = Figure(figsize=(4.6 * wide, 3.2 * high), layout="constrained"), io.BytesIO()
    for k, name in enumerate(names, 1):
        draw(result, name, figure.add_subplot(high, wide, k))
    dated: Any = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(kind)
    figure.savefig(buffer, format=kind, dpi=150, metadata=dated)
    return buffer.getvalue()

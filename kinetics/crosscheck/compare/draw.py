"""The figures of a comparison: data beside theory, and the deviations of all rows."""

from typing import Any

import numpy as np

from kinetics.crosscheck.compare.theory import OBSERVABLES

_DECADES = 30.0
"""Largest over smallest value from which on an axis is logarithmic."""


def figures_of(result: Any) -> dict[str, Any]:
    """The data of every figure of a Comparison, by name: of each observable in its rows, "sigmas"
    and, where e and l were fitted, "confidence", the region that holds both at 68 and 95 %.

    Of a density the first bin and the last, which has no end, are not shown.
    """
    rows = result.rows

    def axis(label: str, unit: str = "", log: bool = False) -> dict[str, str]:
        return {"label": label, "unit": unit, "scale": "log" if log else "linear"}

    def series(source: str, x: Any, y: Any, error: Any = None, group: str = "") -> dict[str, Any]:
        lists = (None if a is None else np.asarray(a, float).tolist() for a in (x, y, error))
        named = dict(zip(("x", "y", "error"), lists, strict=True))
        return {"source": source, "group": group} | named

    figures, time = {}, axis("time $t$", "d/U", True)
    rows, sigmas = rows[rows["time"] > 0], []
    for name, mine in rows.groupby("observable", sort=False):
        seen, lines, x, y = OBSERVABLES[name], [], time, axis("")
        if seen.measured is None:
            x, y = axis(seen.symbol, seen.unit, True), axis("density", f"1/{seen.unit}", True)
            for at, bins in mine.groupby("time"):
                body = bins[(bins["low"] > 0) & bins["high"].notna() & (bins["value"] > 0)]
                middle, group = np.sqrt(body["low"] * body["high"]), f"t = {at:.4g}"
                if len(body):
                    lines.append(series("kinetic equation", middle, body["theory"], group=group))
                    lines.append(series("data", middle, body["value"], body["error"], group))
            if not lines:  # few tracers, in the first and the last bin
                continue
        else:
            both = mine[["value", "theory"]].to_numpy()
            wide = both.min() > 0 and both.max() > _DECADES * both.min()
            y = axis(seen.symbol, seen.unit, bool(wide))
            lines = [series("kinetic equation", mine["time"], mine["theory"]),
                     series("data", mine["time"], mine["value"], mine["error"])]  # fmt: skip
            z = mine.dropna(subset="sigmas")
            sigmas.append(series("data", z["time"], z["sigmas"], np.ones(len(z)), seen.symbol))
        figures[name.replace("_", "-")] = {"title": seen.title, "x": x, "y": y, "series": lines}
    if sigmas:
        zero = series("zero", rows["time"].agg(["min", "max"]), [0.0, 0.0])
        figures["sigmas"] = {
            "title": "Differences in standard errors", "x": time,
            "y": axis("difference / standard error"), "series": [zero, *sigmas],
        }  # fmt: skip
    if np.shape(result.covariance) == (2, 2):
        e, path = (result.parameters[name].value for name in ("restitution", "mean_free_path"))
        angle, root = np.linspace(0.0, 2 * np.pi, 121), np.linalg.cholesky(result.covariance)
        circle = root @ np.stack([np.cos(angle), np.sin(angle)])
        lines = [series("data", [e], [path])] if e else []
        for share, radius in ((68, 1.515), (95, 2.448)) if e else ():  # chi-square of two freedoms
            x, y = e + radius * circle[0], path * np.exp(radius * circle[1])
            lines.append(series("kinetic equation", x, y, group=f"{share} %"))
        if lines:
            figures["confidence"] = {
                "title": "Restitution and mean free path together", "x": axis("restitution $e$"),
                "y": axis("mean free path $l$", "d"), "series": lines,
            }  # fmt: skip
    return figures


def draw(data: Any, ax: Any) -> None:
    """Draw one figure on matplotlib's axes: lines for theory, points with bars for data."""
    groups = [*dict.fromkeys(s["group"] for s in data["series"] if s["source"] != "zero")]
    for s in data["series"]:
        if s["source"] == "zero":
            ax.axhline(0.0, color="gray", lw=0.8)
            continue
        colour = f"C{groups.index(s['group'])}"
        if s["source"] == "data":
            style = {"color": colour if len(groups) > 1 else "black", "ms": 4, "lw": 1}
            ax.errorbar(s["x"], s["y"], s["error"], fmt="o", label=s["group"] or "data", **style)
        else:
            ax.plot(s["x"], s["y"], color=colour, label=None if s["group"] else s["source"])
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for name, side in (("x", ax.xaxis), ("y", ax.yaxis)):
        unit = f" / {data[name]['unit']}" if data[name]["unit"] else ""
        ax.set(**{f"{name}label": data[name]["label"] + unit, f"{name}scale": data[name]["scale"]})
        low, high = side.get_view_interval()
        if data[name]["scale"] == "log":
            side.set_minor_formatter(NullFormatter())
            if high < 100 * low:  # few powers of ten
                side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
                side.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.set_title(data["title"], fontsize="medium")
    ax.legend(fontsize="small", frameon=False)

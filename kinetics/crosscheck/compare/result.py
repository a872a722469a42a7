"""Comparison: the result of comparing a sample with the kinetic equation, as a value, as tables for
the terminal, as figures, and as a page.
"""

import io
import json
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, Self

import numpy as np
import pandas as pd

from kinetics.crosscheck.compare.observables import OBSERVABLES
from kinetics.crosscheck.files import dumps, plain, rendered
from kinetics.crosscheck.words import LIMIT_SHARE, MEANING, Verdict, limit_factor, number, numeral
from kinetics.results.record import stored_class
from kinetics.results.result import Result
from kinetics.validation import refuse

_STATISTICAL = (Verdict.AGREES, Verdict.UNCLEAR, Verdict.DIFFERS, Verdict.NOT_TESTED)
SCHEMA = "inelastic-lorentz/comparison/1"
# what an explanation comes to, in words; in the order in which they are shown
OUTCOMES = {
    "explains": "explains the difference", "found": "found in the data",
    "in part": "explains part of it", "does not": "does not explain it", "noted": "noted",
}  # fmt: skip


class Row(NamedTuple):
    """An observable at a time, or in a bin of a density; see `Comparison.rows`."""

    observable: str
    time: float
    value: float
    error: float
    theory: float
    sigmas: float | None
    verdict: Verdict
    corrected_sigmas: float | None
    samples: int
    low: float | None = None
    high: float | None = None
    since: float | None = None


class ComparisonTest(NamedTuple):
    """All rows of an observable (of a density: at one time) by one chi-square.

    `groups` gave the covariance, None where it is known. `verdict` looks at `sigmas`, of the
    p-value times the number of tests, and, for an average, at the time that differs most. `within`:
    the relative difference (of 1 + a2) that the data exclude at every time, at 95 %.
    """

    observable: str
    time: float | None
    chi_square: float
    dof: int
    p_value: float
    groups: int | None
    sigmas: float
    verdict: Verdict
    within: float | None = None


class Parameter(NamedTuple):
    """A number of the theory: given (error None), or found; value None where no model fits."""

    value: float | None
    error: float | None
    source: str


class Explanation(NamedTuple):
    """Something that may explain a difference; chi-squares are of all averages.

    outcome: "explains" (what is left agrees, no other cause is much likelier), "in part" (T^2 falls
    by 16 and a tenth), "does not", "noted" (not tested) or "found" (in the data themselves).
    """

    name: str
    outcome: str
    text: str
    tested: bool = True
    value: float | None = None
    error: float | None = None
    chi_square_before: float | None = None
    chi_square_after: float | None = None
    dof: int | None = None
    p_value: float | None = None
    headline: str = ""


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """A sample compared with the kinetic equation; lengths in d, speeds in U, times in d/U.

    Attributes
    ----------
    verdict, summary : on everything, and in a sentence or two
    parameters : "restitution", "number_density", "mean_free_path" as Parameter
    initial : the start of the theory, in words
    samples, groups : tracers at most, and independent groups that the errors are from
    grouping : what a group is made of: "medium", "tracer" or "row"
    names, warnings : where the data came from, and what the reader should know of them
    tests : ComparisonTest, one chi-square per average, and per density and time
    explanations : Explanation; empty where nothing needs one
    medium : "dilute", "hard disks" or "overlapping": of the theory that is shown
    covariance : of those that were fitted of restitution and ln(mean free path)
    """

    verdict: Verdict
    summary: str
    parameters: Mapping[str, Parameter]
    initial: str
    samples: int
    groups: int
    grouping: str
    names: tuple[str, ...]
    warnings: tuple[str, ...]
    tests: tuple[ComparisonTest, ...]
    explanations: tuple[Explanation, ...]
    numbers: tuple[Row, ...] = field(repr=False)
    medium: str = "dilute"
    covariance: tuple[tuple[float, ...], ...] = ()
    p_value_: Any = None
    chi_square: Any = None
    dof: Any = None
    units: Any = None
    cannot_tell: Any = ()
    media: Any = None
    undecided: Any = ()
    n_times: int = 0
    first_time: float = 0.0
    last_time: float = 0.0
    next_step: str = ""

    @property
    def rows(self) -> Any:
        """Every number: a row for each observable and time (and bin of a density), as a new table.

        `value` is the data's, `theory` the equation's, `error` the standard error of the
        difference, `sigmas` the difference in it, NaN where all speeds are equal. A bin is from
        `low` to `high`; the last has none (NaN), and shares of the samples. `verdict` looks at
        `corrected_sigmas`, which allow for the number of rows of the observable.
        """
        frame = pd.DataFrame(self.numbers, columns=Row._fields)
        frame["verdict"] = frame["verdict"].map(str)
        others = ("observable", "verdict", "samples")
        return frame.astype({name: float for name in Row._fields if name not in others})

    def p_value(self, observable: str, time: float | None = None) -> float:
        """The p-value of an average, or of a density at a time; KeyError where there is none."""
        return {(test.observable, test.time): test.p_value for test in self.tests}[observable, time]

    @property
    def title(self) -> str:
        """What was compared."""
        return f"{', '.join(self.names)}: compared with the kinetic equation"

    @property
    def figures(self) -> list[str]:
        """What `plot` draws: each observable, and "confidence", of e and l, if both were fitted."""
        rows = self.rows[self.rows["time"] > 0]
        averages = rows["low"].isna()
        bins = rows["high"].notna() & (rows["low"] > 0) & (rows["value"] > 0)
        seen = {*rows[averages | bins]["observable"]}
        found = [name.replace("_", "-") for name in OBSERVABLES if name in seen]
        both = np.shape(self.covariance) == (2, 2) and self.parameters["restitution"].value
        return found + (["confidence"] if both else [])

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain lists, dictionaries, numbers and texts: the JSON document."""
        parts = {one.name: getattr(self, one.name) for one in fields(self)}
        for name in ("tests", "explanations", "numbers"):
            parts[name] = [item._asdict() for item in parts[name]]
        parts["parameters"] = {k: one._asdict() for k, one in self.parameters.items()}
        data = {name: parts.pop(name) for name in ("names", "samples", "groups", "grouping")}
        rows = parts.pop("numbers")
        made = {"schema": SCHEMA, "title": self.title, "data": data, **parts, "rows": rows}
        return plain(made)

    def to_json(self) -> str:
        """The document as strict JSON."""
        return dumps(self.to_dict())

    def to_dataframe(self, name: str | None = None, **points: Any) -> Any:
        """The rows, or those of one observable."""
        rows = self.rows
        return rows if name is None else rows[rows["observable"] == name].reset_index(drop=True)

    def _dataset(self, only: Any = None, **points: Any) -> Any:
        """The rows with the dimension "row"; attributes: verdict, summary, parameters, version."""
        from kinetics import __version__

        made = self.rows.rename_axis("row").to_xarray()
        units = [OBSERVABLES[name].unit or "1" for name in self.rows["observable"]]
        made["units"] = "row", units, {"long_name": "unit of value, error and theory"}
        scene = json.dumps(self.to_dict()["parameters"])
        about = {"title": self.title, "status": str(self.verdict), "summary": self.summary}
        return made.assign_attrs(**about, scene=scene, version=__version__)

    def plot(self, name: str | None = None, ax: Any = None, **points: Any) -> Any:
        """Draw one of `figures`, or all, on ``ax`` or on new axes, which are returned."""
        if name is None:
            return super().plot(None, ax)
        figure = str(name).replace("_", "-")
        if figure not in self.figures:
            refuse("name", name, f"this comparison has {', '.join(self.figures) or 'no figures'}")
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots(layout="constrained")
        draw(self, figure, ax)
        return ax

    def plot_all(self, **points: Any) -> Any:
        """Draw every one of `figures`, each in a figure of its own; an array of axes."""
        return np.array([self.plot(name) for name in self.figures])

    @classmethod
    def _from_storage(cls, parts: Mapping[str, Any]) -> Self:
        found, kinds = {**parts}, {"tests": ComparisonTest, "numbers": Row}
        for name, kind in kinds.items():
            made = (kind(*row) for row in found[name])
            found[name] = tuple(one._replace(verdict=Verdict(one.verdict)) for one in made)
        found["explanations"] = tuple(Explanation(*row) for row in found["explanations"])
        found["parameters"] = {k: Parameter(*one) for k, one in found["parameters"].items()}
        return cls(**found | {"verdict": Verdict(found["verdict"])})

    def __repr__(self) -> str:
        return textwrap.fill(f"Comparison: {self.verdict}. {self.summary}", 100)


# -- for a reader ----------------------------------------------------------------------------------
def cells_of(result: Any) -> tuple[dict[str, str], list[list[str]], list[list[str]]]:
    """What was compared, by name; the chi-squares, and the rows, a line each below the heads."""
    made = f"from {result.groups} groups, by {result.grouping}"
    told = {n: f"{number(p.value, p.error)} ({p.source})" for n, p in result.parameters.items()}
    tests = [["chi-square", "t [d/U]", "value", "dof", "p", "sigmas", "better than", "verdict"]]
    for t in result.tests:
        within = "" if t.within is None else f"{numeral(100 * t.within, '.2g')} %"
        tests.append([
            t.observable, "all" if t.time is None else numeral(t.time, ".4g"),
            numeral(t.chi_square, ".4g"), str(t.dof), numeral(t.p_value, ".2g"),
            numeral(t.sigmas, ".1f"), within * (t.verdict is Verdict.AGREES), str(t.verdict),
        ])  # fmt: skip
    rows = [["observable", "t [d/U]", "bin", "value ± s.e.", "theory", "sigmas", "verdict"]]
    for r in result.numbers:
        ends = ("∞" if end is None else numeral(end, ".4g") for end in (r.low, r.high))
        rows.append([
            r.observable, numeral(r.time, ".4g"), "" if r.low is None else " to ".join(ends),
            number(r.value, r.error), number(r.theory),
            "" if r.sigmas is None else numeral(r.sigmas, "+.1f"), str(r.verdict),
        ])  # fmt: skip
    return told | {"start": result.initial, "errors": made}, tests, rows


def tables(result: Any) -> str:
    """The answer, parameters, tests, averages over time, odd bins, and explanations, as text."""
    told, tests, rows = cells_of(result)
    shown = [row for row in rows if not row[2] or row[-1] != Verdict.AGREES]
    wrapped = textwrap.TextWrapper(100, subsequent_indent="  ", break_on_hyphens=False).fill
    aligned = list[str]()
    for lines in (tests, shown):
        wide = [max(map(len, column)) for column in zip(*lines, strict=True)]
        padded = ([cell.ljust(w) for cell, w in zip(line, wide, strict=True)] for line in lines)
        aligned.append("\n".join("  ".join(cells).rstrip() for cells in padded))
    if hidden := len(rows) - len(shown):
        aligned[1] += f"\n({hidden} bins of densities that agree are left out; --json has them)"
    return "\n\n".join([
        wrapped(result.summary), *(wrapped(f"note: {text}") for text in result.warnings),
        "\n".join(wrapped(f"{name}: {text}") for name, text in told.items()), *aligned,
        *(wrapped(f"{x.name} ({OUTCOMES[x.outcome]}): {x.text}") for x in result.explanations),
    ])  # fmt: skip


def render(result: Any, json_name: str) -> str:
    """The page, with nothing beside it."""
    from markupsafe import Markup

    svg = drawn(result, result.figures).decode() if result.figures else ""
    told, tests, rows = cells_of(result)
    return rendered(
        "comparison.html.j2", result=result, outcomes=OUTCOMES, scene=told, tests=tests, rows=rows,
        meanings={v: MEANING[v] for v in _STATISTICAL},
        svg=Markup(svg[svg.find("<svg") :]), json_name=json_name,
    )  # fmt: skip


# -- the figures, drawn from the rows: data beside theory, and all deviations ----------------------
def draw(result: Any, figure: str, ax: Any) -> None:
    """Draw one figure on matplotlib's axes: lines for theory, points with bars for data."""
    from matplotlib.ticker import LogLocator

    name, rows = figure.replace("-", "_"), result.rows[result.rows["time"] > 0]
    mine, bars = rows[rows["observable"] == name], {"fmt": "o", "ms": 4, "lw": 1}
    x, x_scale, y_scale = "time $t$ / (d/U)", "log", "linear"
    if name == "confidence":
        title, x_scale = "Restitution and mean free path together", "linear"
        x, y = "restitution $e$", "mean free path $l$ / d"
        e, path = (result.parameters[k].value for k in ("restitution", "mean_free_path"))
        angle, root = np.linspace(0, 2 * np.pi, 121), np.linalg.cholesky(result.covariance)
        away = root @ np.stack([np.cos(angle), np.sin(angle)])
        for share in (0.6827, LIMIT_SHARE):
            radius = limit_factor(result.groups, share, numbers=2)
            x_of_ellipse = e + radius * away[0]
            y_of_ellipse = path * np.exp(radius * away[1])
            ax.plot(x_of_ellipse, y_of_ellipse, label=f"{100 * share:.0f} %")
        ax.plot(e, path, "ko", ms=4, label="fitted")
    elif OBSERVABLES[name].measure is None:
        seen = OBSERVABLES[name]
        title, y_scale = seen.title, "log"
        x, y = f"{seen.symbol} / {seen.unit}", f"density / (1/{seen.unit})"
        bins = mine[(mine["low"] > 0) & mine["high"].notna() & (mine["value"] > 0)]
        for k, (at, part) in enumerate(bins.groupby("time")):
            middle, mark = np.sqrt(part["low"] * part["high"]), {"color": f"C{k}"}
            ax.plot(middle, part["theory"], **mark)
            mark["label"] = f"t = {at:.4g}"
            ax.errorbar(middle, part["value"], part["error"], **mark, **bars)
    else:
        seen, both = OBSERVABLES[name], mine[["value", "theory"]].to_numpy()
        title, y = seen.title, f"{seen.symbol} / {seen.unit}" if seen.unit else seen.symbol
        if both.min() > 0 and both.max() > 30 * both.min():
            y_scale = "log"
        ax.plot(mine["time"], mine["theory"], label="kinetic equation")
        shown = {"color": "black", "label": "data", **bars}
        ax.errorbar(mine["time"], mine["value"], mine["error"], **shown)
    ax.set(xlabel=x, ylabel=y, xscale=x_scale, yscale=y_scale)
    if x_scale == "log":  # labels of every unit would overlap in a decade
        ax.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
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

"""Comparison: the result of comparing a sample with the kinetic equation, as a value."""

import json
import math
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from html import escape
from typing import Any, NamedTuple, Self

from kinetics.crosscheck.report.templates import paragraphs
from kinetics.crosscheck.strict_json import dumps, plain
from kinetics.crosscheck.verdicts import Verdict
from kinetics.errors import InputError, short
from kinetics.results import Value, frozen
from kinetics.version import package_version

SCHEMA = "inelastic-lorentz/comparison/1"


class Observable(NamedTuple):
    """How an observable is written: in a heading, where space is short, and on the axis of a figure
    (its name, symbol, unit and scale).
    """

    title: str
    short: str
    name: str
    symbol: str
    unit: str
    scale: str


OBSERVABLES = {
    "thermal_speed": Observable(
        "Thermal speed v₀ = √⟨v²⟩ / U", "v₀(t)", "Thermal speed", "$v_0$", "U", "log"
    ),
    "a2": Observable(
        "Second Sonine coefficient a₂ = ⟨v⁴⟩/(2⟨v²⟩²) − 1", "a₂(t)", "Second Sonine coefficient",
        "$a_2$", "", "linear",
    ),
    "msd": Observable(
        "Mean square displacement ⟨r²⟩ / d²", "⟨r²(t)⟩", "Mean square displacement",
        r"$\langle r^2\rangle$", "d²", "log",
    ),
    "kurtosis": Observable(
        "Kurtosis of the displacement ⟨r⁴⟩/⟨r²⟩²", "kurtosis of r", "Kurtosis of the displacement",
        r"$\langle r^4\rangle/\langle r^2\rangle^2$", "", "linear",
    ),
    "drift": Observable(
        "Drift ⟨v_x⟩ / U, along the field", "⟨v_x⟩", "Drift", r"$\langle v_x\rangle$", "U", "linear"
    ),
    "mean_displacement": Observable(
        "Mean displacement ⟨x⟩ / d, along the field", "⟨x⟩", "Mean displacement",
        r"$\langle x\rangle$", "d", "log",
    ),
    "dispersion_parallel": Observable(
        "Variance of the displacement along the field / d²", "var x", "Variance along the field",
        r"var $x$", "d²", "log",
    ),
    "dispersion_perpendicular": Observable(
        "Variance of the displacement across the field / d²", "var y", "Variance across the field",
        r"var $y$", "d²", "log",
    ),
    "speed_density": Observable(
        "Speed density, mean over a bin / U⁻¹", "speed density", "speed", "speed $v$", "U", "log"
    ),
    "position_density": Observable(
        "Displacement density g(r, t), mean over a bin / d⁻¹", "displacement density",
        "displacement", "displacement $r$", "d", "log",
    ),
}  # fmt: skip
"""Every observable that a row can have, in the order of the page."""

OUTCOMES = {
    "explains": "explains the difference",
    "found": "found in the data",
    "in part": "explains part of it",
    "does not": "does not explain it",
    "noted": "noted",
}
"""What an explanation comes to, in words; in the order in which they are shown."""
_REPR_WIDTH, _REPR_LINES = 100, 9


def said(block: str, **values: Any) -> str:
    """The sentences of one block of the template, on one line."""
    return " ".join(paragraphs("comparison.txt.j2", block, **values))


@dataclass(frozen=True)
class ComparisonRow:
    """One observable at one time (and, for a density, in one bin from `low` to `high`).

    `value` is the data's, `theory` the kinetic equation's, `error` the standard error of their
    difference (that of the value, unless the theory was taken from the same data), `sigmas` their
    difference in it. `high` is None where a bin has no upper end, and then value and theory are
    shares of the samples. `verdict` looks at `corrected_sigmas`: the sigmas of a Gaussian with
    the same p-value once that is multiplied by the number of rows of the observable. Without
    spread in the data (all speeds equal) both are None.
    """

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


@dataclass(frozen=True)
class ComparisonTest:
    """All rows of an observable together (of a density: at one time) by one chi-square.

    The p-value holds although the same tracers stand behind several rows. `groups` independent
    groups gave the covariance, None where it is known. Every time of the observable entered.
    `verdict` looks at the p-value times the number of tests, as `sigmas` of a Gaussian, and, for
    an average, also at the time that differs most. `within` is the relative difference that the
    data exclude at every time, at 95 % (of 1 + a2 for a2); None for a density.
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


@dataclass(frozen=True)
class Parameter:
    """A number that the theory needed: given (error None) or found in the data.

    value is None where it was fitted and the model does not fit; the source then says so.
    """

    value: float | None
    error: float | None
    source: str


@dataclass(frozen=True)
class Explanation:
    """Something that may explain a difference, compared with the data.

    outcome: "explains" (the rest agrees, and no other hypothesis is much likelier), "in part" (the
    chi-square falls by 16 and by a tenth at least), "does not", "noted" (a fact about data or
    theory; `tested` is then False) or "found" (an effect that the data show by itself).
    `chi_square_before` and `_after` are of all averages. `headline` is what the summary says of it.
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


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Value):
    """A sample compared with the kinetic equation; lengths in d, speeds in U, times in d/U.

    A value: it cannot be changed, equals another with the same contents, can be pickled, and
    `save(path)` writes it to an HDF5 file, from which `kinetics.load` reads it back.

    Attributes
    ----------
    verdict : on everything, from the tests and from rows without spread
    summary : the verdict in a sentence or two
    rows : ComparisonRow, one per observable and time (and bin)
    tests : ComparisonTest, one chi-square per average, and per density and time
    explanations : Explanation; empty where nothing needs one and nothing is to be noted
    parameters : "restitution", "number_density", "mean_free_path" as Parameter
    initial : the start of the theory, in words
    samples, groups : tracers at most, and independent groups that the errors are from
    grouping : what a group is made of: "medium", "tracer" or "row"
    names : where the data came from
    warnings : what the reader should know of the data
    figures : the data of every figure, see kinetics.crosscheck.report.figures
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
    rows: tuple[ComparisonRow, ...]
    figures: Mapping[str, Any] = field(repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "parameters", frozen(dict(self.parameters)))
        object.__setattr__(self, "figures", frozen(_tuples(self.figures)))

    def observable(self, name: str) -> tuple[ComparisonRow, ...]:
        """The rows of one observable."""
        return tuple(row for row in self.rows if row.observable == name)

    def p_value(self, observable: str, time: float | None = None) -> float:
        """The p-value of an average, or of a density at a time; KeyError where there is none."""
        for test in self.tests:
            if test.observable == observable and test.time == time:
                return test.p_value
        raise KeyError(f"no test of {observable!r}" + ("" if time is None else f" at {time:g}"))

    def document(self) -> dict[str, Any]:
        """Everything as plain data, as it stands in the JSON file."""
        parts = {name: plain(value) for name, value in vars(self).items()}
        data = {name: parts.pop(name) for name in _OF_THE_DATA}
        title = f"{', '.join(self.names)}: compared with the kinetic equation"
        return {"schema": SCHEMA, "title": title, "data": data} | parts

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain lists, dictionaries, numbers and texts: the JSON document."""
        return self.document()

    def to_dataframe(self) -> Any:
        """The rows as a pandas DataFrame, a column for each field of ComparisonRow.

        InputError without pandas, which is no dependency of this package.
        """
        import pandas

        names = [one.name for one in fields(ComparisonRow)]
        table = [[getattr(row, name) for name in names] for row in self.rows]
        return pandas.DataFrame(table, columns=names).astype({"verdict": str})

    def to_xarray(self) -> Any:
        """The rows as an xarray Dataset with the dimension "row", a variable for each field.

        Its attributes are the verdict, the summary, the parameters as JSON and the version. Units
        are those of the observables: lengths in d, speeds in U, times in d/U. InputError without
        xarray.
        """
        import xarray

        variables = {}
        for one in fields(ComparisonRow):
            values = [getattr(row, one.name) for row in self.rows]
            if one.name in ("observable", "verdict"):
                values = [str(value) for value in values]
            elif one.name != "samples":
                values = [math.nan if value is None else float(value) for value in values]
            variables[one.name] = ("row", values, {"long_name": _WORDS[one.name]})
        variables["time"][2]["units"] = "d/U"
        units = [OBSERVABLES[row.observable].unit or "1" for row in self.rows]
        variables["units"] = ("row", units, {"long_name": "unit of value, error and theory"})
        attributes = {
            "title": f"{', '.join(self.names)}: compared with the kinetic equation",
            "status": str(self.verdict),
            "summary": self.summary,
            "scene": json.dumps(plain(dict(self.parameters)), allow_nan=False),
            "version": package_version(),
        }
        return xarray.Dataset(variables, attrs=attributes)

    def plot(self, name: str, ax: Any = None) -> Any:
        """Draw one of `figures`, data beside theory, by the name of an observable, or "sigmas".

        On ``ax`` or on new axes, which are returned. InputError for a name that is not there.
        """
        from kinetics.crosscheck.report.drawing import draw

        key = name.replace("_", "-") if isinstance(name, str) else name
        if key not in self.figures:
            known = ", ".join(figure.replace("-", "_") for figure in self.figures) or "no figures"
            raise InputError(f"name: got {short(name)}; this comparison has {known}")
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots(layout="constrained")
        draw(self.figures[key], ax)
        ax.set_title(self.figures[key]["title"])
        return ax

    def to_json(self) -> str:
        """The document as strict JSON."""
        return dumps(self.document())

    def _to_storage(self) -> dict[str, Any]:
        return {"document": self.to_json()}

    @classmethod
    def _from_storage(cls, parts: Mapping[str, Any]) -> Self:
        found = json.loads(parts["document"])
        known: dict[str, Any] = {name: found[name] for name in ("summary", "initial", "figures")}
        known |= {k: _tuples(v) for k, v in found["data"].items()}

        def judged(kind: Any, items: Any) -> Any:
            return tuple(kind(**item | {"verdict": Verdict(item["verdict"])}) for item in items)

        return cls(
            verdict=Verdict(found["verdict"]),
            rows=judged(ComparisonRow, found["rows"]),
            tests=judged(ComparisonTest, found["tests"]),
            explanations=tuple(Explanation(**item) for item in found["explanations"]),
            parameters={k: Parameter(**p) for k, p in found["parameters"].items()},
            warnings=tuple(found["warnings"]),
            **known,
        )

    def __repr__(self) -> str:
        """The verdict first, in ten lines or fewer of 100 columns."""
        lines = textwrap.wrap(f"Comparison: {self.verdict}. {self.summary}", _REPR_WIDTH)[:4]
        for test in self.tests:
            at = "" if test.time is None else f" at t = {test.time:.4g}"
            lines.append(
                f"  {test.observable}{at}: chi-square {test.chi_square:.4g}/{test.dof}, "
                f"p = {test.p_value:.2g}, {test.verdict}"
            )
        more = len(lines) - _REPR_LINES
        return "\n".join(lines[:_REPR_LINES] + ([f"  ... {more} more"] if more > 0 else []))

    def _repr_html_(self) -> str:
        """The verdict, and a table of the tests, for a notebook."""
        heads = ("observable", "t [d/U]", "χ²", "dof", "p", "verdict")
        table = "".join(
            f"<tr><td>{escape(test.observable)}</td>"
            f"<td>{'all' if test.time is None else f'{test.time:.4g}'}</td>"
            f"<td>{test.chi_square:.4g}</td><td>{test.dof}</td><td>{test.p_value:.2g}</td>"
            f"<td>{test.verdict}</td></tr>"
            for test in self.tests
        )
        head = "".join(f"<th>{name}</th>" for name in heads)
        return (
            f"<p><strong>{self.verdict}</strong>. {escape(self.summary)}</p>"
            f"<table><thead><tr>{head}</tr></thead><tbody>{table}</tbody></table>"
        )


_WORDS = {
    "observable": "what is compared",
    "time": "time since the start",
    "value": "value in the data",
    "error": "standard error of value - theory",
    "theory": "value of the kinetic equation",
    "sigmas": "difference in standard errors",
    "verdict": "verdict of the row",
    "corrected_sigmas": "sigmas after the correction for the number of rows",
    "samples": "number of tracers",
    "low": "lower end of the bin",
    "high": "upper end of the bin",
}
_OF_THE_DATA = ("names", "samples", "groups", "grouping")


def _tuples(value: Any) -> Any:
    """Plain data with tuples in place of lists, so that they cannot be changed."""
    if isinstance(value, Mapping):
        return {key: _tuples(item) for key, item in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, (list, tuple)) else value

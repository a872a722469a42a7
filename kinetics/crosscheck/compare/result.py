"""The result of holding data against the kinetic equation, as a value: begin with `Comparison`.

Its other forms are functions of it: the answer in words (`text`), tables (`tables`), figures
(`figures`) and a page (`page`).
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple, Self, TypeVar

import numpy as np
import pandas as pd

from kinetics.crosscheck.compare.observables import OBSERVABLES
from kinetics.crosscheck.compare.writing import LINE_WIDTH
from kinetics.crosscheck.files import dumps, plain
from kinetics.crosscheck.words import Verdict
from kinetics.errors import suggestion
from kinetics.outputs import ALIASES
from kinetics.results.record import stored_class
from kinetics.results.result import Result
from kinetics.results.table import Table, number_text
from kinetics.validation import refuse

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

#: The format of the JSON document. Keys may be added within it.
SCHEMA = "inelastic-lorentz/comparison/1"
#: What an explanation comes to, in words; in the order in which they are shown.
OUTCOMES = {
    "explains": "explains the difference",
    "found": "found in the data",
    "in part": "explains part of it",
    "does not": "does not explain it",
    "noted": "noted",
}


class Row(NamedTuple):
    """An observable at a time, or in a bin of a density; see `Comparison.rows`.

    `since` is the time of the earlier frame of a mean square displacement between two frames, and
    `time` that of the later one; None for all other observables.
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
    since: float | None = None


class ComparisonTest(NamedTuple):
    """All rows of an observable (of a density: at one time) tested by one chi-square.

    `groups` is the number of groups that gave the covariance, None where it is known. `verdict` is
    on `sigmas`, those of the p-value times the number of tests, and, for an average, on the time
    that differs most. `within` is the relative difference (of 1 + a2 for a2) that the data exclude
    at every time, at 95 %.
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
    """A number of the theory: specified (error None) or fitted; value None where no model fits."""

    value: float | None
    error: float | None
    source: str

    def in_unit(self, unit: float) -> Parameter:
        """Return the number times a unit."""
        changed = self
        if self.value is not None:
            changed = changed._replace(value=self.value * unit)
        if self.error is not None:
            changed = changed._replace(error=self.error * unit)
        return changed


class Explanation(NamedTuple):
    """Something that may explain a difference; chi-squares are of all averages.

    outcome: "explains" (what remains agrees, no other cause is much likelier), "in part" (T^2 falls
    by 16 and a tenth), "does not", "noted" (not tested) or "found" (in the data themselves).
    `headline` is the explanation in few words, `medium` the one in which it was tested.
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
    medium: str = ""


RowOrTest = TypeVar("RowOrTest", Row, ComparisonTest)

#: Units of the parameters that have one.
UNITS_OF_PARAMETERS = {
    "number_density": "d^-2",
    "mean_free_path": "d",
    "speed_unit": "in the data's unit",
    "position_error": "in the data's unit",
}
#: Columns of `Comparison.rows` that are no numbers with a missing value.
COLUMNS_OF_OTHER_TYPES = ("observable", "verdict", "samples")
#: Fields of a Comparison that its document has under "data".
FIELDS_OF_DATA = (
    "names",
    "samples",
    "groups",
    "grouping",
    "n_times",
    "first_time",
    "last_time",
    "units",
    "unit_names",
)


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """A sample compared with the kinetic equation; lengths in d, speeds in U, times in d/U.

    Attributes
    ----------
    verdict, summary : on everything, and in a sentence or two
    parameters : "restitution", "number_density", "mean_free_path" as Parameter, in d; where they
        were fitted also "speed_unit", U in the data's unit of speed, and "position_error", the
        standard deviation of the error of a component of a position, in the data's unit of length
    initial : the start of the theory, in words
    samples, groups : tracers at most, and independent groups that the errors are from
    grouping : what a group is made of: "medium", "tracer" or "row"
    names, warnings : where the data came from, and what the reader should know of them
    tests : ComparisonTest, one chi-square per average, and per density and time
    explanations : Explanation; empty where nothing needs one
    medium : "dilute", "hard disks" or "overlapping disks": of the theory that is shown
    covariance : of those that were fitted of restitution and ln(mean free path)
    overall_p_value : of everything that was tested, on which the verdict rests; None where nothing
        was
    chi_square, dof : of all averages together, and its degrees of freedom
    units : "length", "speed" and "time": d, U and d/U in the data's units; empty if the data are in
        d and U
    unit_names : names of the data's units ("mm", "mm/s", "s"), where the data say them
    dimension : 2 in the plane, 3 in space
    cannot_tell : sentences on what the data cannot tell
    media : chi-square and degrees of freedom of the fit in each medium that was tried
    undecided : media that the data do not exclude, beside `medium`; fitted values are then means
        over all of these, weighted by likelihood, with errors that reach the value in each
    n_times, first_time, last_time : the times of the data that were used
    next_step : what to do next, in one sentence; empty if there is nothing to do
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
    overall_p_value: float | None = None
    chi_square: float | None = None
    dof: int | None = None
    units: Mapping[str, float] = field(default_factory=dict)
    unit_names: Mapping[str, str] = field(default_factory=dict)
    dimension: int = 2
    cannot_tell: tuple[str, ...] = ()
    media: Mapping[str, tuple[float, int]] = field(default_factory=dict)
    undecided: tuple[str, ...] = ()
    n_times: int = 0
    first_time: float = 0.0
    last_time: float = 0.0
    next_step: str = ""

    @property
    def rows(self) -> pd.DataFrame:
        """Every number: a row for each observable and time (and bin of a density), as a new table.

        `value` is the data's, `theory` the equation's, `error` the standard error of the
        difference. `sigmas` is the difference in standard errors, NaN where all groups are equal.
        `verdict` is on `corrected_sigmas`, which allow for the number of rows of the observable. A
        bin is from `low` to `high`; the last has no end (NaN), and holds shares of the samples.
        `since` is the earlier time of a displacement between two frames.
        """
        frame = pd.DataFrame(self.numbers, columns=Row._fields)
        frame["verdict"] = frame["verdict"].map(str)
        numeric = [name for name in Row._fields if name not in COLUMNS_OF_OTHER_TYPES]
        return frame.astype(dict.fromkeys(numeric, float))

    def p_value(self, observable: str, time: float | None = None) -> float:
        """Return the p-value of an average, or of a density at a time.

        Raises
        ------
        KeyError
            There is no such test.
        """
        for test in self.tests:
            if (test.observable, test.time) == (observable, time):
                return test.p_value
        raise KeyError(observable, time)

    @property
    def is_fitted(self) -> bool:
        """Whether numbers of the theory were fitted to the data."""
        has_errors = any(item.error is not None for item in self.parameters.values())
        return has_errors or len(self.covariance) > 0

    @property
    def title(self) -> str:
        """What was done with which data."""
        work = "compared"
        if self.is_fitted:
            work = "fitted"
        return f"{', '.join(self.names)}: {work} with the kinetic equation"

    @property
    def figures(self) -> list[str]:
        """What `plot` draws: each observable, and "confidence", of e and l, if both were fitted."""
        from kinetics.crosscheck.compare.figures import figure_names

        return figure_names(self)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain lists, dictionaries, numbers and texts: the JSON document."""
        values = {attribute.name: getattr(self, attribute.name) for attribute in fields(self)}
        values["rows"] = values.pop("numbers")
        for name in ("tests", "explanations", "rows"):
            values[name] = [record._asdict() for record in values[name]]
        values["parameters"] = {
            name: parameter._asdict() for name, parameter in self.parameters.items()
        }
        data = {name: values.pop(name) for name in FIELDS_OF_DATA}
        document: dict[str, Any] = plain(
            {"schema": SCHEMA, "title": self.title, "data": data, **values}
        )
        return document

    def to_json(self) -> str:
        """Return the document as strict JSON."""
        return dumps(self.to_dict())

    def to_dataframe(self, name: str | None = None, **points: Any) -> pd.DataFrame:
        """Return the rows, or those of one observable."""
        rows = self.rows
        if name is None:
            return rows
        known = list(dict.fromkeys(rows["observable"]))
        if name not in known:
            near = suggestion(name, known, ALIASES)
            refuse("name", name, f"this comparison has {', '.join(known) or 'no rows'}{near}")
        return rows[rows["observable"] == name].reset_index(drop=True)

    def _dataset(self, only: Any = None, **points: Any) -> xarray.Dataset:
        """Return the rows with the dimension "row"; verdict and parameters are attributes."""
        from kinetics import __version__

        dataset = self.rows.rename_axis("row").to_xarray()
        units = [OBSERVABLES[name].unit or "1" for name in self.rows["observable"]]
        dataset["units"] = "row", units, {"long_name": "unit of value, error and theory"}
        return dataset.assign_attrs(
            title=self.title,
            status=str(self.verdict),
            summary=self.summary,
            scene=json.dumps(self.to_dict()["parameters"]),
            version=__version__,
        )

    def plot(self, name: str | None = None, ax: Axes | None = None, **points: Any) -> Any:
        """Draw one of `figures`, or all, on ``ax`` or on new axes, which are returned."""
        from kinetics.crosscheck.compare.figures import draw, system_of
        from kinetics.results.plot import new_axes, source_on

        if name is None:
            return super().plot(None, ax)
        figure = str(name).replace("_", "-")
        if figure not in self.figures:
            known = ", ".join(self.figures) or "no figures"
            near = suggestion(name, self.figures, ALIASES)
            refuse("name", name, f"this comparison has {known}{near}")
        ax = ax if ax is not None else new_axes()
        source_on(ax, "", system_of(self))
        draw(self, figure, ax)
        return ax

    def plot_all(self, **points: Any) -> NDArray[Any]:
        """Draw each of `figures` in a figure of its own; returns an array of axes."""
        return np.array([self.plot(name) for name in self.figures])

    @classmethod
    def _from_storage(cls, parts: Mapping[str, Any]) -> Self:
        """Build the value of its stored fields; those of older versions have fewer."""
        values = dict(parts)
        values["verdict"] = Verdict(values["verdict"])
        values["tests"] = tuple(_with_verdict(ComparisonTest(*test)) for test in values["tests"])
        values["numbers"] = tuple(_with_verdict(Row(*row)) for row in values["numbers"])
        values["explanations"] = tuple(Explanation(*item) for item in values["explanations"])
        values["parameters"] = {
            name: Parameter(*parameter) for name, parameter in values["parameters"].items()
        }
        return cls(**values)

    def _table(self) -> Table:
        """Return what a notebook shows: the verdict, the numbers of the theory, and the tests."""
        rows = []
        for name, parameter in self.parameters.items():
            if parameter.value is None:
                continue
            text = number_text(parameter.value)
            if parameter.error:
                text = f"{number_text(parameter.value, parameter.error)} ± {parameter.error:.2g}"
            rows.append((name, text, UNITS_OF_PARAMETERS.get(name, ""), parameter.source))
        for test in self.tests:
            name = test.observable if test.time is None else f"{test.observable}, t = {test.time:g}"
            statistic = f"χ² = {test.chi_square:.4g} of {test.dof}"
            rows.append((name, statistic, f"p = {test.p_value:.2g}", str(test.verdict)))
        lines = [self.summary, *self.warnings]
        return Table(f"Comparison: {self.verdict}", ("", "value", "unit, or p", ""), rows, lines)

    def __repr__(self) -> str:
        lines = [textwrap.fill(f"Comparison: {self.verdict}. {self.summary}", LINE_WIDTH)]
        for name, parameter in self.parameters.items():
            if parameter.value is None or not parameter.error:
                continue
            unit = UNITS_OF_PARAMETERS.get(name, "")
            text = f"{number_text(parameter.value, parameter.error)} ± {parameter.error:.2g} {unit}"
            lines.append(f"  {name} = {text.rstrip()}")
        return "\n".join(lines)


def _with_verdict(record: RowOrTest) -> RowOrTest:
    """Return a row or a test whose verdict was stored as a word."""
    return record._replace(verdict=Verdict(record.verdict))

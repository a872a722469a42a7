"""Results: values with read-only arrays; and an Ensemble as datasets, data frames and plots.

pandas, xarray and matplotlib are imported when they are asked for.
"""

import json
from collections.abc import Iterable
from dataclasses import fields
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from particles.checks import refuse
from particles.kernel.columns import OF_FLIGHTS
from particles.outputs import ESTIMATES, VARIABLES

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

DECADES = 30.0  # last over first time from which on the axis is logarithmic


def package_version() -> str:
    """Return the version that is installed."""
    try:
        return version("inelastic-lorentz")
    except PackageNotFoundError:
        return "unknown: the package is not installed"


def frozen(value: Any) -> Any:
    """Return a read-only view of an array or of a dict of arrays; anything else as it is."""
    if isinstance(value, dict):
        return MappingProxyType({name: frozen(item) for name, item in value.items()})
    if isinstance(value, np.ndarray):
        value = value.view()
        value.setflags(write=False)
    return value


def _content(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, MappingProxyType):
        return tuple((name, _content(value[name])) for name in sorted(value))
    return value


class Value:
    """Base of frozen dataclasses (eq=False) that hold arrays.

    Two are equal if they are of one class and every field is, arrays bit by bit (so NaN equals
    NaN). Fields are made read-only. Pickling keeps the fields alone, not what was computed of them.
    """

    def __post_init__(self) -> None:
        self.__setstate__(vars(self))

    def __getstate__(self) -> dict[str, Any]:
        state = {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in state.items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update({name: frozen(value) for name, value in state.items()})

    def _key(self) -> tuple[Any, ...]:
        return tuple(_content(getattr(self, f.name)) for f in fields(self))  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self), self._key()))


class Result(Value):
    """Base of the Ensemble: `plan`, `statuses` and `outputs` are there, as are the estimates."""

    plan: Any
    statuses: Any
    outputs: tuple[str, ...]

    if TYPE_CHECKING:  # averages and histograms, which `ensemble` makes of the tables of `outputs`

        def __getattr__(self, name: str) -> Any: ...

    def to_xarray(self) -> "xarray.Dataset":
        """Return estimates and histograms, each with `<name>_error`, and what was run."""
        return self._dataset(self._drawn)

    def to_dataframe(self, name: str | None = None) -> "pandas.DataFrame":
        """Return a table with a row for each time: each estimate, or component, and its error.

        With a `name`, that of a histogram for example, a row for each place of its array. Units are
        in `frame.attrs`. ValueError for a name that is not there.
        """
        import pandas

        if name is not None:
            return self._dataset([self._known(name)]).to_dataframe().reset_index()
        made = self._dataset(n for n in self.outputs if n in ESTIMATES)
        columns, units = {"time": self.plan.times}, {"time": "d/U"}
        for one in made.values():
            columns |= _components(one)
            units |= dict.fromkeys(_components(one), one.attrs["units"])
        frame = pandas.DataFrame(columns)
        frame.attrs = {**made.attrs, "units": units}
        return frame

    def plot(self, name: str | None = None, ax: "Axes | None" = None) -> Any:
        """Draw an estimate over time with its standard errors, or the density of a histogram.

        On `ax` or on new axes, which are returned, labelled with units. Without a name everything
        is drawn in one figure, and a list of axes is returned. ValueError for a name that is not
        there or is one number.
        """
        if name is None:
            if ax is not None:
                raise ValueError("ax: axes without a name; name what to draw on them")
            names = [n for n in self._drawn if n in VARIABLES or getattr(self, n).value.ndim]
            names = names if self.plan.times.size else [n for n in names if n[:4] == "free"]
            axes = _new_axes(len(names))
            for each, place in zip(names, axes, strict=True):
                self.plot(each, place)
            return axes
        one, times = getattr(self, self._known(name)), self.plan.times
        if name in ESTIMATES and not one.value.ndim:
            refuse("name", name, "it is one number; plot draws what depends on the time")
        if ax is None:
            (ax,) = _new_axes(1)
        if name in VARIABLES:
            _, unit, words = VARIABLES[name]
            for k, line in enumerate(one.density.value):
                label = words if name in OF_FLIGHTS else f"t = {times[k]:.4g} d/U"
                ax.stairs(np.where(line > 0.0, line, np.nan), one.edges, baseline=None, label=label)
            ax.set(xlabel=f"{words} [{unit}]", ylabel=f"density [{_per(unit)}]")
            ax.set(xscale="log", yscale="log")
        else:
            made = self._dataset([name])
            errors = _components(made[f"{name}_error"]).values()
            for (label, line), error in zip(_components(made[name]).items(), errors, strict=True):
                bars = np.where(np.isfinite(error), error, 0.0)
                ax.errorbar(times, line, bars, marker="o", ms=3.5, lw=0.8, label=label)
            spans = times.size > 1 and 0.0 < times[0] * DECADES < times[-1]
            ax.set(xlabel="t [d/U]", ylabel=f"{name} [{ESTIMATES[name][0]}]")
            ax.set(xscale="log" if spans else "linear")
        ax.legend()
        return ax

    @property
    def _drawn(self) -> list[str]:
        return [n for n in self.outputs if n in ESTIMATES or n in VARIABLES]

    def _known(self, name: Any) -> str:
        if name not in self._drawn:
            refuse("name", name, f"this ensemble has {', '.join(self._drawn)}")
        return str(name)

    def _dataset(self, names: Iterable[str]) -> "xarray.Dataset":
        import xarray

        plan = self.plan
        found: dict[str, Any] = {}
        axes: dict[str, Any] = {"time": ("time", plan.times, {"units": "d/U"})}
        for name in names:
            one = getattr(self, name)
            if name in ESTIMATES:
                unit, words = ESTIMATES[name][:2]
                dims = ("time", "component", "component2")[: one.value.ndim]
                axes |= {d: (d, list("xyz"[: plan.medium.dimension])) for d in dims[1:]}
            else:
                (short, length, words), edges, one = VARIABLES[name], one.edges, one.density
                axis, unit = f"{short}_bin", _per(length)
                dims = ("run" if name in OF_FLIGHTS else "time", axis)
                about = {"units": length, "long_name": words}
                axes[axis] = axis, np.sqrt(edges[1:] * edges[:-1]), about
                found |= {f"{short}_low": (axis, edges[:-1], about)}
                found |= {f"{short}_high": (axis, edges[1:], about)}
                words = f"density of {words}"
            found[name] = dims, one.value, {"units": unit, "long_name": words}
            error = {"units": unit, "long_name": f"standard error of {name}"}
            found[f"{name}_error"] = dims, one.error, error
        ends = ["finished", "collision_cap", "trapped", "escaped"]
        ends += ["captured"] if plan.capture_speed else []
        about = {
            "status": ", ".join(f"{getattr(self.statuses, name)} {name}" for name in ends),
            "scene": json.dumps(plan.told(), default=repr),
            "version": package_version(),
        }
        return xarray.Dataset(found, axes, about).copy(deep=True)


def _new_axes(n: int) -> list["Axes"]:
    """Return so many axes in a new figure, three in a row."""
    from matplotlib import pyplot

    rows, columns = -(-n // 3), min(n, 3)
    size = None if n == 1 else (4.2 * columns, 3.2 * rows)
    figure = pyplot.figure(figsize=size, layout="constrained")
    return [figure.add_subplot(rows, columns, k + 1) for k in range(n)]


def _per(unit: str) -> str:
    """Return the unit of a density of what has this unit."""
    return "U/d" if unit == "d/U" else f"1/{unit}"


def _components(one: "xarray.DataArray") -> dict[str, np.ndarray]:
    """Return what depends on the time, of vectors and tensors each component."""
    base, error = str(one.name).removesuffix("_error"), "_error" * str(one.name).endswith("_error")
    places = list(np.ndindex(*one.shape[1:])) if one.ndim else []
    names = ["_".join([base, "".join("xyz"[i] for i in at)]) if at else base for at in places]
    values = [one.values[(slice(None), *at)] for at in places]
    return {f"{name}{error}": line for name, line in zip(names, values, strict=True)}

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

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

UNITS = {
    "thermal_speed": ("U", "sqrt(<v^2>)", "v₀"),
    "a2": ("1", "<v^4>/(k <v^2>^2) - 1, k = 2 in the plane and 5/3 in space", "a₂"),
    "msd": ("d^2", "mean square displacement", "⟨r²⟩"),
    "kurtosis": ("1", "<r^4>/<r^2>^2", "⟨r⁴⟩/⟨r²⟩²"),
    "collisions": ("1", "mean number of collisions per tracer", "collisions"),
    "velocity_autocorrelation": ("U^2", "<v(t).v(0)>", "⟨v(0)·v⟩"),
    "mean_free_path": ("d", "path per collision", "l"),
    "drift": ("U", "<v_x>", "⟨v_x⟩"),
    "drift_of_moving": ("U", "<v_x> of the tracers that are not trapped", "⟨v_x⟩"),
    "trapped_fraction": ("1", "share of the tracers that are trapped", "trapped"),
    "mean_velocity": ("U", "<v>", "⟨v⟩"),
    "velocity_tensor": ("U^2", "<v_i v_j>", "⟨v v⟩"),
    "mean_displacement": ("d", "<r>", "⟨r⟩"),
    "dispersion": ("d^2", "covariance of the displacement", "cov(r)"),
    "dispersion_parallel": ("d^2", "variance of the displacement along the field", "var x"),
    "dispersion_perpendicular": ("d^2", "variance across the field, of one direction", "var y"),
    "passed": ("1", "share of the tracers that have reached the depth", "passed"),
    "mean_passage_time": ("d/U", "mean time of the first passage of the depth", "⟨t⟩"),
}
"""Name of an estimate -> its unit, what it is in words, and its symbol on the axis of a plot."""
VARIABLES = {
    "speed_histogram": ("v", "U", "speed |v|"),
    "velocity_component_histogram": ("v_x", "U", "velocity component |v_x|"),
    "displacement_histogram": ("r", "d", "displacement |r|"),
    "free_path_histogram": ("path", "d", "length of a free flight"),
}
"""Name of a histogram -> symbol, unit and words of what is counted."""
_DECADES = 30.0  # largest over smallest value from which on an axis is logarithmic
_MOST_LINES = 8


def package_version() -> str:
    """Return the version that is installed; "0+unknown" where the package is not."""
    try:
        return version("inelastic-lorentz")
    except PackageNotFoundError:
        return "0+unknown"


def frozen(value: Any) -> Any:
    """Return a read-only view of an array or of a dict of arrays; anything else as it is."""
    if isinstance(value, np.ndarray):
        value = value.view()
        value.setflags(write=False)
    elif isinstance(value, (dict, MappingProxyType)):
        value = MappingProxyType({name: frozen(item) for name, item in value.items()})
    return value


def _content(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
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

    def to_xarray(self) -> "xarray.Dataset":
        """Return an xarray Dataset: estimates and histograms, each with `<name>_error`.

        Attributes say units, the medium and the arguments of the run, and the version.
        """
        return self._dataset(n for n in self.outputs if n in {**UNITS, **VARIABLES})

    def to_dataframe(self, name: str | None = None) -> "pandas.DataFrame":
        """Return a pandas DataFrame with a row for each time: each estimate and its error.

        Of vectors and tensors each component is a column. With the `name` of a histogram a row for
        each time and bin. Units are in `frame.attrs`. Raises ValueError for another name.
        """
        import pandas

        if name is None:
            made = self._dataset(n for n in self.outputs if n in UNITS)
            columns = {k: v for one in made.values() for k, v in _components(one).items()}
            frame = pandas.DataFrame({"time": made["time"].values, **columns})
            of = {k: one.attrs["units"] for one in made.values() for k in _components(one)}
            frame.attrs = {**made.attrs, "units": {"time": "d/U", **of}}
            return frame
        if self._known(name) not in VARIABLES:
            refuse("name", name, "is no histogram; estimates are in to_dataframe()")
        made, (symbol, unit, _) = self._dataset([name]), VARIABLES[name]
        names = {f"{symbol}_low": "low", f"{symbol}_high": "high", name: "density"}
        names[f"{name}_error"] = "density_error"
        dims = [str(d) for d in made[name].dims]
        made = made if "time" in dims else made.drop_vars("time")
        frame = made.to_dataframe(dim_order=dims).reset_index().rename(columns=names)
        kept = ["time", "low", "high", "density", "density_error"]
        frame = frame[[column for column in kept if column in frame]]
        frame.attrs = {
            "units": dict(zip(kept, ("d/U", unit, unit, *[f"1/{unit}"] * 2), strict=True))
        }
        return frame

    def plot(self, name: str, ax: "Axes | None" = None) -> "Axes":
        """Draw an estimate over time with its standard errors, or the density of a histogram.

        On `ax` or on new axes, which are returned, labelled with units. Of a histogram up to eight
        of the times are drawn. ValueError for a name that is not there or is one number.
        """
        made = self._dataset([self._known(name)])
        one, times = made[name], self.plan.times
        if not one.ndim:
            refuse("name", name, "is one number; plot draws what depends on the time")
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots(layout="constrained")
        if name in VARIABLES:
            symbol, unit, words = VARIABLES[name]
            edges = np.append(made[f"{symbol}_low"].values, made[f"{symbol}_high"].values[-1])
            for k in dict.fromkeys(np.linspace(0, len(one) - 1, _MOST_LINES).round().astype(int)):
                line = np.where(one.values[k] > 0.0, one.values[k], np.nan)
                label = f"t = {times[k]:.4g} d/U" if "time" in one.dims else words
                ax.stairs(line, edges, baseline=None, label=label, color=f"C{k % 10}")
            counted = np.nonzero(np.any(one.values > 0.0, axis=0))[0]
            ends = (counted[0], counted[-1] + 1) if counted.size else (0, -1)
            ax.set(xscale="log", yscale="log", xlim=(edges[ends[0]], edges[ends[1]]))
            ax.set(xlabel=f"{words} [{unit}]", ylabel=f"density [1/{unit}]")
        else:
            errors = _components(made[f"{name}_error"]).values()
            for (label, line), error in zip(_components(one).items(), errors, strict=True):
                bars = np.where(np.isfinite(error), error, 0.0)
                ax.errorbar(times, line, bars, marker="o", ms=3.5, lw=0.8, label=label)
            unit, _, symbol = UNITS[name]
            ax.set(xlabel="t [d/U]", ylabel=symbol + ("" if unit == "1" else f" [{unit}]"))
            ax.set_xscale("log" if _spans_decades(times[times > 0.0]) else "linear")
            ax.set_yscale("log" if _spans_decades(one.values[times > 0.0]) else "linear")
        if len(ax.get_legend_handles_labels()[1]) > 1:
            ax.legend()
        return ax

    def _known(self, name: Any) -> str:
        known = [n for n in self.outputs if n in {**UNITS, **VARIABLES}]
        if name not in known:
            refuse("name", name, f"this ensemble has {', '.join(known)}")
        return str(name)

    def _dataset(self, names: Iterable[str]) -> "xarray.Dataset":
        import xarray

        plan = self.plan
        found: dict[str, Any] = {}
        axes: dict[str, Any] = {"time": ("time", plan.times, {"units": "d/U"})}
        letters = list("xyz"[: plan.medium.dimension])
        for name in names:
            one = getattr(self, name)
            if name in UNITS:
                unit, words, symbol = UNITS[name]
                dims = ("time", "component", "component2")[: one.value.ndim]
                axes |= {d: (d, letters) for d in dims[1:]}
            else:
                (short, length, words), edges, one = VARIABLES[name], one.edges, one.density
                unit, words, symbol = f"1/{length}", f"density of {words}", "density"
                axis, middle = f"{short}_bin", np.sqrt(edges[1:] * edges[:-1])
                dims = ("run" if name == "free_path_histogram" else "time", axis)
                axes[axis] = axis, middle, {"units": length, "long_name": VARIABLES[name][2]}
                found[f"{short}_low"] = axis, edges[:-1], {"units": length}
                found[f"{short}_high"] = axis, edges[1:], {"units": length}
            described = {"units": unit, "long_name": words, "symbol": symbol}
            error = {"units": unit, "long_name": f"standard error of {name}"}
            found[name] = dims, one.value, described
            found[f"{name}_error"] = dims, one.error, error
        arguments = ("restitution", "tangential_restitution", "field", "media", "tracers",
                     "max_collisions", "seed")  # fmt: skip
        medium = " ".join(repr(plan.medium).split())
        scene = {"medium": medium} | {n: getattr(plan, n) for n in arguments}
        ends = ("finished", "collision_cap", "trapped", "escaped")
        about = {
            "title": f"Particles: {plan.media} configurations of {medium}",
            "status": ", ".join(f"{getattr(self.statuses, name)} {name}" for name in ends),
            "scene": json.dumps(scene),
            "version": package_version(),
        }
        return xarray.Dataset(found, axes, about).copy(deep=True)


def _components(one: "xarray.DataArray") -> dict[str, np.ndarray]:
    """Return what depends on the time, of vectors and tensors each component."""
    base, error = str(one.name).removesuffix("_error"), "_error" * str(one.name).endswith("_error")
    places = list(np.ndindex(*one.shape[1:])) if one.ndim else []
    names = ["_".join([base, "".join("xyz"[i] for i in at)]) if at else base for at in places]
    values = [one.values[(slice(None), *at)] for at in places]
    return {f"{name}{error}": line for name, line in zip(names, values, strict=True)}


def _spans_decades(values: np.ndarray) -> bool:
    values = values[np.isfinite(values)]
    return bool(values.size > 1 and 0.0 < values.min() * _DECADES < values.max())

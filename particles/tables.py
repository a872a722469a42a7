"""An Ensemble as plots, pictures, data frames and datasets, each estimate with its error.

pandas, xarray and matplotlib are imported when they are asked for.
"""

import json
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from particles.checks import refuse
from particles.configuration import Plan
from particles.estimators import Estimate, Histogram
from particles.kernel.columns import HISTOGRAMS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from particles.trajectories import Trajectory

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
_COMPONENTS = ("component", "component2")
_DECADES = 30.0  # largest over smallest value from which on an axis is logarithmic
_MOST_LINES = 8


class Quantity(NamedTuple):
    """One estimate of an ensemble, with its axes."""

    name: str
    dims: tuple[str, ...]
    estimate: Estimate
    unit: str
    words: str


class Tables:
    """Plots, data frames and datasets of an Ensemble."""

    plan: Plan

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the estimates and histograms that there are."""
        raise NotImplementedError

    def plot(self, name: str, ax: "Axes | None" = None) -> "Axes":
        """Draw an estimate over time with its standard errors, or the density of a histogram.

        On `ax` or on new axes, which are returned, labelled with units. Of a histogram up to eight
        of the times are drawn. ValueError for a name that is not there or is one number.
        """
        self._check(name)
        found = getattr(self, name)
        if isinstance(found, Estimate) and not found.value.ndim:
            refuse("name", name, "is one number; plot draws what depends on the time")
        if ax is None:
            from matplotlib import pyplot

            _, ax = pyplot.subplots(layout="constrained")
        if isinstance(found, Histogram):
            _draw_histogram(ax, found, name, self.plan.times)
        else:
            _draw_estimate(ax, found, name, self.plan.times)
        return ax

    def trajectories(self, tracers: int = 8, **which: Any) -> list["Trajectory"]:
        """Return the paths of the first tracers of a configuration, made again to the same bits.

        tracers: how many. which: configuration (0), until (the last time), collisions (300), as of
        particles.trajectories.trajectories. Raises ValueError for one out of range.
        """
        from particles.trajectories import trajectories

        return trajectories(self.plan, tracers, **which)

    def plot_trajectories(self, tracers: int = 8, **which: Any) -> "Axes":
        """Draw paths of the first tracers among the scatterers, coloured by speed; return the axes.

        which: as of `trajectories`, and ax (matplotlib axes to draw on), colour_bar (True).
        """
        from particles.pictures import plot_trajectories

        return plot_trajectories(self.plan, tracers, **which)

    def to_dataframe(self, name: str | None = None) -> Any:
        """Return a pandas DataFrame with a row for each time: each estimate and its error.

        Of vectors and tensors each component is a column. With the `name` of a histogram a row for
        each time and bin. Units are in `frame.attrs`. ValueError without pandas.
        """
        pandas = _import("pandas", "to_dataframe")
        columns = self._columns() if name is None else self._bins(name)
        frame = pandas.DataFrame(columns)
        units = {one.name: one.unit for one in self._quantities()}
        frame.attrs = {**self._attributes(), "units": {"time": "d/U", **units}}
        return frame

    def to_xarray(self) -> Any:
        """Return an xarray Dataset: estimates and histograms, each with `<name>_error`.

        Attributes say units, the medium and the arguments of the run, and the version. ValueError
        without xarray.
        """
        xarray = _import("xarray", "to_xarray")
        axes: dict[str, Any] = {"time": ("time", self.plan.times, {"units": "d/U"})}
        letters = list("xyz"[: self.plan.medium.dimension])
        variables: dict[str, Any] = {}
        for one in self._quantities():
            axes |= {d: (d, letters) for d in one.dims if d in _COMPONENTS}
            described = {"units": one.unit, "long_name": one.words}
            error = {"units": one.unit, "long_name": f"standard error of {one.name}"}
            variables[one.name] = (one.dims, one.estimate.value, described)
            variables[f"{one.name}_error"] = (one.dims, one.estimate.error, error)
        for name in self._histograms():
            found, (symbol, unit, words) = getattr(self, name), VARIABLES[name]
            axis, edges = f"{symbol}_bin", found.edges
            time = "time" if len(found.below) == self.plan.times.size else "run"
            middle = {"units": unit, "long_name": f"{words}, middle of a bin"}
            axes[axis] = (axis, np.sqrt(edges[1:] * edges[:-1]), middle)
            variables[f"{symbol}_low"] = (axis, edges[:-1], {"units": unit})
            variables[f"{symbol}_high"] = (axis, edges[1:], {"units": unit})
            density = {"units": f"1/{unit}", "long_name": f"density of {words}"}
            variables[name] = ((time, axis), found.density.value, density)
            variables[f"{name}_error"] = ((time, axis), found.density.error, {"units": f"1/{unit}"})
        copies = {k: (v[0], np.array(v[1]), *v[2:]) for k, v in variables.items()}
        return xarray.Dataset(copies, axes, self._attributes())

    def _check(self, name: str) -> None:
        if name not in self.outputs or name not in {**UNITS, **VARIABLES}:
            known = [n for n in self.outputs if n in {**UNITS, **VARIABLES}]
            refuse("name", name, f"this ensemble has {', '.join(known)}")

    def _histograms(self) -> list[str]:
        return [name for name in HISTOGRAMS if name in self.outputs]

    def _quantities(self) -> Iterator[Quantity]:
        """Yield every estimate."""
        for name in self.outputs:
            if name in UNITS:
                estimate: Estimate = getattr(self, name)
                unit, words, _ = UNITS[name]
                axes = ("time", *_COMPONENTS)[: estimate.value.ndim]
                yield Quantity(name, axes, estimate, unit, words)

    def _columns(self) -> dict[str, np.ndarray]:
        """Return time, and value and error of each estimate, or of each of its components."""
        columns = {"time": self.plan.times}
        for one in self._quantities():
            if not one.dims:
                continue
            for label, place in _places(one.name, one.estimate):
                columns[label] = one.estimate.value[place]
                columns[f"{label}_error"] = one.estimate.error[place]
        return columns

    def _bins(self, name: str) -> dict[str, np.ndarray]:
        """Return time, edges, density and its error, one row for each time and bin."""
        self._check(name)
        if name not in VARIABLES:
            refuse("name", name, "is no histogram; estimates are in to_dataframe()")
        found: Histogram = getattr(self, name)
        n_times, n_bins = found.probability.value.shape
        columns = {
            "low": np.tile(found.edges[:-1], n_times),
            "high": np.tile(found.edges[1:], n_times),
            "density": found.density.value.ravel(),
            "density_error": found.density.error.ravel(),
        }
        if n_times == self.plan.times.size and name != "free_path_histogram":
            return {"time": np.repeat(self.plan.times, n_bins), **columns}
        return columns

    def _attributes(self) -> dict[str, Any]:
        plan = self.plan
        scene = {
            "medium": " ".join(repr(plan.medium).split()),
            "restitution": plan.restitution,
            "tangential_restitution": plan.tangential_restitution,
            "field": plan.field,
            "media": plan.media,
            "tracers": plan.tracers,
            "max_collisions": plan.max_collisions,
            "seed": plan.seed,
        }
        try:
            installed = version("inelastic-lorentz")
        except PackageNotFoundError:
            installed = "0+unknown"
        statuses = getattr(self, "statuses")  # noqa: B009  (a property of the Ensemble)
        ends = ", ".join(
            f"{getattr(statuses, name)} {name}"
            for name in ("finished", "collision_cap", "trapped", "escaped")
        )
        return {
            "title": f"Particles: {plan.media} configurations of {scene['medium']}",
            "status": ends,
            "scene": json.dumps(scene),
            "version": installed,
        }


def _places(name: str, estimate: Estimate) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """Yield the name of each component of an estimate and its place at all times."""
    for place in np.ndindex(*estimate.value.shape[1:]):
        letters = "".join("xyz"[i] for i in place)
        yield (f"{name}_{letters}" if letters else name), (slice(None), *place)


def _draw_estimate(ax: "Axes", found: Estimate, name: str, times: np.ndarray) -> None:
    unit, _, symbol = UNITS[name]
    several = found.value.ndim > 1
    for label, place in _places(name, found):
        error = found.error[place]
        ax.errorbar(
            times, found.value[place], np.where(np.isfinite(error), error, 0.0),
            marker="o", markersize=3.5, linewidth=0.8, elinewidth=1.0,
            label=label.replace("_", " ") if several else None,
        )  # fmt: skip
    if several:
        ax.legend()
    later = times[times > 0.0]
    ax.set(xlabel="t [d/U]", ylabel=symbol if unit == "1" else f"{symbol} [{_raised(unit)}]")
    if _spans_decades(later):
        ax.set_xscale("log")
    value = found.value[times > 0.0] if "log" in ax.get_xscale() else found.value
    if _spans_decades(value[np.isfinite(value)]):
        ax.set_yscale("log")


def _draw_histogram(ax: "Axes", found: Histogram, name: str, times: np.ndarray) -> None:
    from matplotlib import colormaps

    _, unit, words = VARIABLES[name]
    density = found.density.value
    n = len(density)
    shown = np.unique(np.linspace(0, n - 1, min(n, _MOST_LINES)).round().astype(int))
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, shown.size))
    for k, colour in zip(shown, colours, strict=True):
        label = f"t = {_written(times[k])} d/U" if n == times.size and n > 1 else None
        filled = np.where(density[k] > 0.0, density[k], np.nan)
        ax.stairs(filled, found.edges, baseline=None, color=colour, label=label)
    if shown.size > 1:
        ax.legend()
    counted = np.nonzero(np.any(density > 0.0, axis=0))[0]
    if counted.size:
        ax.set_xlim(found.edges[counted[0]], found.edges[counted[-1] + 1])
    ax.set(xscale="log", yscale="log", xlabel=f"{words} [{unit}]", ylabel=f"density [1/{unit}]")


def _spans_decades(values: np.ndarray) -> bool:
    return bool(values.size > 1 and 0.0 < values.min() * _DECADES < values.max())


def _written(number: float) -> str:
    """A number as it is written in plain text: 0.0123, 1e6, 4.5e-7."""
    mantissa, _, exponent = f"{number:.4g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else mantissa


def _raised(unit: str) -> str:
    return unit.replace("^2", "²")


def _import(module: str, what: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        how = f"python -m pip install 'inelastic-lorentz[{module}]'"
        raise ValueError(f"{what}: needs {module}, which is not installed: {how}") from None

"""Results: estimates with standard errors, and an Ensemble as datasets, data frames and plots.

Tracers of one configuration share their scatterers and are not independent; configurations are. So
every error is the spread over configurations: the delete-one jackknife, and the ratio estimator's
variance for histograms (Cochran, Sampling Techniques, chapters 6 and 9). It is infinite with one.

pandas, xarray and matplotlib are imported when they are asked for.
"""

import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from particles.outputs import ESTIMATES, OF_FLIGHTS, VARIABLES
from particles.values import Value, package_version, refuse

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

DECADES = 30.0  # last over first time from which on the axis is logarithmic


@dataclass(frozen=True, eq=False)
class Estimate(Value):
    """A value and its standard error, arrays of one shape; time is the first axis.

    The value is NaN where nothing was sampled, the error infinite where it is unknown.
    """

    value: np.ndarray
    error: np.ndarray

    def __repr__(self) -> str:
        """One line for each of the first and last values along the first axis, ten at most."""
        values, errors = np.atleast_1d(self.value), np.atleast_1d(self.error)
        if values.ndim > 1:
            return f"Estimate of shape {values.shape}"
        lines = [_shown(float(v), float(e)) for v, e in zip(values, errors, strict=True)]
        if len(lines) > 9:
            lines[4:-4] = [f"... {len(lines) - 8} more"]
        return f"Estimate({lines[0]})" if len(lines) == 1 else "\n".join(["Estimate", *lines])

    def divided(self, by: np.ndarray | float) -> "Estimate":
        """Return the estimate in another unit."""
        return Estimate(self.value / by, self.error / by)


def _shown(value: float, error: float) -> str:
    """A number to the second digit of its error; as it is where that is too long, or unknown."""
    if not (0.0 < error < np.inf and 1e-4 <= max(abs(value), error) < 1e6):
        return f"{value:.6g} ± {error:.2g}"
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


@dataclass(frozen=True, eq=False)
class Histogram(Value):
    """Share of the samples in each bin.

    edges (n_bins + 1,), the same at every time. probability: Estimate (n_times, n_bins) of the
    share in a bin, not divided by its width; below, above (n_times,): the shares outside.
    """

    edges: np.ndarray
    probability: Estimate
    below: np.ndarray
    above: np.ndarray

    @property
    def density(self) -> Estimate:
        """Probability per unit of the variable, (n_times, n_bins)."""
        return self.probability.divided(np.diff(self.edges))


def jackknife(sums: np.ndarray, function: Callable[[np.ndarray], np.ndarray]) -> Estimate:
    """Return function(total) with its delete-one error.

    sums (n_configurations, ...); function maps a sum over configurations to an array.
    """
    with np.errstate(all="ignore"):
        total, n = sums.sum(axis=0), len(sums)
        value = np.asarray(function(total), dtype=float)
        if n < 2:
            return Estimate(value, np.full(value.shape, np.inf))
        # Deviations from the value: no cancellation in the squares.
        deviations = np.array([function(total - part) for part in sums]) - value
        error = np.sqrt((n - 1) * deviations.var(axis=0))
    return Estimate(value, np.where(np.isnan(error), np.inf, error))


def share(
    counts: np.ndarray, squares: np.ndarray, cross: np.ndarray, samples: np.ndarray, n: int
) -> Estimate:
    """Return counts / samples with its error over n configurations.

    counts, squares, cross (n_times, n_bins): sums over them of the count c in a bin, of c^2 and of
    c m, m the number of samples; samples (2, n_times): sums of m and of m^2.
    """
    with np.errstate(all="ignore"):
        total = samples[0][:, None]
        p = counts / total
        spread = np.maximum(squares - 2.0 * p * cross + p * p * samples[1][:, None], 0.0)
        error = np.sqrt(spread * (n / (n - 1))) / total if n > 1 else np.full(p.shape, np.inf)
    return Estimate(p, np.where(np.isnan(error), np.inf, error))


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
            "scene": json.dumps(plan.reported(), default=repr),
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

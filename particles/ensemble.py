"""Ensemble: the frozen result of a simulation, and the sums it is made from.

What is computed of these sums is a table in `particles.outputs`; how, with standard errors, is in
`particles.results`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple, overload

import numpy as np

from particles import outputs as tables
from particles.configuration import Totals
from particles.datasets import dataset_names, make_dataframe, make_dataset
from particles.impact import Law
from particles.media import Medium
from particles.plan import PER_OCTAVE, Plan
from particles.plots import describe_system, draw_all_outputs, draw_output
from particles.results import (
    COLUMNS,
    WHY_UNKNOWN,
    Estimate,
    Histogram,
    Statuses,
    estimate_shares,
    format_estimate,
    jackknife,
)
from particles.values import Value, check_path, html_table, read_only, refuse, shown_path, suggest

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

    from particles.animation import Clock
    from particles.paths import Trajectory


def _estimate(name: str) -> "cached_property[Estimate]":
    """Return an attribute of an Ensemble: an estimate, computed when it is first used."""

    def compute(ensemble: "Ensemble") -> Estimate:
        return ensemble._compute_average(name)

    average = tables.ESTIMATES[name]
    compute.__doc__ = f"Estimate of {average.words}; unit {average.unit}."
    return cached_property(compute)


def _histogram(name: str) -> "cached_property[Histogram]":
    """Return an attribute of an Ensemble: a histogram, computed when it is first used."""

    def compute(ensemble: "Ensemble") -> Histogram:
        return ensemble._compute_histogram(name)

    variable = tables.VARIABLES[name]
    words = f"Histogram of the {variable.words} in {variable.unit}"
    compute.__doc__ = f"{words}; {PER_OCTAVE} bins per octave."
    return cached_property(compute)


@dataclass(frozen=True, eq=False)
class Ensemble(Value):
    """Result of `simulate`. Units: d, U and d/U; time is the first axis of every array.

    Tracers that reached the collision cap or escaped before an output time are left out of every
    estimate at that time: what is left is biased towards slow tracers. `samples` says how many
    entered, `missing` how many did not. Trapped and captured tracers stay in, at rest (`trapped`
    says how many, at each time). Some estimates, such as `drift`, are there in a field only.

    plan: what was run. arrays: the sums and raw data that every estimate is made from, by the
    names that they have in a file.
    """

    plan: Plan
    arrays: Mapping[str, np.ndarray]

    # -- what was run ------------------------------------------------------------------------------

    @property
    def medium(self) -> Medium:
        """The medium that was specified."""
        return self.plan.medium

    @property
    def restitution(self) -> float | Law:
        """The coefficient of restitution, or how it depends on the impact speed."""
        return self.plan.drive.restitution

    @property
    def tangential_restitution(self) -> float:
        """The factor of the velocity across the line of centres at a collision."""
        return self.plan.drive.tangential_restitution

    @property
    def mass_ratio(self) -> float:
        """Mass of a scatterer over that of the tracer, inf for fixed scatterers."""
        return self.plan.drive.mass_ratio

    @property
    def bath_speed(self) -> float:
        """Standard deviation of a component of a scatterer's velocity, in U."""
        return self.plan.drive.bath_speed

    @property
    def heating(self) -> float:
        """D of the noise <dv_i dv_j> = 2 D delta_ij dt, in U^3/d."""
        return self.plan.drive.heating

    @property
    def drag(self) -> float:
        """The coefficient gamma of the drag dv = -gamma v dt, in U/d."""
        return self.plan.drive.drag

    @property
    def capture_speed(self) -> float:
        """Impact speed below which tracers stick, in U."""
        return self.plan.drive.capture_speed

    @property
    def field(self) -> float:
        """The acceleration along +x in U^2/d."""
        return self.plan.drive.field

    @property
    def number_density(self) -> float:
        """Scatterers per unit area, or volume."""
        return self.plan.medium.number_density

    @property
    def times(self) -> np.ndarray:
        """Output times in d/U, (n_times,)."""
        return self.plan.times

    @property
    def tracers(self) -> int:
        """Number of tracers in each configuration."""
        return self.plan.tracers

    @property
    def media(self) -> int:
        """Number of configurations: of a part of a run, those of the part."""
        return len(self.plan.configurations)

    def __getattr__(self, name: str) -> object:
        # Called where an attribute is missing, and where one has raised AttributeError.
        if name.startswith("_"):
            raise AttributeError(name)
        attribute = getattr(type(self), name, None)
        if attribute is not None:
            return attribute.__get__(self, type(self))  # which says why it is missing
        near = suggest(name, dir(type(self)), tables.ALIASES)
        raise AttributeError(f"an Ensemble has no {name!r}{near}")

    def __getitem__(self, name: str) -> Estimate | Histogram:
        """An estimate or a histogram, as the attribute of the same name."""
        names = dataset_names(self)
        if name not in names:
            near = suggest(name, names, tables.ALIASES)
            raise KeyError(f"{name!r}: this ensemble has {', '.join(names)}{near}")
        output: Estimate | Histogram = getattr(self, name)
        return output

    def __repr__(self) -> str:
        arguments = [f"{name}={value!r}" for name, value in self.plan.reported().items()]
        parts = (
            f"Ensemble({', '.join(arguments)}, {self.times.size} times)",
            repr(self.statuses),
            f"outputs: {', '.join(self.outputs)}",
        )
        lines = [fill(part, COLUMNS - 2, subsequent_indent="    ") for part in parts]
        return "\n  ".join(lines)

    def _repr_html_(self) -> str:
        """A table of the estimates at the first and the last time, with how the tracers ended."""
        system = ", ".join(describe_system(self.plan))
        times = self.times
        shown = [] if times.size == 0 else sorted({0, times.size - 1})
        heads = ["", *(f"t = {times[k]:.6g} d/U" for k in shown), "unit"]
        rows = []
        for name in self.outputs:
            if name not in tables.ESTIMATES:
                continue
            estimate: Estimate = getattr(self, name)
            unit = tables.ESTIMATES[name].unit
            if estimate.value.ndim == 0:
                text = format_estimate(float(estimate.value), float(estimate.error))
                cells = [""] * max(0, len(shown) - 1) + [text]
            else:
                cells = [", ".join(estimate.cells()[k]) for k in shown]
            rows.append((name, *cells, unit))
        count = f"media = {self.media}, tracers in each = {self.tracers}"
        rows.append((count, repr(self.statuses)))
        rows.append(("outputs", ", ".join(self.outputs)))
        if self.media == 1:
            rows.append((WHY_UNKNOWN,))
        return html_table(f"Ensemble: {system}", heads, rows)

    # -- how the tracers ended, and how many there are ---------------------------------------------

    @cached_property
    def statuses(self) -> Statuses:
        """How the tracers ended."""
        traps = self.arrays["traps"]  # configuration, tracer, time, place
        counts = self.arrays["statuses"].tolist()
        return Statuses(
            finished=counts[tables.FINISHED],
            collision_cap=counts[tables.COLLISION_CAP],
            trapped=counts[tables.TRAPPED],
            escaped=counts[tables.ESCAPED],
            trap_times=traps[:, 2] * self._unit,
            trap_places=traps[:, 3:] * self._unit,
            trap_tracers=traps[:, :2].astype(np.int64),
            captured=counts[tables.CAPTURED],
        )

    @property
    def collision_total(self) -> int:
        """Number of collisions of all tracers."""
        return int(self.arrays["path_sums"][:, tables.ALL_COLLISIONS].sum())

    @cached_property
    def samples(self) -> np.ndarray:
        """Tracers that enter the estimates at each time, (n_times,)."""
        return read_only(self.moments[:, :, tables.SAMPLES].sum(axis=0).astype(np.int64))

    @property
    def missing(self) -> np.ndarray:
        """Tracers that ended before each time, by the collision cap or escape, (n_times,)."""
        return read_only(self.media * self.tracers - self.samples)

    @cached_property
    def trapped(self) -> np.ndarray:
        """Tracers among the samples at rest, in a corner or captured, at each time, (n_times,)."""
        return read_only(self.moments[:, :, tables.CAUGHT].sum(axis=0).astype(np.int64))

    # -- estimates and histograms ------------------------------------------------------------------

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the estimates, histograms and raw data that this ensemble has."""
        names = [*tables.SCALARS]
        if self.field:
            names.extend(tables.IN_FIELD)
        elif self.capture_speed:
            names.append("trapped_fraction")
        if self.plan.depth is not None:
            names.extend(["passage_times", *tables.OF_A_DEPTH])
        requested = self.plan.observables
        names.extend(name for name in (*tables.HISTOGRAMS, *tables.RAW) if name in requested)
        return tuple(names)

    thermal_speed = _estimate("thermal_speed")
    a2 = _estimate("a2")
    msd = _estimate("msd")
    kurtosis = _estimate("kurtosis")
    collisions = _estimate("collisions")
    velocity_autocorrelation = _estimate("velocity_autocorrelation")

    drift = _estimate("drift")
    drift_of_moving = _estimate("drift_of_moving")
    trapped_fraction = _estimate("trapped_fraction")
    mean_velocity = _estimate("mean_velocity")
    velocity_tensor = _estimate("velocity_tensor")
    mean_displacement = _estimate("mean_displacement")
    dispersion = _estimate("dispersion")
    dispersion_parallel = _estimate("dispersion_parallel")
    dispersion_perpendicular = _estimate("dispersion_perpendicular")

    speed_histogram = _histogram("speed_histogram")
    velocity_component_histogram = _histogram("velocity_component_histogram")
    displacement_histogram = _histogram("displacement_histogram")
    free_path_histogram = _histogram("free_path_histogram")
    free_time_histogram = _histogram("free_time_histogram")

    @property
    def moments(self) -> np.ndarray:
        """Sums that estimates are made of, per configuration and time, (media, n_times, 8)."""
        return self.arrays["moments"]

    @cached_property
    def mean_free_path(self) -> Estimate:
        """Path travelled per collision, all tracers from start to end, in d. A scalar."""
        unit = self._unit

        def path_per_collision(sums: np.ndarray) -> np.ndarray:
            return np.asarray(sums[tables.TRAVELLED] / sums[tables.ALL_COLLISIONS] * unit)

        return jackknife(self.arrays["path_sums"], path_per_collision)

    @cached_property
    def passed(self) -> Estimate:
        """Share of the tracers that have reached the depth by each time, (n_times,)."""
        return self._mean_over_tracers(self.passage_times[:, None] <= self.times)

    @cached_property
    def mean_passage_time(self) -> Estimate:
        """Mean of `passage_times`, a scalar; infinite if one of the tracers never had x = depth."""
        return self._mean_over_tracers(self.passage_times)

    # -- raw data ----------------------------------------------------------------------------------

    @property
    def passage_times(self) -> np.ndarray:
        """When each tracer first had x = depth, in d/U, (media * tracers,); inf if it never had."""
        if "raw/passages" not in self.arrays:
            raise AttributeError("passages were not asked for: simulate(field=..., depth=...)")
        return read_only(self.arrays["raw/passages"] * self._unit)

    @property
    def positions(self) -> np.ndarray:
        """Displacement in d, (n_times, media * tracers, dimension); NaN where a tracer ended."""
        return read_only(self._requested("positions", "raw/positions") * self._unit)

    @property
    def velocities(self) -> np.ndarray:
        """Velocity in U, (n_times, media * tracers, dimension); NaN where a tracer ended."""
        return self._requested("velocities", "raw/velocities")

    @property
    def finals(self) -> np.ndarray:
        """End of each tracer, (.., 5): ln v, ln t, x, y, number of collisions; in space z, too."""
        unit = self._unit
        finals = self._requested("finals", "raw/finals")
        columns = finals.shape[1]
        factor = np.array([1, 1, unit, unit, 1, unit])[:columns]
        addend = np.array([0, np.log(unit), 0, 0, 0, 0])[:columns]
        return read_only(finals * factor + addend)

    # -- paths, datasets, pictures -----------------------------------------------------------------

    def trajectories(
        self,
        tracers: int | None = None,
        configuration: int = 0,
        until: float | None = None,
        collisions: int = 300,
    ) -> list["Trajectory"]:
        """Return the paths of the first tracers of a configuration, made again to the same bits.

        tracers: how many; None for eight, or all where a configuration has fewer. until: the time
        in d/U at which they end, that of the last output if None. collisions: where they end at the
        latest.
        """
        from particles.paths import trajectories

        return trajectories(self.plan, tracers, configuration, until, collisions)

    def plot_trajectories(
        self,
        tracers: int | None = None,
        ax: "Axes | None" = None,
        colour_bar: bool = True,
        configuration: int = 0,
        until: float | None = None,
        collisions: int = 300,
    ) -> "Axes":
        """Draw such paths among the scatterers, coloured by speed; return the axes.

        ax: axes to draw on, new ones if None. Other arguments as of `trajectories`.
        """
        from particles.paths import plot_trajectories

        return plot_trajectories(
            self.plan, tracers, ax, colour_bar, configuration, until, collisions
        )

    def to_xarray(self) -> "xarray.Dataset":
        """Return estimates and histograms, each with `<name>_error`, and what was run."""
        return make_dataset(self, dataset_names(self))

    def to_dataframe(self, name: str | None = None) -> "pandas.DataFrame":
        """Return a table with a row for each time: each estimate, or component, and its error.

        With a `name`, that of a histogram for example, a row for each place of its array. Units are
        in `frame.attrs`. ValueError for a name that is not there.
        """
        if name is None:
            return make_dataframe(self)
        self._require_output(name)
        return make_dataset(self, [name]).to_dataframe().reset_index()

    def animate(
        self,
        path: str | PathLike[str] | None = None,
        tracers: int | None = None,
        frames: int = 120,
        clock: "Clock" = "log time",
        per_second: float = 20.0,
        configuration: int = 0,
        until: float | None = None,
        collisions: int = 100,
    ) -> "FuncAnimation":
        """Make a film of tracers among the scatterers, coloured by their speeds.

        Nothing need have been recorded: as in `trajectories`, the paths are found again, to the
        same bits. In space the picture is the projection on x and y.

        Parameters
        ----------
        path : file to save the film to, .gif (by Pillow) or .mp4 (where the program ffmpeg is);
            None to save none: ``film.to_jshtml()`` shows it in a notebook
        tracers, configuration : which tracers are shown, the first of a configuration; None for
            eight, or all where it has fewer
        frames : number of frames, 2 to 2000
        clock : how they are spaced, as collisions of tracers that cool follow at ever longer times:
            "log time" for equal ratios of times, from about the first collision on, or
            "collisions" for equal numbers of collisions
        per_second : frames in a second of the film
        until : time in d/U at which it ends, that of the last output if None
        collisions : of each tracer, at which it ends at the latest, 1000 at most

        Returns
        -------
        matplotlib.animation.FuncAnimation

        Raises
        ------
        ValueError : an argument out of range; another ending; MP4 without ffmpeg; a path that
            cannot be written
        """
        from particles.animation import animate

        return animate(
            self.plan, path, tracers, frames, clock, per_second, configuration, until, collisions
        )

    @overload
    def plot(self, name: None = None, ax: None = None) -> "list[Axes]": ...

    @overload
    def plot(self, name: str, ax: "Axes | None" = None) -> "Axes": ...

    def plot(self, name: str | None = None, ax: "Axes | None" = None) -> "Axes | list[Axes]":
        """Draw an estimate over time with its standard errors, or the density of a histogram.

        On `ax` or on new axes, which are returned, labelled with units. Without a name everything
        is drawn in one figure, and a list of axes is returned. ValueError for a name that is not
        there or is one number.
        """
        if name is not None:
            self._require_output(name)
            return draw_output(self, name, ax)
        if ax is not None:
            raise ValueError("ax: axes without a name; name what to draw on them")
        return draw_all_outputs(self)

    # -- files, parts of a run ---------------------------------------------------------------------

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything to an HDF5 file, whole; one that exists, or a link's, is replaced.

        Raises ValueError if it cannot be written.
        """
        from particles.files import write

        write(path, self.plan, self.arrays, self.media)

    def write_h5md(self, path: str | PathLike[str]) -> None:
        """Write positions and velocities, which must be kept, as H5MD 1.1 for other programs."""
        from particles.files import write_h5md

        for name in ("positions", "velocities"):
            if name not in self.outputs:
                raise ValueError(f"H5MD needs {name}: simulate(observables=[...])")
        positions = self.positions / self._unit
        write_h5md(check_path("path", path), self.plan, positions, self.velocities)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "Ensemble":
        """Read a finished run from a file; ValueError for a damaged or an unfinished one."""
        from particles.files import read

        plan, arrays, done = read(path)
        count = len(plan.configurations)
        if done < count:
            raise ValueError(
                f"{shown_path(path)}: holds {done} of {count} configurations; finish it with "
                f"simulate(..., output=..., resume=True)"
            )
        return cls(plan, arrays)

    @classmethod
    def merge(cls, parts: "Iterable[Ensemble | str | PathLike[str]]") -> "Ensemble":
        """Return the whole run from all its parts, to the same bits as if it had been run at once.

        parts: of `simulate(..., part=(k, n))`, or their files, in any order; n may differ.
        """
        allowed = "it must be a sequence of ensembles or of their files"
        if isinstance(parts, (str, bytes, PathLike, Ensemble)):
            refuse("parts", parts, allowed)
        try:
            parts = list(parts)
        except TypeError:
            refuse("parts", parts, allowed)
        runs = [_open_part(part) for part in parts]
        if not runs:
            refuse("parts", [], "it must be at least one part of a run")
        runs.sort(key=lambda part: part.configurations.start)
        plan = runs[0].ensemble.plan.replaced(part=None)
        totals = Totals(plan)
        for run in runs:
            run.require_of(plan)
            done = totals.configurations
            start = run.configurations.start
            if start < done:
                raise ValueError(f"parts: configuration {start} is there twice{run.source}")
            if start > done:
                break
            totals.add(run.ensemble.arrays, len(run.configurations))
        done = totals.configurations
        if done < plan.media:
            missing = f"configuration {done} of 0 to {plan.media - 1} is missing"
            part = _part_with(done, runs[0].ensemble.plan)
            raise ValueError(f"parts: {missing}{part}")
        return cls(plan, totals.arrays())

    # -- helpers -----------------------------------------------------------------------------------

    @property
    def _unit(self) -> float:
        """The diameter d: in files lengths are in d."""
        return self.medium.diameter

    def _requested(self, name: str, key: str) -> np.ndarray:
        """Return an array that is there only if it was requested; name: in `observables`."""
        if key not in self.arrays:
            raise AttributeError(f"{name} was not asked for: simulate(observables=[{name!r}, ...])")
        return self.arrays[key]

    def _require_output(self, name: object) -> None:
        """Raise ValueError for the name of no estimate and no histogram of this ensemble."""
        names = dataset_names(self)
        if not isinstance(name, str) or name not in names:
            near = suggest(name, names, tables.ALIASES)
            if isinstance(name, str) and name in tables.VARIABLES:
                near = f"; for {name} call simulate(observables=[{name!r}, ...])"
            refuse("name", name, f"this ensemble has {', '.join(names)}{near}")

    def _mean_over_tracers(self, numbers: np.ndarray) -> Estimate:
        """Return the mean of numbers of each tracer, (media * tracers, ...)."""
        of_configurations = numbers.reshape(self.media, self.tracers, *numbers.shape[1:])
        sums = of_configurations.sum(axis=1)
        counts = np.full(sums.shape, self.tracers)
        return jackknife(np.stack((sums, counts), axis=1), lambda total: total[0] / total[1])

    def _compute_average(self, name: str) -> Estimate:
        """Return the average of this name in `outputs.ESTIMATES`, from sums over tracers."""
        average = tables.ESTIMATES[name]
        compute = average.compute
        assert compute is not None
        sums = self.moments
        if self.field:
            sums = np.concatenate([sums, self.arrays["field_sums"]], axis=2)
        elif name in tables.IN_FIELD and name != "trapped_fraction":
            raise AttributeError(f"{name} is there in a field only: simulate(field=...)")
        dimension = self.medium.dimension
        estimate = jackknife(sums, lambda total: compute(tables.Sums(total, dimension)))
        # After the jackknife: squares of late speeds are too small for a number.
        if average.scaled:
            return estimate.divided(self.plan.scales())
        return estimate.divided(self._unit ** -tables.LENGTH_POWERS[average.unit])

    def _compute_histogram(self, name: str) -> Histogram:
        """Return the histogram of this name in `outputs.VARIABLES`."""
        counts, squares, cross = self._requested(name, f"histograms/{name}/sums")
        samples = self.arrays[f"histograms/{name}/samples"]
        shares = estimate_shares(counts, squares, cross, samples, self.media)
        low, per_octave, bins = self.plan.grids()[tables.HISTOGRAMS.index(name)]
        edges = 2.0 ** (low + np.arange(int(bins) + 1) / per_octave)
        if name not in tables.OF_VELOCITIES:
            edges = edges * self._unit
        inside = Estimate(shares.value[:, 1:-1], shares.error[:, 1:-1])
        return Histogram(edges, inside, below=shares.value[:, 0], above=shares.value[:, -1])


class _PartOfRun(NamedTuple):
    """A part of a run that is to be merged, and for messages the file that it was read from."""

    ensemble: Ensemble
    source: str

    @property
    def configurations(self) -> range:
        """The numbers of its configurations."""
        return self.ensemble.plan.configurations

    def require_of(self, plan: Plan) -> None:
        """Raise ValueError for a part of another run than this whole one."""
        own = self.ensemble.plan
        if difference := plan.difference_from(own.replaced(part=None)):
            name = own.part or "the whole"
            raise ValueError(f"parts: {name}{self.source} is of {difference}")


def _part_with(configuration: int, plan: Plan) -> str:
    """Return the end of a message: which part of a run has a configuration; "" if there is none."""
    if plan.part is None:
        return ""
    n = plan.part[1]
    for k in range(1, n + 1):
        if configuration in plan.replaced(part=(k, n)).configurations:
            return f": part {k}/{n} is not among the files"
    return ""


def _open_part(part: "Ensemble | str | PathLike[str]") -> _PartOfRun:
    """Return a part of a run that is an ensemble or a file."""
    if isinstance(part, Ensemble):
        return _PartOfRun(part, "")
    return _PartOfRun(Ensemble.load(part), f" ({shown_path(part)})")


def load(path: str | PathLike[str]) -> Ensemble:
    """Read a finished run from a file, as Ensemble.load does."""
    return Ensemble.load(path)

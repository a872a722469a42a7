"""Ensemble: the frozen result of a simulation, and the sums it is made from."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from particles import outputs as tables
from particles.configuration import Totals
from particles.plan import PER_OCTAVE, Plan
from particles.results import Estimate, Histogram, Result, jackknife, share
from particles.values import Value, check_path, frozen, refuse

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from particles.paths import Trajectory


@dataclass(frozen=True, eq=False)
class Statuses(Value):
    """How many tracers ended in each way, and where and when the trapped ones did.

    finished: reached the last output time. collision_cap: made max_collisions collisions first.
    trapped: caught in a corner between scatterers, where infinitely many collisions follow within
    1e-9 d or so, or at rest after a head-on collision at e = 0. In a field at rest in a corner of
    two disks that opens against the field; with a tangential restitution below 1, where it would
    slide along a disk; and at rest on the very top of a disk. escaped: flew 1e6 mean free paths
    without a collision. captured: struck a scatterer with a normal velocity below capture_speed.
    trap_times (trapped + captured,) in d/U: when it was declared. With tangential restitution 1 the
    collisions end later by what some 1e-9 d take at the last speed, below 1 they may take for ever.
    trap_places (.., dimension) from the tracer's start, in d; trap_tracers (.., 2): configuration
    and tracer.
    """

    finished: int
    collision_cap: int
    trapped: int
    escaped: int
    trap_times: np.ndarray = field(repr=False)
    trap_places: np.ndarray = field(repr=False)
    trap_tracers: np.ndarray = field(repr=False)
    captured: int = 0


def _of_plan(name: str, words: str) -> Any:
    return property(lambda ensemble: attrgetter(name)(ensemble.plan), doc=words)


@dataclass(frozen=True, eq=False)
class Ensemble(Result):
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

    medium = _of_plan("medium", "The medium asked for.")
    restitution = _of_plan("drive.restitution", "The coefficient of restitution, or its law.")
    tangential_restitution = _of_plan(
        "drive.tangential_restitution", "The factor of what is across."
    )
    mass_ratio = _of_plan(
        "drive.mass_ratio", "Mass of a scatterer over that of the tracer; often inf."
    )
    bath_speed = _of_plan("drive.bath_speed", "Of a component of a scatterer's velocity, in U.")
    heating = _of_plan("drive.heating", "D of the noise <dv_i dv_j> = 2 D delta_ij dt, in U^3/d.")
    drag = _of_plan("drive.drag", "gamma of the drag dv = -gamma v dt, in U/d.")
    capture_speed = _of_plan("drive.capture_speed", "Impact speed below which tracers stick, in U.")
    field = _of_plan("drive.field", "The acceleration along +x in U^2/d.")
    number_density = _of_plan("medium.number_density", "Scatterers per unit area, or volume.")
    times = _of_plan("times", "Output times in d/U, (n_times,).")
    tracers = _of_plan("tracers", "Number of tracers in each configuration.")

    @property
    def media(self) -> int:
        """Number of configurations: of a part of a run, those of the part."""
        return len(self.plan.configurations)

    def __repr__(self) -> str:
        arguments = [f"{name}={value!r}" for name, value in self.plan.reported().items()]
        about = f"{self.statuses!r}\n  outputs: {', '.join(self.outputs)}"
        return f"Ensemble({', '.join(arguments)}, {self.times.size} times)\n  {about}"

    @property
    def outputs(self) -> tuple[str, ...]:  # type: ignore[override]
        """Names of the estimates, histograms and raw data that this ensemble has."""
        others = (n for n in (*tables.HISTOGRAMS, *tables.RAW) if n in self.plan.observables)
        passages = ("passage_times", *tables.OF_A_DEPTH) if self.plan.depth is not None else ()
        sticking = ("trapped_fraction",) if self.capture_speed else ()
        return (*tables.SCALARS, *(tables.IN_FIELD if self.field else sticking), *passages, *others)

    @property
    def moments(self) -> np.ndarray:
        """Sums that estimates are made of, per configuration and time, (media, n_times, 8)."""
        return self.arrays["moments"]

    @cached_property
    def statuses(self) -> Statuses:
        """How the tracers ended."""
        traps, unit = self.arrays["traps"], self._unit
        finished, cap, trapped, escaped, captured = self.arrays["statuses"].tolist()
        when, where, which = traps[:, 2] * unit, traps[:, 3:] * unit, traps[:, :2].astype(np.int64)
        return Statuses(finished, cap, trapped, escaped, when, where, which, captured)

    @property
    def collision_total(self) -> int:
        """Number of collisions of all tracers."""
        return int(self.arrays["path_sums"][:, tables.ALL_COLLISIONS].sum())

    @cached_property
    def samples(self) -> np.ndarray:
        """Tracers that enter the estimates at each time, (n_times,)."""
        return frozen(self.moments[:, :, tables.SAMPLES].sum(axis=0).astype(np.int64))

    @property
    def missing(self) -> np.ndarray:
        """Tracers that ended before each time, by the collision cap or escape, (n_times,)."""
        return frozen(self.media * self.tracers - self.samples)

    @cached_property
    def trapped(self) -> np.ndarray:
        """Tracers among the samples at rest, in a corner or captured, at each time, (n_times,)."""
        return frozen(self.moments[:, :, tables.CAUGHT].sum(axis=0).astype(np.int64))

    @cached_property
    def mean_free_path(self) -> Estimate:
        """Path travelled per collision, all tracers from start to end, in d. A scalar."""
        sums, unit = self.arrays["path_sums"], self._unit
        return jackknife(sums, lambda s: s[tables.TRAVELLED] / s[tables.ALL_COLLISIONS] * unit)

    @property
    def passage_times(self) -> np.ndarray:
        """When each tracer first had x = depth, in d/U, (media * tracers,); inf if it never had."""
        if "raw/passages" not in self.arrays:
            raise AttributeError("passages were not asked for: simulate(field=..., depth=...)")
        return frozen(self.arrays["raw/passages"] * self._unit)

    @cached_property
    def passed(self) -> Estimate:
        """Share of the tracers that have reached the depth by each time, (n_times,)."""
        return self._over_tracers(self.passage_times[:, None] <= self.times)

    @cached_property
    def mean_passage_time(self) -> Estimate:
        """Mean of `passage_times`, a scalar; infinite if one of the tracers never had x = depth."""
        return self._over_tracers(self.passage_times)

    @property
    def positions(self) -> np.ndarray:
        """Displacement in d, (n_times, media * tracers, dimension); NaN where a tracer ended."""
        return frozen(self._get("positions", "raw/positions") * self._unit)

    @property
    def velocities(self) -> np.ndarray:
        """Velocity in U, (n_times, media * tracers, dimension); NaN where a tracer ended."""
        return self._get("velocities", "raw/velocities")

    @property
    def finals(self) -> np.ndarray:
        """End of each tracer, (.., 5): ln v, ln t, x, y, number of collisions; in space z, too."""
        d = self._unit
        finals = self._get("finals", "raw/finals")
        scale, shift = np.array([1, 1, d, d, 1, d]), np.array([0, np.log(d), 0, 0, 0, 0])
        columns = finals.shape[1]
        return frozen(finals * scale[:columns] + shift[:columns])

    def trajectories(self, tracers: int = 8, **which: Any) -> list["Trajectory"]:
        """Return the paths of the first tracers of a configuration, made again to the same bits.

        which: configuration (0), until (the last time), collisions (300).
        """
        from particles.paths import trajectories

        return trajectories(self.plan, tracers, **which)

    def plot_trajectories(self, tracers: int = 8, **which: Any) -> "Axes":
        """Draw such paths among the scatterers, coloured by speed; return the axes.

        which: as of `trajectories`, ax (axes to draw on) and colour_bar (True).
        """
        from particles.paths import plot_trajectories

        return plot_trajectories(self.plan, tracers, **which)

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything to an HDF5 file, whole; one that exists, or a link's, is replaced.

        Raises ValueError if it cannot be written.
        """
        from particles.files import write

        write(path, self.plan, self.arrays, self.media)

    def write_h5md(self, path: str | PathLike[str]) -> None:
        """Write positions and velocities, which must be kept, as H5MD 1.1 for other programs."""
        from particles.files import write_h5md

        if missing := {"positions", "velocities"} - {*self.outputs}:
            raise ValueError(f"H5MD needs {min(missing)}: simulate(observables=[...])")
        positions = self.positions / self._unit
        write_h5md(check_path("path", path), self.plan, positions, self.velocities)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "Ensemble":
        """Read a finished run from a file; ValueError for a damaged or an unfinished one."""
        from particles.files import read

        plan, arrays, done = read(path)
        if done < (count := len(plan.configurations)):
            raise ValueError(
                f"{path}: holds {done} of {count} configurations; finish it with "
                f"simulate(..., output=..., resume=True)"
            )
        return cls(plan, arrays)

    @classmethod
    def merge(cls, parts: "Iterable[Ensemble | str | PathLike[str]]") -> "Ensemble":
        """Return the whole run from all its parts, to the same bits as if it had been run at once.

        parts: of `simulate(..., part=(k, n))`, or their files, in any order; n may differ.
        """
        if isinstance(parts, (str, bytes, PathLike, Ensemble)):
            refuse("parts", parts, "it must be a sequence of ensembles or of their files")
        named = [(x, "") if isinstance(x, Ensemble) else (cls.load(x), f" ({x})") for x in parts]
        named.sort(key=lambda one: one[0].plan.configurations.start)
        if not named:
            refuse("parts", [], "it must be at least one part of a run")
        plan = named[0][0].plan.replaced(part=None)
        totals = Totals(plan)
        for run, name in named:
            own, done = run.plan.configurations, totals.configurations
            if other := plan.difference_from(run.plan.replaced(part=None)):
                raise ValueError(f"parts: {run.plan.part or 'the whole'}{name} is of {other}")
            if own.start < done:
                raise ValueError(f"parts: configuration {own.start} is there twice{name}")
            if own.start > done:
                break
            totals.add(run.arrays, len(own))
        if (done := totals.configurations) < plan.media:
            raise ValueError(f"parts: configuration {done} of 0 to {plan.media - 1} is missing")
        return cls(plan, totals.arrays())

    @property
    def _unit(self) -> float:
        return self.medium.diameter

    def _get(self, name: str, key: str) -> np.ndarray:
        if key not in self.arrays:
            raise AttributeError(f"{name} was not asked for: simulate(observables=[{name!r}, ...])")
        return self.arrays[key]

    def _over_tracers(self, each: np.ndarray) -> Estimate:
        """Return the mean of what each tracer has, (media * tracers, ...)."""
        sums = each.reshape(self.media, self.tracers, *each.shape[1:]).sum(axis=1)
        numbers = np.full(sums.shape, self.tracers)
        return jackknife(np.stack((sums, numbers), axis=1), lambda total: total[0] / total[1])

    def _average(self, name: str) -> Estimate:
        unit, _, of, scaled = tables.ESTIMATES[name]
        sums = self.moments
        if self.field:
            sums = np.concatenate([sums, self.arrays["field_sums"]], axis=2)
        elif name in tables.IN_FIELD and name != "trapped_fraction":
            raise AttributeError(f"{name} is there in a field only: simulate(field=...)")
        assert of is not None
        d = self.medium.dimension
        found = jackknife(sums, lambda total: of(tables.Sums(total, d)))
        # after the jackknife: squares of late speeds are too small for a number
        return found.divided(self.plan.scales() if scaled else self._unit ** -_LENGTHS[unit])

    def _histogram(self, name: str) -> Histogram:
        counts, squares, cross = self._get(name, f"histograms/{name}/sums")
        samples = self.arrays[f"histograms/{name}/samples"]
        low, per_octave, bins = self.plan.grids()[tables.HISTOGRAMS.index(name)]
        edges = 2.0 ** (low + np.arange(int(bins) + 1) / per_octave)
        if name not in tables.HISTOGRAMS[:2]:
            edges = edges * self._unit
        found = share(counts, squares, cross, samples, self.media)
        inside = Estimate(found.value[:, 1:-1], found.error[:, 1:-1])
        return Histogram(edges, inside, found.value[:, 0], found.value[:, -1])


_LENGTHS = {"1": 0, "U": 0, "U^2": 0, "d": 1, "d^2": 2}


def _attach(name: str, make: Callable[[Ensemble, str], Any], words: str) -> None:
    def attribute(ensemble: Ensemble) -> Any:
        return make(ensemble, name)

    attribute.__doc__ = words
    made = cached_property(attribute)
    made.__set_name__(Ensemble, name)
    setattr(Ensemble, name, made)


for _name, _one in tables.ESTIMATES.items():
    if _one.of is not None:
        _attach(_name, Ensemble._average, f"Estimate of {_one.words}; unit {_one.unit}.")
for _name, (_, _unit, _words) in tables.VARIABLES.items():
    _words = f"Histogram of the {_words} in {_unit}; {PER_OCTAVE} bins per octave."
    _attach(_name, Ensemble._histogram, _words)


def load(path: str | PathLike[str]) -> Ensemble:
    """Read a finished run from a file, as Ensemble.load does."""
    return Ensemble.load(path)

"""Ensemble: the frozen result of a simulation, and the sums it is made from."""

from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike

import numpy as np

from particles.configuration import HISTOGRAMS, RAW, Plan, Tally, time_scales
from particles.estimators import Estimate, Histogram, jackknife, share
from particles.media import Medium

# Columns of the moments, as in particles.kernel.records (not imported: numba is heavy).
_N, _V2, _V4, _R2, _R4, _COLLISIONS, _CORRELATION, _CAUGHT = range(8)


@dataclass(frozen=True)
class Statuses:
    """How many tracers ended in each way, and where and when the trapped ones did.

    finished: reached the last output time. collision_cap: made max_collisions collisions first.
    trapped: caught in a corner between two scatterers, where infinitely many collisions follow in
    a finite time. Declared after a flight shorter than 1e-9 d if, between two straight walls, the
    tracer would never leave (events.is_collapsing); or at rest after a head-on collision at e = 0.
    escaped: flew 1e6 mean free paths without a collision. trap_times (trapped,) in d/U, short of
    the end by what some 1e-9 d take at the last speed; trap_places (trapped, 2) relative to the
    start, in d; trap_tracers (trapped, 2): configuration and tracer.
    """

    finished: int
    collision_cap: int
    trapped: int
    escaped: int
    trap_times: np.ndarray = field(repr=False)
    trap_places: np.ndarray = field(repr=False)
    trap_tracers: np.ndarray = field(repr=False)


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Result of `simulate`. Units: d, U and d/U; time is the first axis of every array.

    Tracers that reached the collision cap or escaped before an output time are left out of every
    estimate at that time: what is left is biased towards slow tracers. `samples` says how many
    entered, `missing` how many did not. Trapped tracers stay in: they are at rest where they were
    caught (`trapped` says how many, at each time).

    plan: what was run. arrays: the sums and raw data that every estimate is made from, by the
    names that particles.storage.file gives them in a file.
    """

    plan: Plan
    arrays: dict[str, np.ndarray] = field(repr=False)

    @property
    def medium(self) -> Medium:
        """The medium asked for."""
        return self.plan.medium

    @property
    def restitution(self) -> float:
        """The coefficient of restitution."""
        return self.plan.restitution

    @property
    def number_density(self) -> float:
        """Scatterers per unit area."""
        return self.medium.number_density

    @property
    def times(self) -> np.ndarray:
        """Output times in d/U, (n_times,)."""
        return self.plan.times

    @property
    def media(self) -> int:
        """Number of configurations."""
        return self.plan.media

    @property
    def tracers(self) -> int:
        """Number of tracers in each configuration."""
        return self.plan.tracers

    @property
    def moments(self) -> np.ndarray:
        """Sums per configuration and time (columns: kernel.records), (media, n_times, 8)."""
        return self.arrays["moments"]

    @cached_property
    def statuses(self) -> Statuses:
        """How the tracers ended."""
        traps = self.arrays["traps"]
        finished, cap, trapped, escaped = (int(n) for n in self.arrays["statuses"])
        return Statuses(
            finished,
            cap,
            trapped,
            escaped,
            trap_times=traps[:, 2] * self._unit,
            trap_places=traps[:, 3:5] * self._unit,
            trap_tracers=traps[:, :2].astype(np.int64),
        )

    @property
    def collision_total(self) -> int:
        """Number of collisions of all tracers."""
        return int(self.arrays["path_sums"][:, 1].sum())

    @cached_property
    def samples(self) -> np.ndarray:
        """Tracers that enter the estimates at each time, (n_times,)."""
        return self.moments[:, :, _N].sum(axis=0).astype(np.int64)

    @property
    def missing(self) -> np.ndarray:
        """Tracers that ended before each time, by the collision cap or escape, (n_times,)."""
        return self.media * self.tracers - self.samples

    @cached_property
    def trapped(self) -> np.ndarray:
        """Tracers among the samples at rest in a corner at each time, (n_times,)."""
        return self.moments[:, :, _CAUGHT].sum(axis=0).astype(np.int64)

    @cached_property
    def thermal_speed(self) -> Estimate:
        """sqrt(<v^2>) in U, (n_times,): the paper's v0(t), eq. v0defi."""
        sums = jackknife(self.moments, lambda m: np.sqrt(m[:, _V2] / m[:, _N]))
        return sums.divided(self._scales)

    @cached_property
    def a2(self) -> Estimate:
        """<v^4> / (2 <v^2>^2) - 1, (n_times,): 0 for a Gaussian."""
        return jackknife(
            self.moments, lambda m: m[:, _V4] * m[:, _N] / (2.0 * m[:, _V2] ** 2) - 1.0
        )

    @cached_property
    def msd(self) -> Estimate:
        """Mean square displacement <r^2> in d^2, (n_times,)."""
        return jackknife(self.moments, lambda m: m[:, _R2] / m[:, _N]).divided(self._unit**-2)

    @cached_property
    def kurtosis(self) -> Estimate:
        """<r^4> / <r^2>^2, (n_times,): 2 for a Gaussian in the plane. NaN at time 0."""
        return jackknife(self.moments, lambda m: m[:, _R4] * m[:, _N] / m[:, _R2] ** 2)

    @cached_property
    def collisions(self) -> Estimate:
        """Mean number of collisions per tracer up to each time, (n_times,)."""
        return jackknife(self.moments, lambda m: m[:, _COLLISIONS] / m[:, _N])

    @cached_property
    def velocity_autocorrelation(self) -> Estimate:
        """<v(t).v(0)> in U^2, (n_times,)."""
        sums = jackknife(self.moments, lambda m: m[:, _CORRELATION] / m[:, _N])
        return sums.divided(self._scales)

    @cached_property
    def mean_free_path(self) -> Estimate:
        """Path travelled per collision, all tracers from start to end, in d. A scalar."""
        return jackknife(self.arrays["path_sums"], lambda s: s[0] / s[1] * self._unit)

    @property
    def speed_histogram(self) -> Histogram:
        """Distribution of |v| in U; 16 bins per octave."""
        return self._histogram("speed_histogram")

    @property
    def velocity_component_histogram(self) -> Histogram:
        """Distribution of |v_x| in U (the distribution of v_x is even); 16 bins per octave."""
        return self._histogram("velocity_component_histogram")

    @property
    def displacement_histogram(self) -> Histogram:
        """Distribution of |r| in d: the paper's g(r, t); 16 bins per octave."""
        return self._histogram("displacement_histogram")

    @property
    def free_path_histogram(self) -> Histogram:
        """Distribution of the completed flights' length in d, over the whole run (n_times = 1)."""
        return self._histogram("free_path_histogram")

    @property
    def positions(self) -> np.ndarray:
        """Displacement of each tracer in d, (n_times, media * tracers, 2); NaN where it ended."""
        return self._get("positions", "raw/positions") * self._unit

    @property
    def velocities(self) -> np.ndarray:
        """Velocity of each tracer in U, (n_times, media * tracers, 2); NaN where it ended."""
        return self._get("velocities", "raw/velocities")

    @property
    def finals(self) -> np.ndarray:
        """End of each tracer, (media * tracers, 5): ln v, ln t, x, y, number of collisions."""
        d = self._unit
        scale, shift = np.array([1, 1, d, d, 1]), np.array([0, np.log(d), 0, 0, 0])
        return self._get("finals", "raw/finals") * scale + shift

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything to an HDF5 file (layout: storage.file), replacing it if it exists.

        Written beside its target and renamed. Raises ValueError if it cannot be written.
        """
        from particles.storage.file import write

        write(path, self.plan, self.arrays, self.media)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "Ensemble":
        """Read a finished run from a file.

        Raises ValueError for a file that is not one, is damaged or holds an unfinished run.
        """
        from particles.storage.file import read

        plan, arrays, done = read(path)
        if done < plan.media:
            raise ValueError(
                f"{path}: holds {done} of {plan.media} configurations; finish it with "
                f"simulate(..., output=..., resume=True)"
            )
        return cls(plan, arrays)

    @property
    def _unit(self) -> float:
        return self.medium.diameter

    @cached_property
    def _scales(self) -> np.ndarray:
        return time_scales(self.times / self._unit)

    def _get(self, name: str, key: str) -> np.ndarray:
        if key not in self.arrays:
            raise AttributeError(f"{name} was not asked for: simulate(observables=[{name!r}, ...])")
        return self.arrays[key]

    def _histogram(self, name: str) -> Histogram:
        counts, squares, cross = self._get(name, f"histograms/{name}/sums")
        samples = self.arrays[f"histograms/{name}/samples"]
        low, per_octave, bins = self.plan.grids()[HISTOGRAMS.index(name)]
        length = name in ("displacement_histogram", "free_path_histogram")
        edges = 2.0 ** (low + np.arange(int(bins) + 1) / per_octave)
        if length:
            edges = edges * self._unit
        everything = share(counts, squares, cross, samples, self.media)
        p, error = everything.value, everything.error
        return Histogram(edges, Estimate(p[:, 1:-1], error[:, 1:-1]), p[:, 0], p[:, -1])


class Totals:
    """Tallies of configurations 0, 1, ... added up in this order."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.configurations = 0
        self._moments = np.zeros((plan.media, plan.times.size, 8))
        self._path_sums = np.zeros((plan.media, 2))
        self._statuses = np.zeros(4, np.int64)
        self._traps: list[np.ndarray] = [np.empty((0, 5))]
        self._histograms: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._raw: dict[str, list[np.ndarray]] = {n: [] for n in RAW if n in plan.observables}

    def add(self, tally: Tally) -> None:
        """Add the next configuration's tally."""
        c = self.configurations
        if tally.configuration != c:
            raise RuntimeError(f"tally of configuration {tally.configuration} came before {c}")
        self._moments[c] = tally.moments
        self._path_sums[c] = tally.totals
        self._statuses += tally.statuses
        self._traps.append(np.insert(tally.traps, 0, c, axis=1))
        for name, counts in tally.histograms.items():
            if name not in self._histograms:
                shape = counts.shape
                self._histograms[name] = (
                    np.zeros((3, *shape), np.int64),
                    np.zeros((2, shape[0]), np.int64),
                )
            sums, samples = self._histograms[name]
            m = counts.sum(axis=1)
            sums += np.stack((counts, counts * counts, counts * m[:, None]))
            samples += np.stack((m, m * m))
        for name, pieces in self._raw.items():
            pieces.append(tally.raw[name])
        self.configurations += 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Return everything added so far, by name; not copies."""
        done = self.configurations
        arrays = {
            "moments": self._moments[:done],
            "path_sums": self._path_sums[:done],
            "statuses": self._statuses,
            "traps": np.concatenate(self._traps),
        }
        for name, (sums, samples) in self._histograms.items():
            arrays[f"histograms/{name}/sums"] = sums
            arrays[f"histograms/{name}/samples"] = samples
        for name, pieces in self._raw.items():
            if pieces:
                arrays[f"raw/{name}"] = np.concatenate(pieces, axis=0 if name == "finals" else 1)
        return arrays

    @classmethod
    def restore(cls, plan: Plan, arrays: dict[str, np.ndarray]) -> "Totals":
        """Return totals as they were when `arrays` were taken of them."""
        totals = cls(plan)
        totals.configurations = done = len(arrays["moments"])
        totals._moments[:done] = arrays["moments"]
        totals._path_sums[:done] = arrays["path_sums"]
        totals._statuses[:] = arrays["statuses"]
        totals._traps = [arrays["traps"]]
        for name in HISTOGRAMS:
            if f"histograms/{name}/sums" in arrays:
                totals._histograms[name] = (
                    arrays[f"histograms/{name}/sums"],
                    arrays[f"histograms/{name}/samples"],
                )
        for name in totals._raw:
            if f"raw/{name}" in arrays:
                totals._raw[name] = [arrays[f"raw/{name}"]]
        return totals

    def ensemble(self) -> Ensemble:
        """Return the result once every configuration has been added."""
        arrays = self.arrays()
        for array in (*arrays.values(), self.plan.times):
            array.setflags(write=False)
        return Ensemble(self.plan, arrays)

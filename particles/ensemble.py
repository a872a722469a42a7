"""Ensemble: the frozen result of a simulation, and the sums it is made from."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from particles.configuration import HISTOGRAMS, RAW, Plan, Tally, time_scales
from particles.estimators import Estimate, Histogram, jackknife, share
from particles.media import Medium

# Columns of the moments, as in particles.kernels (not imported: numba is heavy).
_N, _V2, _V4, _R2, _R4, _COLLISIONS, _CORRELATION, _CAUGHT = range(8)
STATUSES = ("finished", "collision cap", "trapped", "escaped")


@dataclass(frozen=True)
class Statuses:
    """How many tracers ended in each way, and where and when the trapped ones did.

    finished: reached the last output time. collision_cap: made max_collisions collisions first.
    trapped: caught in a corner between scatterers, where infinitely many collisions follow in a
    finite time; declared after 16 successive flights shorter than 1e-9 d. escaped: flew 1e6 mean
    free paths without a collision. trap_times (trapped,) in d/U, trap_places (trapped, 2) relative
    to the start, in d, trap_tracers (trapped, 2): configuration and tracer.
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

    times (n_times,). Tracers that reached the collision cap or escaped before an output time are
    left out of every estimate at that time: what is left is biased towards slow tracers.
    `samples` says how many entered, `missing` how many did not. Trapped tracers stay in: they are
    at rest where they were caught (`trapped` says how many, at each time).
    """

    medium: Medium
    restitution: float
    initial: str
    times: np.ndarray
    media: int
    tracers: int
    max_collisions: int | None
    seed: int
    statuses: Statuses
    collision_total: int
    moments: np.ndarray = field(repr=False)
    path_sums: np.ndarray = field(repr=False)
    histogram_sums: dict[str, tuple[np.ndarray, np.ndarray]] = field(repr=False)
    histogram_grids: dict[str, np.ndarray] = field(repr=False)
    raw: dict[str, np.ndarray] = field(repr=False)

    @property
    def number_density(self) -> float:
        """Scatterers per unit area."""
        return self.medium.number_density

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
        scale = self._scales
        return jackknife(self.moments, lambda m: np.sqrt(m[:, _V2] / m[:, _N]) / scale)

    @cached_property
    def a2(self) -> Estimate:
        """<v^4> / (2 <v^2>^2) - 1, (n_times,): 0 for a Gaussian."""
        return jackknife(
            self.moments, lambda m: m[:, _V4] * m[:, _N] / (2.0 * m[:, _V2] ** 2) - 1.0
        )

    @cached_property
    def msd(self) -> Estimate:
        """Mean square displacement <r^2> in d^2, (n_times,)."""
        return jackknife(self.moments, lambda m: m[:, _R2] / m[:, _N] * self._unit**2)

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
        scale = self._scales
        return jackknife(self.moments, lambda m: m[:, _CORRELATION] / m[:, _N] / scale)

    @cached_property
    def mean_free_path(self) -> Estimate:
        """Path travelled per collision, all tracers from start to end, in d. A scalar."""
        return jackknife(self.path_sums, lambda s: s[0] / s[1] * self._unit)

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
        return self._raw("positions")

    @property
    def velocities(self) -> np.ndarray:
        """Velocity of each tracer in U, (n_times, media * tracers, 2); NaN where it ended."""
        return self._raw("velocities")

    @property
    def finals(self) -> np.ndarray:
        """End of each tracer, (media * tracers, 5): ln v, ln t, x, y, number of collisions."""
        return self._raw("finals")

    @property
    def _unit(self) -> float:
        return self.medium.diameter

    @cached_property
    def _scales(self) -> np.ndarray:
        return time_scales(self.times / self._unit)

    def _raw(self, name: str) -> np.ndarray:
        if name not in self.raw:
            raise AttributeError(f"{name} was not asked for: simulate(observables=[{name!r}, ...])")
        return self.raw[name]

    def _histogram(self, name: str) -> Histogram:
        if name not in self.histogram_sums:
            raise AttributeError(f"{name} was not asked for: simulate(observables=[{name!r}, ...])")
        low, per_octave, bins = self.histogram_grids[name]
        length = name in ("displacement_histogram", "free_path_histogram")
        edges = 2.0 ** (low + np.arange(int(bins) + 1) / per_octave)
        if length:
            edges = edges * self._unit
        (counts, squares, cross), samples = self.histogram_sums[name]
        everything = share(counts, squares, cross, samples, self.media)
        p, error = everything.value, everything.error
        return Histogram(edges, Estimate(p[:, 1:-1], error[:, 1:-1]), p[:, 0], p[:, -1])


class Totals:
    """Tallies of configurations 0, 1, ... added up in this order."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.configurations = 0
        self.moments = np.zeros((plan.media, plan.times.size, 8))
        self.path_sums = np.zeros((plan.media, 2))
        self.statuses = np.zeros(len(STATUSES), np.int64)
        self.traps: list[np.ndarray] = []
        self.histograms: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self.raw: dict[str, list[np.ndarray]] = {n: [] for n in RAW if n in plan.observables}

    def add(self, tally: Tally) -> None:
        """Add the next configuration's tally."""
        c = self.configurations
        if tally.configuration != c:
            raise RuntimeError(f"tally of configuration {tally.configuration} came before {c}")
        self.moments[c] = tally.moments
        self.path_sums[c] = tally.totals
        self.statuses += tally.statuses
        self.traps.append(np.insert(tally.traps, 0, c, axis=1))
        for name, counts in tally.histograms.items():
            if name not in self.histograms:
                shape = counts.shape
                self.histograms[name] = (
                    np.zeros((3, *shape), np.int64),
                    np.zeros((2, shape[0]), np.int64),
                )
            sums, samples = self.histograms[name]
            m = counts.sum(axis=1)
            sums += np.stack((counts, counts * counts, counts * m[:, None]))
            samples += np.stack((m, m * m))
        for name, pieces in self.raw.items():
            pieces.append(tally.raw[name])
        self.configurations += 1

    def ensemble(self) -> Ensemble:
        """Return the result once every configuration has been added."""
        plan = self.plan
        d = plan.medium.diameter
        traps = np.concatenate(self.traps)
        if plan.velocities is not None:
            initial = "given"
        else:
            initial = "monoenergetic" if plan.monoenergetic else "gaussian"
        finished, cap, trapped, escaped = (int(n) for n in self.statuses)
        raw = {
            name: np.concatenate(pieces, axis=0 if name == "finals" else 1)
            for name, pieces in self.raw.items()
        }
        if d != 1.0:
            if "positions" in raw:
                raw["positions"] *= d
            if "finals" in raw:
                raw["finals"][:, 1] += np.log(d)
                raw["finals"][:, 2:4] *= d
        arrays = [self.moments, self.path_sums, plan.times, *raw.values()]
        for array in arrays:
            array.setflags(write=False)
        return Ensemble(
            medium=plan.medium,
            restitution=plan.restitution,
            initial=initial,
            times=plan.times,
            media=plan.media,
            tracers=plan.tracers,
            max_collisions=plan.max_collisions,
            seed=plan.seed,
            statuses=Statuses(
                finished,
                cap,
                trapped,
                escaped,
                trap_times=traps[:, 2] * d,
                trap_places=traps[:, 3:5] * d,
                trap_tracers=traps[:, :2].astype(np.int64),
            ),
            collision_total=int(self.path_sums[:, 1].sum()),
            moments=self.moments,
            path_sums=self.path_sums,
            histogram_sums=self.histograms,
            histogram_grids=dict(zip(HISTOGRAMS, plan.grids(), strict=True)),
            raw=raw,
        )

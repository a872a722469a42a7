"""A sample of tracers, reduced to sums over groups of them: all that a comparison looks at.

It is from files and tables (`read_sample`: which units, how positions are meant, what makes a
group), or from a run of the package's simulator. Tracers among the same scatterers are not
independent, configurations are. So a group is one (or several), or, where they are unknown, a
number of tracers; every error is the spread over groups.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from kinetics.collision.impact import Viscoelastic, impact_restitution
from kinetics.crosscheck.data import formats
from kinetics.crosscheck.data.tracks import Asked, Rows, Tracks, bad, dense, name_of
from kinetics.crosscheck.words import numeral
from kinetics.drive import DRIVES
from kinetics.validation import refuse

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

# columns of the sums: samples, powers of speed and displacement; in a field and from a beam v_x, x,
# x^2 too, and the same of the other axes
N, V2, V4, R2, R4, VX, X, X2 = range(8)
# groups at most: primes, so that labels with a regular pattern spread over all of them; an error
# from G groups has the relative error 1/sqrt(2 G): 4.5 %, and 8 % for counts in bins
MOST_GROUPS, HISTOGRAM_GROUPS = 251, 83
# bins of speeds and displacements, 12 in an octave, from a thousandth of their scale to 64 times it
EDGES = 2.0 ** (np.arange(-120, 73) / 12)


class StartBins(NamedTuple):
    """Speeds at time 0 in fine bins, of those that move: mean v^2 in U^2 and tracers, (n_bins,)."""

    squares: Array
    counts: Counts


@dataclass(frozen=True)
class Law:
    """What the system has, as a Scene has it, in U and d."""

    restitution: Any = None  # only one that depends on the impact speed: a number is no part of it
    dimension: int = 2
    bath_speed: float = 0.0
    mass_ratio: float = math.inf
    heating: float = 0.0
    drag: float = 0.0
    field: float = 0.0
    capture_speed: float = 0.0
    tangential_restitution: float = 1.0

    @property
    def is_driven(self) -> bool:
        """Whether `kinetics.driven` solves it: no causes of a difference are looked for."""
        return self.restitution is not None or any(getattr(self, name) for name in DRIVES)

    @property
    def rtol(self) -> float:
        """Asked of the solver for averages: far below any standard error."""
        return 1e-5 if self.field or self.is_driven else 1e-7

    @property
    def smooth_disks(self) -> bool:
        """Whether densities can be solved, which the solver does for this law alone."""
        return self == Law()

    @property
    def gaussian(self) -> float:
        """<v^4>/<v^2>^2 of a Gaussian: 2 in the plane, 5/3 in space."""
        return (self.dimension + 2) / self.dimension

    def free_path(self, density: float) -> float:
        """Mean free path in d at a number density in d^-2 (d^-3 in space); and the other way."""
        return 1 / ((2.0 if self.dimension == 2 else math.pi) * density)


@dataclass(frozen=True, eq=False)
class Sample:
    """Sums over groups of tracers; lengths in d, speeds in U, times (n_times,) in d/U, rising.

    sums : (n_groups, n_times, 5), of 1, v^2, v^4, r^2, r^4; in a field, or if all start with one
        velocity, v_x, x, x^2, v_y, ... too
    at_rest : (n_times,), how many have speed zero
    grouping : what a group is made of: "medium", "tracer" or "row"
    speeds, displacements : None, or a scale (n_times,) and counts between EDGES in units of it, and
        outside, of groups that are not those of the sums, (n, n_times, n_bins + 2)
    flights : (time, |r|/(|v| t)) of tracers that have flown straight, at the time when most have:
        1 where units belong together, whatever the scatterers, or where few have
    free : known to meet no scatterer twice (Boltzmann-Grad particles)
    told : "restitution", "number_density" (in d^-2), "initial", "scatterers", as the data say
    units : "speed", "length" and "time": U, d and d/U in the data's unit, where they were told
    """

    names: tuple[str, ...]
    times: Array
    sums: Array
    at_rest: Counts
    grouping: str
    speeds: tuple[Array, Counts] | None = None
    displacements: tuple[Array, Counts] | None = None
    start: StartBins | None = None
    flights: tuple[float, float] = (0.0, 1.0)
    law: Law = Law()
    free: bool = False
    warnings: tuple[str, ...] = ()
    told: dict[str, Any] = field(default_factory=dict)
    units: dict[str, float] = field(default_factory=dict)

    @property
    def groups(self) -> int:
        """Number of independent groups."""
        return len(self.sums)

    @property
    def samples(self) -> Counts:
        """Tracers at each time, (n_times,)."""
        return np.rint(self.sums[:, :, N].sum(axis=0)).astype(np.int64)


def reduced(
    tracks: Tracks, label: Any, names: tuple[str, ...], grouping: str, with_axes: bool = False
) -> Sample:
    """The sums over groups of tracers; label (n,): whole numbers that say what belongs together."""
    # Another file's labels begin elsewhere, so that small runs do not fall on each other.
    group = (label % MOST_GROUPS + 97 * tracks.file) % MOST_GROUPS
    count, bins = tracks.times.size, EDGES.size + 1
    first = tracks.velocity[0] - np.nanmean(tracks.velocity[0], axis=0)
    with_axes |= tracks.times[0] == 0 and np.nanmax(np.abs(first)) < 1e-9
    axes = tracks.place.shape[2] if with_axes else 0
    sums = np.zeros((MOST_GROUPS, count, VX + 3 * axes))
    scales, at_rest = np.ones((2, count)), np.zeros(count, np.int64)
    counts = np.zeros((2, HISTOGRAM_GROUPS, count, bins), np.int32)
    start, flights = None, [(0.0, 1.0, 0.0)]
    for k, time in enumerate(tracks.times):
        there = np.isfinite(tracks.velocity[k, :, 0])
        place, velocity, mine = tracks.place[k, there], tracks.velocity[k, there], group[there]
        v, r = size_of(velocity), size_of(place)
        flights.append((*straight_flights(float(time), r, v), float(time)))
        powers = [None, v**2, (v**2) ** 2, r**2, (r**2) ** 2]
        for axis in range(axes):
            powers += [velocity[:, axis], place[:, axis], place[:, axis] ** 2]
        sums[:, k] = np.transpose([np.bincount(mine, power, MOST_GROUPS) for power in powers])
        at_rest[k] = np.count_nonzero(v == 0)
        for i, size in enumerate((v, r)):
            with np.errstate(divide="ignore"):
                logs, mean = np.log2(size), np.log2(np.sum(size**2) / max(size.size, 1))
            # the root mean square as a power of 2 hardly depends on single tracers
            octave = max(np.round(mean / 2), -1000.0)
            scales[i, k] = 2.0**octave
            bin_of = np.clip(np.floor(12 * (logs - octave + 10)), -1, bins - 2).astype(np.int64) + 1
            cells = mine % HISTOGRAM_GROUPS * bins + bin_of
            counted = np.bincount(cells, minlength=HISTOGRAM_GROUPS * bins)
            counts[i, :, k] = counted.reshape(-1, bins)
        if time == 0:
            v = v[v > 0]
            fine = np.floor(64 * np.log2(v))
            _, code, filled = np.unique(fine, return_inverse=True, return_counts=True)
            start = StartBins(np.bincount(code, v * v) / filled, filled)
    speeds, displacements = (
        (scale, one[one.any(axis=(1, 2))]) for scale, one in zip(scales, counts, strict=True)
    )
    used = sums[..., N].sum(axis=1) > 0
    _, ratio, time = max(flights)
    return Sample(
        names, tracks.times, sums[used], at_rest, grouping, speeds, displacements, start,
        (time, ratio),
    )  # fmt: skip


def straight_flights(time: float, distance: Any, speed: Any) -> tuple[float, float]:
    """The share of tracers (n,) that have the same |r|/(|v| t) within .2 %, and that; 0 if too few.

    Twenty at least, and 5 %: those that have collided put some 0.5 % into such a width.
    """
    moving = (distance > 0) & (speed > 0) & (time > 0)
    ratio = np.sort(np.log(distance[moving]) - np.log(speed[moving]) - np.log(time or 1.0))
    alike = np.searchsorted(ratio, ratio + 0.002) - np.arange(ratio.size)
    count = int(alike.max(initial=0))
    if count < max(20, 0.05 * distance.size):
        return 0.0, 1.0
    first = int(np.argmax(alike))
    return count / distance.size, float(np.exp(np.median(ratio[first : first + count])))


def size_of(vectors: Any) -> Any:
    """The length of vectors (n, d), also of 1e200."""
    plane = np.hypot(vectors[:, 0], vectors[:, 1])  # `reduce` takes longer
    return plane if vectors.shape[1] == 2 else np.hypot(plane, vectors[:, 2])


def errors(replicates: Array) -> Array:
    """Standard errors from delete-one replicates (G, ...)."""
    return np.asarray(replicates.std(axis=0) * np.sqrt(len(replicates) - 1))


def effective_groups(replicates: Array) -> Array:
    """Groups that a variance from delete-one replicates (G, ...) is as good as, G at most."""
    # the relative variance of a variance is (2 + kurtosis)/G (Satterthwaite's rule)
    deviation = replicates - replicates.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        excess = np.mean(deviation**4, axis=0) / np.mean(deviation**2, axis=0) ** 2 - 3
    excess = np.where(np.isfinite(excess), np.maximum(excess, 0.0), 0.0)
    return np.asarray(1 + 2 * (len(replicates) - 1) / (2 + excess))


# -- files, and tables in memory -------------------------------------------------------------------
def read_sample(sources: Sequence[Path | Mapping[str, Any]], **told: Any) -> Sample:
    """One sample from files or columns in memory (see `formats`), or from one file of an Ensemble.

    told : arguments of `tracks.Asked`. Several files are independent runs. With one configuration,
    or without the column `medium`, errors are by tracer, and the sample's warnings say so.
    """
    asked, names = Asked(**told), [name_of(source) for source in sources]
    paths = [source for source in sources if isinstance(source, Path)]
    if not names or len({*paths}) < len(paths):
        got = f"a file twice in {', '.join(names)}" if names else "no file"
        bad("data", got, "one file at least, of independent tracers")
    parts: list[Rows] = []
    for source, name in zip(sources, names, strict=True):
        part = formats.read(source, asked)
        if not isinstance(part, dict):
            if len(sources) > 1:
                bad(name, "an Ensemble of several", "the only file")
            return from_ensemble(part, name.rsplit("/", 1)[-1])
        parts.append(part)
    names = [name.rsplit("/", 1)[-1] for name in names]
    where = ", ".join(names)
    tracks, place = _displacements(dense(parts, names, asked), where, asked)
    sample, groups = _grouped(tracks, tuple(names), asked)
    law, told = Law(dimension=asked.dimension or 2), asked.units
    units = {} if {*told.values()} == {1.0} else told
    return replace(sample, law=law, units=units, warnings=(*place, *groups))


def _displacements(tracks: Tracks, where: str, asked: Asked) -> tuple[Tracks, list[str]]:
    """The tracers relative to their places at time 0, and what is to be said of it."""
    place, first = tracks.place, tracks.times[0]
    size = [float(np.nanmean(size_of(at) ** 2)) for at in place]
    moved = first == 0 and size[0] > 1e-18 * max(size)
    if asked.positions == "displacement" or (asked.positions == "auto" and not moved):
        return tracks, []
    if tracks.tracer is None or first != 0:
        bad(f"{where}: positions", "absolute", "with a column tracer and rows at time 0")
    for tracer in tracks.tracer[np.isnan(place[0, :, 0])]:
        bad(f"{where}: tracer {tracer}", "no row at time 0", "there, for absolute positions")
    tracks = replace(tracks, place=place - place[0])
    # wrapped where none leaves the region of time 0, and twenty would, if not wrapped
    low, high = place[0].min(axis=0), place[0].max(axis=0)
    n, least = place.shape[1], float((high - low).min())
    far = math.sqrt(max(float(np.nanmean(size_of(at) ** 2)) for at in tracks.place))
    # the farthest tracer is not quite at the edge of the region that they come from
    away = np.nanmax(np.abs(place - (low + high) / 2), axis=(0, 1))
    if np.all(away <= (high - low) * (0.5 + 10 / n)) and n * far >= 20 * least > 0:
        got = f"some that look wrapped in a box, within {low} to {high} d, for moves of {far:.4g} d"
        bad(f"{where}: positions", got, "unwrapped")
    said = "Each tracer's own place at time 0, not the origin, was subtracted from its positions."
    return tracks, [said] if asked.positions == "auto" else []


def _grouped(tracks: Tracks, names: tuple[str, ...], asked: Asked) -> tuple[Sample, list[str]]:
    """The sums over configurations where there are several, else over tracers."""
    n, warnings = tracks.place.shape[1], list[str]()
    labels, by = np.arange(n), "row"
    if tracks.tracer is not None:
        labels, by = pd.factorize(tracks.tracer, sort=True)[0], "tracer"
    if tracks.medium is not None:
        codes, different = pd.factorize(tracks.medium, sort=True)
        if different.size > 1 or np.max(tracks.file) > 0:  # one alone shows no spread between them
            labels, by = codes, "medium"
    if by != "medium":
        known = "There is one configuration" if tracks.medium is not None else "No column medium"
        warnings.append(
            f"{known}: errors are by tracer. Tracers that share scatterers are not independent: "
            "their errors are larger than these."
        )
    sample = reduced(tracks, labels, names, by, asked.with_axes)
    if sample.groups < 2:
        bad(", ".join(names), "one tracer" if n else "no tracer", "two tracers at least")
    if by == "row":
        warnings.append(
            "No column tracer: the k-th row of each time is taken for the same tracer. If it is "
            "not, p-values over several times are wrong."
        )
    most, last = int(sample.samples.max()), int(np.argmin(sample.samples))
    if sample.samples[last] < most:
        warnings.append(
            f"At t = {numeral(sample.times[last], '.4g')} d/U, {most - sample.samples[last]} of "
            f"{most} tracers are missing. If the reason depends on their speed (a cap on "
            "collisions, a box that fast ones leave), those that survive are not a fair sample."
        )
    return sample, warnings


# -- runs of the package's simulator --------------------------------------------------------------
def from_ensemble(ensemble: Any, name: str = "ensemble") -> Sample:
    """The sums of a run, lengths in d; counts in bins too, where velocities and positions are kept.

    InputError for what is no run, or one without output times or with fewer than two groups.
    """
    from particles import BoltzmannGrad, Ensemble
    from particles.outputs import CAUGHT

    if not isinstance(ensemble, Ensemble):
        refuse("data", ensemble, "it must be a file, several files, columns or a run of simulate")
    medium, plan, d = ensemble.medium, ensemble.plan, ensemble.medium.diameter
    times = np.asarray(ensemble.times) / d
    if times.size == 0 or ensemble.moments.size == 0:
        bad(name, "a run without output times", "made by simulate(..., times=...)")
    sticks = ensemble.capture_speed > 0.0
    # Tracers of a Boltzmann-Grad run share no scatterers: each of them is independent.
    free, stored = isinstance(medium, BoltzmannGrad), ensemble.arrays
    if "raw/velocities" in stored and "raw/positions" in stored:
        place, velocity = np.asarray(ensemble.positions) / d, np.asarray(ensemble.velocities)
        if sticks:  # averages are over those that move
            velocity = np.where(velocity.any(axis=2, keepdims=True), velocity, np.nan)
        label = np.arange(place.shape[1]) // (1 if free else ensemble.tracers)
        tracks, by = Tracks(times, place, velocity), "tracer" if free else "medium"
        found = reduced(tracks, label, (name,), by, bool(ensemble.field))
    else:  # from the sums that every run keeps: the averages alone
        unit = 1.0 / plan.scales()
        sums = ensemble.moments[:, :, : R4 + 1] * np.stack([unit**p for p in (0, 2, 4, 0, 0)], -1)
        if ensemble.field:  # of v, v_i v_j (i <= j), r, and r_i r_j
            more, axes = stored["field_sums"], medium.dimension
            half, squares = more.shape[2] // 2, [0, axes, 2 * axes - 1]
            order = [at for k in range(axes) for at in (k, half + k, half + axes + squares[k])]
            sums = np.concatenate([sums, more[:, :, order]], axis=2)
        if sticks:
            sums[:, :, N] -= ensemble.moments[:, :, CAUGHT]
        found = Sample((name,), times, sums, np.asarray(ensemble.trapped), "medium")
    if found.groups < 2:
        bad(name, "one configuration", "two at least, for standard errors")
    restitution: Any = ensemble.restitution  # the solver's, for the particles' own
    if hasattr(restitution, "b"):
        restitution = Viscoelastic(restitution.b)
    elif not isinstance(restitution, float):
        restitution = impact_restitution((restitution.speeds, restitution.values))
    density = ensemble.number_density * d**medium.dimension
    told = {"restitution": restitution, "number_density": density, "scatterers": medium.scatterers}
    if plan.rest or plan.velocities is None:
        named = "monoenergetic" if plan.monoenergetic else "gaussian"
        told["initial"] = "rest" if plan.rest else named
    law = Law(
        impact_restitution(restitution), medium.dimension, ensemble.bath_speed,
        ensemble.mass_ratio, ensemble.heating * d, ensemble.drag * d, ensemble.field * d,
        ensemble.capture_speed, ensemble.tangential_restitution,
    )  # fmt: skip
    if law.is_driven and not free:
        bad(name, "a driven run among scatterers that have places", "one of BoltzmannGrad")
    return replace(found, free=free, told=told, law=law)

"""What is to be run, as three values: what is simulated, what drives it, and what is recorded.

Begin reading with `Experiment`, `particles.drive.Drive` and `Recording`; a `Plan` is the three.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import reduce
from math import ceil, inf, log2, sqrt
from typing import Any

import numpy as np

from particles import outputs
from particles.drive import Drive
from particles.media import Medium, dilute_mean_path
from particles.values import Value, short

#: Bins per octave of a histogram. Chosen: each bin is 2**(1/16) - 1 = 4.4 % wide.
PER_OCTAVE = 16
#: Octaves of a histogram of speeds below 1 / (last time). The origin of the number is not recorded.
OCTAVES_BELOW_SLOWEST = 20
#: Octaves of a histogram above the fastest tracer. The origin of the number is not recorded.
OCTAVES_ABOVE_FASTEST = 2
#: Largest speed in U that drawn velocities are taken to have. Chosen: histograms go two octaves
#: beyond it.
FASTEST_DRAWN = 4.0
#: Highest octave of a distance, a path or a speed that a histogram has room for. The origin of the
#: number is not recorded.
LARGEST_OCTAVE = 40
#: Standard deviations of the noise that histograms of speeds have room for, at least. The origin of
#: the number is not recorded.
NOISE_DEVIATIONS = 10.0
#: Standard deviations of a bath that they have room for. The origin of the number is not recorded.
BATH_DEVIATIONS = 20.0
#: Octave of the shortest distance and path of a histogram: 2**-12 d. The origin is not recorded.
SHORTEST_OCTAVE = -12
#: Octave of the longest flight time of a histogram. The origin of the number is not recorded.
LATEST_OCTAVE = 60


@dataclass(frozen=True, eq=False, kw_only=True)
class Experiment(Value):
    """What is simulated: tracers in configurations of a medium.

    Parameters
    ----------
    medium : where the scatterers are
    monoenergetic, rest : whether drawn velocities have the size U, and whether all tracers begin at
        rest
    velocities : specified velocities in U, shape (media or none, tracers, dimension); None to draw
        them
    media, tracers : number of configurations, and of tracers in each
    seed : of all random numbers
    part : (k, n) for the k-th of n parts of the configurations; None for all of them
    """

    medium: Medium
    monoenergetic: bool = False
    rest: bool = False
    velocities: np.ndarray | None = None
    media: int
    tracers: int
    seed: int
    part: tuple[int, int] | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording(Value):
    """What is recorded, and until when.

    Parameters
    ----------
    times : output times in d/U, shape (n_times,)
    max_collisions : after which a tracer ends, or None
    observables : names of histograms and raw data that are kept
    depth : x whose first passage is recorded in a field, in d, or None
    """

    times: np.ndarray
    max_collisions: int | None = None
    observables: frozenset[str] = frozenset()
    depth: float | None = None


Arguments = dict[str, Any]
"""Values of arguments, whose types are those of the fields of the same names."""


def _select(kind: type, arguments: Arguments) -> Arguments:
    """Return the arguments that a class has fields for."""
    return {field.name: arguments[field.name] for field in fields(kind)}


@dataclass(frozen=True, eq=False)
class Plan(Value):
    """A run of `simulate`, its arguments checked, in U and the user's unit of length."""

    experiment: Experiment
    drive: Drive
    recording: Recording

    # -- its arguments, by the names that they have in files -------------------------------------

    def arguments(self) -> Iterator[tuple[str, Any]]:
        """Yield the name and the value of every argument."""
        for values in (self.experiment, self.drive, self.recording):
            for argument in fields(values):
                yield argument.name, getattr(values, argument.name)

    @classmethod
    def of_arguments(cls, arguments: Arguments) -> "Plan":
        """Return the plan of checked arguments, by name."""
        return cls(
            Experiment(**_select(Experiment, arguments)),
            Drive(**_select(Drive, arguments)),
            Recording(**_select(Recording, arguments)),
        )

    def replaced(self, **arguments: object) -> "Plan":
        """Return the plan with other values of some arguments."""
        return self.of_arguments(dict(self.arguments()) | arguments)

    def reported(self) -> dict[str, object]:
        """Return the arguments of `simulate` that are of interest, without arrays."""
        arguments = dict(self.arguments())
        names = ["medium", "restitution", "tangential_restitution", "field", "media", "tracers"]
        names += ["max_collisions", "seed"]
        if self.drive.mass_ratio < inf:
            names.append("mass_ratio")
        names += [name for name in outputs.DRIVES if arguments[name]]
        if self.part:
            names.append("part")
        return {name: arguments[name] for name in names}

    def difference_from(self, other: "Plan") -> str:
        """Say in what another plan is another run's; empty if it is not."""
        theirs = dict(other.arguments())
        for name, ours in self.arguments():
            if not np.array_equal(ours, theirs[name]):
                return f"another run, with {name} = {short(theirs[name])}, not {short(ours)}"
        return ""

    @property
    def medium(self) -> Medium:
        """Where the scatterers are."""
        return self.experiment.medium

    @property
    def velocities(self) -> np.ndarray | None:
        """Specified initial velocities in U, or None."""
        return self.experiment.velocities

    @property
    def monoenergetic(self) -> bool:
        """Whether drawn velocities have the size U."""
        return self.experiment.monoenergetic

    @property
    def rest(self) -> bool:
        """Whether all tracers begin at rest."""
        return self.experiment.rest

    @property
    def media(self) -> int:
        """Number of configurations of the whole run."""
        return self.experiment.media

    @property
    def tracers(self) -> int:
        """Number of tracers in each configuration."""
        return self.experiment.tracers

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self.experiment.seed

    @property
    def part(self) -> tuple[int, int] | None:
        """Which part of the configurations is run, or None."""
        return self.experiment.part

    @property
    def times(self) -> np.ndarray:
        """Output times in d/U, shape (n_times,)."""
        return self.recording.times

    @property
    def max_collisions(self) -> int | None:
        """Number of collisions after which a tracer ends, or None."""
        return self.recording.max_collisions

    @property
    def observables(self) -> frozenset[str]:
        """Names of histograms and raw data that are kept."""
        return self.recording.observables

    @property
    def depth(self) -> float | None:
        """The x whose first passage is recorded, in d, or None."""
        return self.recording.depth

    @property
    def capture_speed(self) -> float:
        """The normal speed in U of impacts below which they stick."""
        return self.drive.capture_speed

    # -- what follows from them --------------------------------------------------------------------

    @property
    def configurations(self) -> range:
        """The numbers of the configurations that are run: of the whole run, or of its part."""
        k, n = self.part or (1, 1)
        return range(self.media * (k - 1) // n, self.media * k // n)

    def scales(self) -> np.ndarray:
        """Return the powers of 2 that velocities are multiplied by in sums, shape (n_times,).

        The product v t stays near the mean free path at all times, while v^4 alone would underflow.
        In a field, or driven, a tracer does not slow down for ever, so there they are 1.
        """
        if self.drive.field or self.drive.needs_clock:
            return np.ones(self.times.size)
        times = self.times / self.medium.diameter
        return np.asarray(2.0 ** np.round(np.log2(np.maximum(times, 1.0))))

    def fastest(self) -> float:
        """Return a speed in U that hardly a tracer exceeds."""
        drive = self.drive
        end = self.last_time
        largest = 2.0**LARGEST_OCTAVE
        fastest = FASTEST_DRAWN
        if self.velocities is not None:
            fastest = float(speeds(self.velocities).max())
        if drive.field:
            fastest += min(abs(drive.field) * end, largest)
        if drive.bath_speed:  # elastic tracers gain speed for ever, a fixed share at each collision
            mean_path = dilute_mean_path(self.medium) * self.medium.diameter
            growth = 1.0 + drive.bath_speed * end / mean_path
            fastest += min(BATH_DEVIATIONS * drive.bath_speed * growth, largest)
        return fastest + min(NOISE_DEVIATIONS * sqrt(drive.heating * end), largest)

    @property
    def last_time(self) -> float:
        """The last output time in d/U, 1 without any."""
        return float(self.times[-1]) if self.times.size else 1.0

    def grids(self) -> np.ndarray:
        """Return log2 of the first edge, bins per octave and bins of each histogram, shape (5, 3).

        Speeds from 2**-20 of 1 / (last time) to 4 times what start, field, bath and noise can give;
        distances and paths from 2**-12 d up to what the fastest can fly; flight times from those of
        the shortest path up to the last time.
        """
        fastest = log2(self.fastest())
        end = log2(max(self.last_time, 1.0))
        highest = ceil(fastest) + OCTAVES_ABOVE_FASTEST
        lowest = -ceil(end) - OCTAVES_BELOW_SLOWEST
        farthest = min(max(ceil(fastest + end) + OCTAVES_ABOVE_FASTEST, 4), LARGEST_OCTAVE)
        latest = LATEST_OCTAVE
        if self.times.size:
            longest = max(self.last_time / self.medium.diameter, 1.0)
            latest = min(ceil(log2(longest)), LATEST_OCTAVE)
        octaves = (
            (lowest, highest),
            (lowest, highest),
            (SHORTEST_OCTAVE, farthest),
            (SHORTEST_OCTAVE, LARGEST_OCTAVE),
            (SHORTEST_OCTAVE - highest, latest),
        )
        rows = [(low, PER_OCTAVE, (high - low) * PER_OCTAVE) for low, high in octaves]
        return np.array(rows, float)


def speeds(velocities: np.ndarray) -> np.ndarray:
    """Return the sizes of velocities (..., dimension), without overflow on the way."""
    return reduce(np.hypot, np.moveaxis(velocities, -1, 0))

"""Simulated tracers at a point of the theory: how the averages of a sample scatter by chance.

Weights from the covariance of the data themselves bias a fit (Altonji and Segal, J. Bus. Econ.
Stat. 14, 353 (1996)): where few tracers have collided by chance, the scatter is small too, and the
weight large. And tests with such a covariance reject right data. So covariances are those of
tracers of a Boltzmann-Grad simulation at the point, which know nothing of the data: begin with
`Pool`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from kinetics.crosscheck.compare.measured import Layout
from kinetics.crosscheck.compare.observables import Array
from kinetics.crosscheck.compare.point import Point, SampledStart
from kinetics.crosscheck.compare.statistics import influence_covariance
from kinetics.crosscheck.data.sample import VX, Law

#: Tracers of a pool for weights. Chosen: a variance is known to 2 %, so that errors of a fit are
#: larger than the least possible ones by far less.
N_FOR_WEIGHTS = 4000
#: Tracers of a pool for the test of a verdict. Measured: the standard deviation of the kurtosis at
#: 2.4 l/U, which rare straight flights make, is 0.147; pools of 4,000, 12,000, 20,000 and 80,000
#: have 0.100, 0.117, 0.157 and 0.147 of it.
N_FOR_TEST = 20_000
#: Tracers of a pool for one of many causes, each of which has its own. Chosen: quicker.
N_FOR_CAUSE = 8000
#: Configurations that they are divided among; Boltzmann-Grad tracers share nothing.
N_MEDIA = 20
#: Collisions of all tracers of a pool at most: about a second. Of fewer tracers, if need be.
MAX_COLLISIONS = 2e7
#: Tracers of a pool at least: with fewer there is none.
MIN_TRACERS = 400
#: Collisions of a tracer of speed U in the time l/U: sqrt(pi/2) of a Gaussian start.
COLLISION_RATE = 1.25
#: Seed of the pool, a number like any other: the same data have the same answer.
SEED = 20
#: Sets of tracers that are drawn from a pool.
N_DRAWS = 1000
#: Tracers of a set up to which they are drawn one by one: means of more are taken for Gaussian.
MAX_DRAWN = 3000


def can_simulate(point: Point, law: Law, last_time: float) -> bool:
    """Return whether there is a pool: of undriven tracers, with not too many collisions."""
    if law.field or law.is_driven or callable(point.restitution):
        return False
    return _tracers_per_medium(point, last_time, N_FOR_WEIGHTS) * N_MEDIA >= MIN_TRACERS


def _tracers_per_medium(point: Point, last_time: float, wanted: int) -> int:
    """Return how many tracers of each medium can be followed to a time in d/U, of those wanted."""
    paths = last_time * point.clock / point.path
    loss = 1.0 - float(point.restitution) ** 2
    paths_of_cooling = paths
    if loss > 0.0:  # in a cooling gas the rate falls as 1/(1 + loss/4 paths), or so
        paths_of_cooling = np.log1p(paths * loss / 4) / (loss / 4)
    affordable = MAX_COLLISIONS / max(COLLISION_RATE * paths_of_cooling, 1.0)
    return int(min(wanted, affordable) / N_MEDIA)


class Pool:
    """Tracers simulated at a point, and how means of n of them scatter.

    Parameters
    ----------
    layout : the components
    point : where, among dilute scatterers whatever those of the point are
    has_velocities : see `theory.Theory`
    n_tracers : how many are wanted
    """

    def __init__(
        self,
        layout: Layout,
        point: Point,
        has_velocities: bool = True,
        n_tracers: int = N_FOR_WEIGHTS,
    ) -> None:
        self.layout = layout
        self._draws: dict[int, Array] = {}
        self._sums, self._pair_sums = _simulated_sums(layout, point, has_velocities, n_tracers)

    @property
    def n_tracers(self) -> int:
        """The number of tracers of the pool."""
        return len(self._sums)

    @cached_property
    def values(self) -> Array:
        """The components of all of its tracers, shape (n_components,)."""
        pair_sums = None if self._pair_sums is None else self._pair_sums.sum(axis=0)
        return self.layout.measure(self._sums.sum(axis=0), pair_sums)

    @cached_property
    def influence(self) -> Array:
        """What each tracer adds to each shaped component, times n: (n_tracers, n_components).

        Their covariance over n is that of the mean of n tracers.
        """
        total = self._sums.sum(axis=0)
        pair_sums = None
        if self._pair_sums is not None:
            pair_sums = self._pair_sums.sum(axis=0) - self._pair_sums
        without_each = self.layout.measure(total - self._sums, pair_sums)
        influence = (self.n_tracers - 1) * (self.values - without_each)
        return np.asarray(influence - influence.mean(axis=0))

    @cached_property
    def covariance(self) -> Array:
        """The covariance of the components of one tracer, (n_components, n_components)."""
        return influence_covariance(self.influence)

    def draws(self, n: int) -> Array:
        """Return shaped deviations of means of n tracers drawn from it, (N_DRAWS, n_components).

        Those of the last n are kept.
        """
        if n not in self._draws:
            self._draws = {n: self._draw(n)}
        return self._draws[n]

    def _draw(self, n: int) -> Array:
        random = np.random.default_rng(SEED)
        if n > MAX_DRAWN:
            known = np.nan_to_num(self.covariance)  # the kurtosis has no value at time 0
            return gaussian_vectors(known / n, N_DRAWS, random)
        drawn = random.integers(0, self.n_tracers, N_DRAWS * n)
        sums = _drawn_sums(drawn, self._sums)
        pair_sums = None
        if self._pair_sums is not None:
            pair_sums = _drawn_sums(drawn, self._pair_sums)
        deviation = self.layout.measure(sums, pair_sums) - self.values
        return self.layout.shaped(self.values, deviation)


def _drawn_sums(drawn: NDArray[np.int64], sums: Array) -> Array:
    """Return sums over N_DRAWS sets of tracers.

    Parameters
    ----------
    drawn : numbers of the tracers, one set after another
    sums : of single tracers, shape (n_tracers, ...)
    """
    from scipy.sparse import csr_array

    n_set = drawn.size // N_DRAWS
    starts = n_set * np.arange(N_DRAWS + 1)
    weights = csr_array((np.ones(drawn.size), drawn, starts), shape=(N_DRAWS, len(sums)))
    total = weights @ sums.reshape(len(sums), -1)
    return np.asarray(total).reshape(N_DRAWS, *sums.shape[1:])


def gaussian_vectors(covariance: Array, n: int, random: np.random.Generator) -> Array:
    """Return n Gaussian vectors of mean 0 with a covariance (p, p), shape (n, p)."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return np.asarray(random.normal(size=(n, len(covariance))) @ root.T)


def _simulated_sums(
    layout: Layout, point: Point, has_velocities: bool, wanted: int
) -> tuple[Array, Array | None]:
    """Return the sums of single tracers, (n, n_times, n_sums), and those over pairs of frames.

    What units, noise and tracers at rest do to data is done to each tracer here, and to means in
    `Theory._as_measured`: the two must say the same.
    """
    from particles import BoltzmannGrad, simulate

    law = layout.law
    times = point.true_times(layout.times)
    random = np.random.default_rng(SEED)
    tracers = _tracers_per_medium(point, float(layout.times[-1]), wanted)
    run = simulate(
        BoltzmannGrad(law.free_path(point.path), dimension=3 if law.dimension == 3 else 2),
        restitution=float(point.restitution),
        tangential_restitution=law.tangential_restitution,
        mass_ratio=law.mass_ratio,
        initial=_initial_velocities(point, law, tracers, random),
        times=times,
        media=N_MEDIA,
        tracers=tracers,
        seed=SEED,
        workers=1,
        observables=("positions", "velocities"),
    )
    place = point.length_unit * np.asarray(run.positions)
    velocity = point.speed_unit * np.asarray(run.velocities)
    n_at_rest = round(max(point.at_rest, 0.0) * place.shape[1])
    place[:, :n_at_rest] = 0.0
    velocity[:, :n_at_rest] = 0.0
    noise = np.sqrt(max(point.position_noise, 0.0)) * random.normal(size=place.shape)
    if has_velocities:
        noise[layout.times == 0.0] = 0.0
    elif layout.times[0] == 0.0:  # each position has an error, also the first
        noise = noise - noise[0]
    place = place + noise
    after_start = (layout.times > 0.0)[:, None, None]
    speed_noise = np.sqrt(max(point.velocity_noise, 0.0)) * random.normal(size=velocity.shape)
    velocity = velocity + speed_noise * after_start
    sums = _power_sums(layout, place, velocity)
    pair_sums = _pair_sums(layout, place)
    if layout.presence is not None:
        _leave_gaps(layout, layout.presence, has_velocities, sums, pair_sums, random)
    return sums, pair_sums


def _leave_gaps(
    layout: Layout,
    presence: NDArray[np.bool_],
    has_velocities: bool,
    sums: Array,
    pair_sums: Array | None,
    random: np.random.Generator,
) -> None:
    """Set the sums of tracers to 0 where they are not there, each as some tracer of the data.

    Means with gaps are of other tracers at each time, and less correlated than those of all. Of
    positions alone, averages over time are displacements from the first frame.
    """
    pattern = presence[random.integers(0, len(presence), len(sums))]
    over_time = pattern
    if not has_velocities:
        over_time = pattern & pattern[:, :1]
    sums *= over_time[:, :, None]
    if pair_sums is not None and layout.pairs is not None:
        is_there = pattern[:, layout.pairs.earlier] & pattern[:, layout.pairs.later]
        pair_sums *= is_there[:, :, None]


def _initial_velocities(point: Point, law: Law, tracers: int, random: np.random.Generator) -> Array:
    """Return the velocities of the start, shape (N_MEDIA, tracers, d).

    Speeds are quantiles of their distribution, evenly spaced in probability, and only directions
    are random: so the moments of the start, on whose fast tail fourth moments hang, are right.
    """
    shape = (N_MEDIA, tracers, law.dimension)
    n = N_MEDIA * tracers
    probability = (np.arange(n) + 0.5) / n
    if isinstance(point.start, SampledStart):
        bins = point.start.bins
        below = np.cumsum(bins.counts) / bins.counts.sum()
        squares = bins.squares[np.searchsorted(below, probability)]
    elif point.start == "gaussian":
        squares = 2.0 * gammaincinv(law.dimension / 2.0, probability)
    else:
        squares = np.ones(n)
    speed = random.permutation(np.sqrt(squares)).reshape(shape[:2])
    direction = random.normal(size=shape)
    if point.starts_along_x:
        direction[...] = np.eye(law.dimension)[0]
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    return np.asarray(speed[..., None] * direction)


def _power_sums(layout: Layout, place: Array, velocity: Array) -> Array:
    """Return powers as the sums of a `Sample` have them, (n, n_times, n_sums)."""
    v2 = np.sum(velocity**2, axis=-1)
    r2 = np.sum(place**2, axis=-1)
    powers = [np.ones_like(v2), v2, v2**2, r2, r2**2]
    if "drift" in layout.names:
        for axis in range(layout.law.dimension):
            x = place[..., axis]
            powers += [velocity[..., axis], x, x**2]
        assert len(powers) == VX + 3 * layout.law.dimension
    return np.moveaxis(np.array(powers), 0, -1).swapaxes(0, 1)


def _pair_sums(layout: Layout, place: Array) -> Array | None:
    """Return the number and |dr|^2 of each tracer and pair of frames, (n, n_pairs, 2)."""
    if layout.pairs is None:
        return None
    step = place[layout.pairs.later] - place[layout.pairs.earlier]
    square = np.sum(step**2, axis=-1).T
    return np.stack([np.ones_like(square), square], axis=-1)

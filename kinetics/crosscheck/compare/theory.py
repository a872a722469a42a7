"""What is compared (OBSERVABLES), and what the kinetic equation says of it at a Point."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics import Scene, Solution, solve
from kinetics.crosscheck.data.sample import R2, R4, V2, V4, VX, X2, Law, N, Sample, StartBins, X
from kinetics.errors import ToleranceWarning
from kinetics.states.kinds import Beam
from kinetics.states.state import LogMeasure, State

Array = NDArray[np.float64]

SPEED, DISPLACEMENT = "speed_density", "position_density"
BEAM = Beam()  # all tracers start with the velocity U along x


class Observable(NamedTuple):
    """How an observable is written (title, symbol, unit, in a text), how it is measured from means
    m over tracers (None: a density), where it is compared ("field", "free" or "both"; "along": in
    a field and from a beam), the output of a Solution, if of another name, and its component.

    power: x^power, or ln x for 0, has an error that hardly depends on x (x is 1 + a2 for a2).
    own_error: standard deviation of simulations from the theory of hard disks, of x (of v0 for the
    drift) and divided by n = rho d^2, from .1 to 30 l/U and from then on; of v0 and <r^2> among
    overlapping disks twice that: tests/kinetics/measurements/density.py, rounded up.
    """

    title: str
    symbol: str
    unit: str
    short: str
    measured: Callable[[Any, Law], Any] | None = None
    where: str = "free"
    output: str = ""
    component: tuple[int, ...] = ()
    power: int | None = None
    own_error: tuple[float, float] = (0.0, 0.0)


OBSERVABLES = {name: Observable(*words) for name, *words in (
    ("drift", "Mean velocity along x", r"$\langle v_x\rangle$", "U", "⟨v_x⟩",
     lambda m, law: m[VX], "along", "mean_velocity", (0,), None, (0.05, 0.05)),
    ("thermal_speed", "Thermal speed", "$v_0$", "U", "v₀",
     lambda m, law: np.sqrt(m[V2]), "both", "", (), 0, (0.03, 0.02)),
    ("a2", "Second Sonine coefficient", "$a_2$", "", "1 + a₂",
     lambda m, law: m[V4] / (law.gaussian * m[V2] ** 2) - 1, "free", "", (), -3, (0.08, 0.15)),
    ("msd", "Mean square displacement", r"$\langle r^2\rangle$", "d²", "⟨r²⟩",
     lambda m, law: m[R2], "free", "", (), 0, (0.05, 0.04)),
    ("kurtosis", "Kurtosis of the displacement", r"$\langle r^4\rangle/\langle r^2\rangle^2$", "",
     "⟨r⁴⟩/⟨r²⟩²", lambda m, law: m[R4] / m[R2] ** 2, "free", "", (), -3, (0.12, 0.1)),
    ("mean_displacement", "Mean displacement along x", r"$\langle x\rangle$", "d", "⟨x⟩",
     lambda m, law: m[X], "along", "", (0,), None, (0.2, 0.2)),
    ("dispersion_parallel", "Variance along the field", "var $x$", "d²", "var x",
     lambda m, law: m[X2] - m[X] ** 2, "field", "displacement_tensor", (0, 0)),
    ("dispersion_perpendicular", "Variance across the field", "var $y$", "d²", "var y",
     # across the field the mean is 0
     lambda m, law: (m[R2] - m[X2]) / (law.dimension - 1), "field",
     "displacement_tensor", (1, 1)),
    (SPEED, "Speed density", "speed $v$", "U", "mean over a bin"),
    (DISPLACEMENT, "Displacement density", "displacement $r$", "d", "mean over a bin"),
)}  # fmt: skip
"""Everything that is compared, in the order of the page: a new average is one row."""


def averages_of(law: Law, start: Any = "gaussian") -> tuple[str, ...]:
    """The averages that are compared under a law: of driven tracers without the kurtosis."""
    where = {"both", "field" if law.field else "free"}
    where |= {"along"} if law.field or start == BEAM else set()
    every = [k for k, x in OBSERVABLES.items() if x.measured and x.where in where]
    if law.capture_speed:  # places are not those of all that move
        every = [k for k in every if k in ("drift", "thermal_speed", "a2")]
    return tuple(k for k in every if k != "kurtosis" or not law.is_driven)


@dataclass(frozen=True, eq=False)
class SampledStart(State):
    """The speeds of a sample at time 0, as it has them: isotropic."""

    bins: StartBins

    def harmonic(self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0) -> Any:
        """One point per bin."""
        if m:
            return None
        counts = self.bins.counts
        return LogMeasure(0.5 * np.log(self.bins.squares), counts / counts.sum())


class Point(NamedTuple):
    """Every number that a theory of data has; a cause of a difference is another value of some.

    restitution, start, scatterers: as in a Scene; path: 1/(2 d rho) in d, among dense ones too;
    units: U, d/U and d of the data in what was told; at_rest: share of the tracers that never move;
    time_offset: in d/U, of the data's clock behind the true one; noise: variance of a component, in
    U^2 and d^2.
    """

    restitution: Any
    path: float
    start: Any
    scatterers: str = "dilute"
    speed_unit: float = 1.0
    time_unit: float = 1.0
    length_unit: float = 1.0
    at_rest: float = 0.0
    time_offset: float = 0.0
    velocity_noise: float = 0.0
    position_noise: float = 0.0

    @property
    def own_start(self) -> bool:
        """Whether the theory starts from the speeds of the sample at time 0."""
        return isinstance(self.start, SampledStart)

    @property
    def start_in_words(self) -> str:
        """The start as the middle of a sentence."""
        if self.own_start:
            return "the data's own speeds at time 0"
        named = {"gaussian": "a Gaussian start", "monoenergetic": "a start with all speeds U"}
        return named.get(self.start, "a beam along x" if self.start == BEAM else str(self.start))


def spread_of_ratio(fourth: Array, sixth: Array, eighth: Array) -> Array:
    """N times the variance of <x^4>/<x^2>^2 of N samples, from moments in units of <x^2>."""
    return eighth - fourth**2 - 4 * fourth * (sixth - fourth) + 4 * fourth**2 * (fourth - 1)


class Expectation:
    """What is measured of a sample, values (n_names, n_times) of all of it and replicates (G, ...)
    with each group left out; and what is expected. exchanged: which components are, in words.
    """

    def __init__(self, sample: Sample, names: Sequence[str]) -> None:
        self.sample, self.names, self.exchanged = sample, tuple(names), ""
        self._solved: dict[Any, tuple[Array, Solution]] = {}
        total = sample.sums.sum(axis=0)
        made: Any = [OBSERVABLES[name].measured for name in names]
        with np.errstate(invalid="ignore", divide="ignore"):
            self.values, self.replicates = (
                np.stack([measured(means, sample.law) for measured in made], axis=-2)
                for sums in (total, total - sample.sums)
                for means in [np.moveaxis(sums / sums[..., N, None], -1, 0)]
            )

    def with_exchanged(self, axis: int, columns: Sequence[int], what: str) -> "Expectation":
        """The same of tracers whose x and another axis, 1 or 2, are exchanged in these sums."""
        order = np.arange(self.sample.sums.shape[2])
        for x in columns:
            order[[x, x + 3 * axis]] = x + 3 * axis, x
        made = Expectation(replace(self.sample, sums=self.sample.sums[..., order]), self.names)
        made.exchanged, made._solved = f"x and {'xyz'[axis]} of the {what}", self._solved
        return made

    def solved(
        self, point: Point, times: Array, names: Sequence[str], rtol: float = 0.0
    ) -> Solution:
        """The solution that has these observables; rtol 0 is that of averages."""
        law = self.sample.law
        scene = Scene(
            restitution=point.restitution, number_density=law.free_path(point.path),
            initial=point.start, times=times, scatterers=point.scatterers,
            outputs=tuple(dict.fromkeys(OBSERVABLES[name].output or name for name in names)),
            **{name: value for name, value in vars(law).items() if name != "restitution"},
        )  # fmt: skip
        with warnings.catch_warnings():  # those who ask look at the status
            warnings.simplefilter("ignore", ToleranceWarning)
            return solve(scene, rtol=rtol or law.rtol)

    def theory(self, point: Point) -> Array:
        """Theory (n_names, n_times)."""
        values = self._answer(point)[0]
        told = point[4:8] == (1.0, 1.0, 1.0, 0.0) and point[9:] == (0.0, 0.0)
        return values if told else self._measured(values, point)

    def _answer(self, point: Point) -> tuple[Array, Solution]:
        """The theory of the motion, in what was told."""
        # units of length, noise and tracers at rest change no motion: these are solved once
        clock, times = point.speed_unit / point.time_unit, self.sample.times
        key = (*point[:2], id(point.start), point.scatterers, clock, point.time_offset)
        if key not in self._solved:
            times = np.maximum(times * clock + point.time_offset * (times > 0), 0.0)
            solution = self.solved(point, times, self.names)
            rows: Any = [(name, OBSERVABLES[name]) for name in self.names]
            self._solved[key] = np.stack([
                np.asarray(getattr(solution, row.output or name))[(..., *row.component)]
                for name, row in rows
            ]), solution  # fmt: skip
        return self._solved[key]

    def exact(self, point: Point) -> NDArray[np.bool_]:
        """Where an average has no scatter in theory: of elastic tracers that have one speed."""
        if isinstance(point.start, SampledStart):
            has_one_speed = point.start.bins.squares.size == 1
        else:
            has_one_speed = point.start in ("monoenergetic", BEAM)
        law = self.sample.law
        conserves_speed = point.restitution == 1.0 and law.tangential_restitution == 1.0
        conserves_speed &= not law.field and not law.is_driven
        unchanged = point.at_rest == 0.0 and point.velocity_noise == 0.0
        of_speed = np.isin(self.names, ("thermal_speed", "a2"))[:, None]
        shape = (len(self.names), self.sample.times.size)
        return np.broadcast_to(of_speed & has_one_speed & conserves_speed & unchanged, shape)

    def spread_of_a2(self, point: Point) -> Array | None:
        """N times the variance (n_times,) of a2 of N independent tracers; None where unknown."""
        law = self.sample.law
        if law.field or law.is_driven or "a2" not in self.names:
            return None
        moment = self._answer(point)[1].moment
        parts = (moment(p) / moment(2.0) ** (p / 2) for p in (4.0, 6.0, 8.0))
        return np.asarray(spread_of_ratio(*parts) / law.gaussian**2)

    def _measured(self, values: Array, point: Point) -> Array:
        """The same as data in other units, with noise or with tracers at rest have them."""
        law, left, changed = self.sample.law, 1 - point.at_rest, values.copy()
        d, after = law.dimension, self.sample.times > 0
        of_v, of_r = point.velocity_noise * after, point.position_noise * after
        for name, unit in (("drift", point.speed_unit), ("mean_displacement", point.length_unit)):
            if name in self.names:
                changed[self.names.index(name)] *= left * unit
        for second, fourth, ratio, power, unit, noise in (
            ("thermal_speed", "a2", law.gaussian, 2, point.speed_unit, of_v),
            ("msd", "kurtosis", 1.0, 1, point.length_unit, of_r),
        ):
            at = self.names.index(second)
            square = values[at] ** power
            moved = left * unit**2 * square + d * noise
            changed[at] = moved ** (1 / power)
            if fourth in self.names:
                at, one = self.names.index(fourth), float(second == "thermal_speed")
                quartic = left * unit**4 * ratio * (values[at] + one) * square**2
                quartic += (2 * (d + 2) * left * unit**2 * square + d * (d + 2) * noise) * noise
                still = np.where(moved > 0, moved, np.inf)
                changed[at] = np.where(moved > 0, quartic / (ratio * still**2) - one, values[at])
        return changed

    def stabilised(self, theory: Array, difference: Array) -> Array:
        """Differences (..., n_names, n_times) of functions whose errors hardly depend on the value,
        over their slope at the theory: see `Observable`.
        """
        found = difference.copy()
        for k, name in enumerate(self.names):
            if (power := OBSERVABLES[name].power) is not None:
                x = theory[k] + (name == "a2")
                with np.errstate(divide="ignore", invalid="ignore"):
                    logs = np.log1p(difference[..., k, :] / x)
                    moved = x * (np.expm1(power * logs) / power if power else logs)
                # a replicate in which all is at rest has none of these: it stays
                found[..., k, :] = np.where(np.isfinite(moved), moved, difference[..., k, :])
        return found

    def own_covariance(self, point: Point, theory: Array) -> Array | None:
        """Covariance of the theory's own error, (p, p) for p = n_names n_times flat averages. None
        for dilute scatterers. Of v0 and <r^2> it is one error, of the collision rate.
        """
        if point.scatterers == "dilute":
            return None
        times, names = self.sample.times, self.names
        late = times >= 30 * point.path
        share = np.array([np.where(late, *OBSERVABLES[name].own_error[::-1]) for name in names])
        size = np.abs(theory + np.array([name == "a2" for name in names])[:, None])
        if "drift" in names:
            size[names.index("drift")] = theory[names.index("thermal_speed")]
        pair = [names.index(x) for x in ("thermal_speed", "msd")]
        if point.scatterers == "overlapping":
            share[pair] *= 2
        begun = -np.expm1(-10 * times / point.path)  # nothing before there are collisions
        error = (share * size * begun / (2 * point.path)).ravel()
        # smooth over 0.4 of a decade of time, as simulations have it
        logs = np.log10(np.where(times > 0, times, 1.0))
        correlation = np.exp(-3 * (logs[:, None] - logs) ** 2)
        between = np.eye(len(names))
        between[pair, pair[::-1]] = 0.9
        return np.asarray(np.kron(between, correlation) * np.outer(error, error))

"""What the kinetic equation says about a sample: averages over time, and shares of bins."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.comparison.sample import (
    R2,
    R4,
    V2,
    V4,
    VX,
    X2,
    Law,
    N,
    Sample,
    StartBins,
    X,
)
from kinetics.errors import InputError
from kinetics.numerics.gauss import panels_between
from kinetics.states.quadrature import LogMeasure
from kinetics.states.state import State

if TYPE_CHECKING:
    from kinetics import Solution

Array = NDArray[np.float64]

RTOL = 1e-7
"""Asked of the solver for averages: far below any standard error."""
DENSITY_RTOL = 1e-6
"""Asked of the solver for densities."""
DISPLACEMENT_RTOL = 1e-4
"""Asked of the solver for densities of the displacement, which cost more."""
AVERAGES = ("thermal_speed", "a2", "msd", "kurtosis")
"""The averages that are compared."""
FIELD_RTOL = 1e-5
"""Asked of the solver in a field, where it takes longer."""
IN_FIELD = {
    "drift": ("mean_velocity", (0,)),
    "thermal_speed": ("thermal_speed", ()),
    "mean_displacement": ("mean_displacement", (0,)),
    "dispersion_parallel": ("displacement_tensor", (0, 0)),
    "dispersion_perpendicular": ("displacement_tensor", (1, 1)),
}
"""The averages that are compared in a field, along +x: the output of a Scene, and the component."""
SPEED, DISPLACEMENT = "speed_density", "position_density"


@dataclass(frozen=True, eq=False)
class SampledStart(State):
    """The speeds of a sample at time 0, as it has them: isotropic."""

    bins: StartBins

    def harmonic(
        self, m: int, rtol: float, lowest: float = 0.0, highest: float = 2.0
    ) -> LogMeasure | None:
        """One point per bin."""
        if m:
            return None
        counts = self.bins.counts
        return LogMeasure(0.5 * np.log(self.bins.squares), counts / counts.sum())


class System(NamedTuple):
    """What is solved: restitution, mean free path in d, initial state, and the rest of the law.

    scatterers : as in a Scene. Among others than "dilute" ones free_path is still 1/(2 d rho), from
        which their density n = d/(2 free_path) follows with their diameter d.
    """

    restitution: float
    free_path: float
    start: Any
    law: Law = Law()
    scatterers: str = "dilute"
    diameter: float = 1.0


def solved(system: System, times: Array, outputs: Sequence[str], rtol: float) -> "Solution":
    """The solution of a scene with a mean free path instead of a density."""
    from kinetics import Scene, solve

    law = system.law
    scene = Scene(
        restitution=system.restitution,
        number_density=law.free_path(system.free_path) / system.diameter,
        diameter=system.diameter,
        initial=system.start,
        times=times,
        outputs=tuple(outputs),
        tangential_restitution=law.tangential_restitution,
        dimension=law.dimension,
        scatterers=system.scatterers,
        field=law.field,
    )
    return solve(scene, rtol=rtol)


def solved_averages(system: System, times: Array, names: Sequence[str]) -> "Solution":
    """The solution that has these averages, see `average_of`."""
    if not system.law.field:
        return solved(system, times, names, RTOL)
    outputs = tuple(dict.fromkeys(IN_FIELD[name][0] for name in names))
    return solved(system, times, outputs, FIELD_RTOL)


def names_for(law: Law) -> tuple[str, ...]:
    """The averages that are compared."""
    return tuple(IN_FIELD) if law.field else AVERAGES


def average_of(solution: "Solution", name: str) -> Array:
    """An average over time, (n_times,), by its name here."""
    output, component = IN_FIELD[name] if solution.scene.field else (name, ())
    place: Any = (..., *component)
    return np.asarray(np.asarray(getattr(solution, output))[place])


def system_of(solution: "Solution") -> System:
    """What a solution is of; InputError for a law without coefficients of restitution."""
    scene = solution.scene
    if scene.tangential_restitution is None:
        raise InputError("solution: its law has no coefficients of restitution to compare with")
    law = Law(scene.tangential_restitution, scene.dimension, scene.field)
    return System(scene.restitution, scene.mean_free_path, scene.initial, law)


def observed(
    sums: Array, speed_scale: Any, length_scale: Any, names: Sequence[str], law: Law
) -> Array:
    """The averages of sums (..., n_times, 5), one after another: (..., len(names), n_times).

    In units of U and d; the scales (n_times,) are those of the sums.
    """
    if not names:
        return np.empty((*sums.shape[:-2], 0, sums.shape[-2]))
    with np.errstate(invalid="ignore", divide="ignore"):
        n, v2, v4, r2, r4 = (sums[..., k] for k in (N, V2, V4, R2, R4))
        values = {
            "drift": lambda: speed_scale * sums[..., VX] / n,
            "mean_displacement": lambda: length_scale * sums[..., X] / n,
            "dispersion_parallel": lambda: (
                length_scale**2 * (sums[..., X2] / n - (sums[..., X] / n) ** 2)
            ),
            # Across the field the mean is 0.
            "dispersion_perpendicular": lambda: (
                length_scale**2 * (r2 - sums[..., X2]) / n / (law.dimension - 1)
            ),
            "thermal_speed": lambda: speed_scale * np.sqrt(v2 / n),
            "a2": lambda: v4 * n / (law.gaussian * v2**2) - 1,
            "msd": lambda: length_scale**2 * r2 / n,
            "kurtosis": lambda: r4 * n / r2**2,
        }
        return np.stack([values[name]() for name in names], axis=-2)


class Expectation:
    """What is expected of a sample: of all of it, and with each group left out.

    With a start of its own (a name, a density) the theory is the same for every group. With the
    sample's own start it moves with the sample: each group's theory starts from its speeds.
    """

    def __init__(self, sample: Sample, names: Sequence[str]) -> None:
        self.sample, self.names = sample, tuple(names)
        total, scales = sample.sums.sum(axis=0), (sample.speed_scale, sample.length_scale)
        law = sample.law
        self.values = observed(total, *scales, names, law)
        with np.errstate(invalid="ignore"):
            self.replicates = observed(total - sample.sums, *scales, names, law)
        self._last: tuple[System, tuple[Array, Array]] | None = None

    def theory(
        self, restitution: float, free_path: float, initial: Any, scatterers: str = "dilute",
        diameter: float = 1.0,
    ) -> tuple[Array, Array]:  # fmt: skip
        """Theory (n_names, n_times), and with groups left out: that shape or (G, ...).

        The arguments are those of `System`.
        """
        law = self.sample.law
        system = System(restitution, free_path, initial, law, scatterers, diameter)
        if self._last is None or self._last[0] != system:
            if isinstance(initial, SampledStart):
                found = self._from_start(system._replace(start="monoenergetic"))
            else:
                solution = solved_averages(system, self.sample.times, self.names)
                values = np.stack([average_of(solution, name) for name in self.names])
                found = values, values
            self._last = (system, found)
        return self._last[1]

    def _from_start(self, system: System) -> tuple[Array, Array]:
        """A tracer of speed v does at time t what one of speed 1 does at v t, times v.

        system: with the start "monoenergetic".
        """
        assert self.sample.start is not None
        start, times = self.sample.start, self.sample.times
        moments = _one_speed(system, self.names, np.sqrt(start.squares)[:, None] * times)
        # Within a bin <v^4> is not <v^2>^2: what is exact at time 0 stays so before collisions.
        v2, flatness = start.squares[:, None], start.flatness[:, None]
        powers: dict[int, Any] = {V2: v2, V4: flatness * v2**2, R2: 1.0, R4: flatness}
        kernel = np.stack([moments[k] * powers[k] for k in (V2, V4, R2, R4)], axis=-1)
        total = start.counts

        def averaged(weights: Array) -> Array:
            sums = np.empty((*weights.shape[:-1], times.size, 5))
            sums[..., 1:] = np.tensordot(weights, kernel, axes=(-1, 0))
            sums[..., N] = weights.sum(axis=-1)[..., None]
            return observed(sums, 1.0, 1.0, self.names, self.sample.law)

        return averaged(total.astype(float)), averaged((total - start.by_group).astype(float))


def _one_speed(system: System, names: Sequence[str], times: Array) -> dict[int, Array]:
    """<v^2>, <v^4>, <r^2>, <r^4> from speed 1 at any times: arrays of the shape of `times`."""
    flat, back = np.unique(times, return_inverse=True)
    wanted = ["thermal_speed", "a2", "msd", *(("kurtosis",) if "kurtosis" in names else ())]
    found = solved(system, flat, wanted, RTOL)
    v2, r2 = found.thermal_speed**2, found.msd
    v4 = system.law.gaussian * (1 + found.a2) * v2**2
    r4 = np.zeros(flat.size)
    if "kurtosis" in names:
        r4 = np.where(r2 > 0, found.kurtosis, 0.0) * r2**2
    moments = {V2: v2, V4: v4, R2: r2, R4: r4}
    return {k: m[back].reshape(times.shape) for k, m in moments.items()}


def bin_shares(solution: "Solution", name: str, index: int, edges: Array) -> Array:
    """Share of the tracers below the first edge, in each bin, and above: (n_edges + 1,).

    Of the speed or of the displacement at the time of this index. Speeds by Gauss-Legendre in each
    bin, finer where the start is rough; what is above the last edge is the rest.
    """
    every = np.concatenate([[0.0], edges])
    if name == DISPLACEMENT:
        shares = solution.position_fraction(every)[index]
        return np.append(shares, max(1 - shares.sum(), 0.0))
    pieces = 1 if solution.scene.state.smooth else 12
    fine = np.interp(np.arange(pieces * (every.size - 1) + 1) / pieces, range(every.size), every)
    x, weight = panels_between(fine, 3)
    each = (solution.speed_density(x)[index] * weight).reshape(-1, 3).sum(axis=1)
    shares = np.maximum(each, 0.0).reshape(-1, pieces).sum(axis=1)
    peak = float(solution.uncollided[index])
    if peak > 0:  # tracers of a start with one speed that have not collided
        speed = float(getattr(solution.scene.state, "speed", 1.0))
        shares[min(np.searchsorted(every, speed, side="right"), shares.size) - 1] += peak
    return np.append(shares, max(1 - shares.sum(), 0.0))

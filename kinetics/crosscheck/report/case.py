"""What the methods give for one restitution, as plain arrays, before anything is compared."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics import CollisionLaw, ScaledVDF, ScalingSolution, Solution

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: Array
    error: Array

    def __truediv__(self, scale: float | Array) -> "Measured":
        return Measured(self.value / scale, self.error / scale)

    def __mul__(self, factor: float | Array) -> "Measured":
        return Measured(factor * self.value, factor * self.error)

    def __getitem__(self, where: Any) -> "Measured":
        return Measured(np.asarray(self.value[where]), np.asarray(self.error[where]))

    @staticmethod
    def joined(parts: Iterable[Any]) -> "Measured":
        """Several estimates of one shape as one, along a new first axis."""
        known = list(parts)
        return Measured(np.array([p.value for p in known]), np.array([p.error for p in known]))


@dataclass(frozen=True)
class ParticleRun:
    """What one simulation gives; lengths in d, speeds in U, times in d/U.

    The averages over time have shape (n_times,); slopes and the free path (); the densities
    (n_bins,) and are those of the last time, scaled with the run's own v0 and <r^2>.
    """

    name: str  # "Boltzmann-Grad", "hard disks" or "hard spheres"
    samples: int  # tracers
    groups: int  # independent groups of tracers, behind the errors
    thermal_speed: Measured
    a2: Measured
    msd: Measured
    kurtosis: Measured  # <r^4>/<r^2>^2
    cooling_rate: Measured  # h from 1/v0 at two of the times
    msd_slope: Measured  # d<r^2>/d ln t between the same two times, in d^2
    free_path: Measured  # path travelled over collisions
    vdf: Measured  # F(c) averaged over the bins of c = v/v0, a density in the plane or in space
    position: Measured  # G(R) averaged over the bins of R = r/sqrt(<r^2>), a density over R
    # local exponent of p = G(R)/(2 pi R), or G(R)/(4 pi R^2), at `observables.band_middles`
    tail_exponent: Measured
    mean_collisions: float  # per tracer, until the last time
    most_collisions: int
    above_cap: float  # fraction of tracers with more collisions than the paper's cap
    statuses: dict[str, int]  # how many tracers ended in each way


@dataclass(frozen=True)
class Case:
    """What every method gives for one restitution."""

    restitution: float
    law: CollisionLaw
    times: Array  # of the output of particles and equation, in d/U
    early: int  # index of the time from which on slopes are measured, a tenth of the last
    speed_edges: Array  # bins of c
    position_edges: Array  # bins of R
    exact: ScalingSolution | None  # the scaling state in closed form; None if elastic
    scaled: ScaledVDF | None  # and as solved
    kinetic: Solution  # with the l of the dilute limit, 1/(2 d rho0) or 1/(pi d^2 rho0)
    rescaled: Solution  # with the mean free path that the run of hard scatterers measured
    late: Solution  # as `kinetic`, to times that no simulation reaches, without densities
    position: Solution  # the displacement at the last time, as accurate as a figure needs
    free: ParticleRun  # Boltzmann-Grad
    hard: ParticleRun  # hard disks, or hard spheres
    # standard errors of these minus `rescaled`, both of which change with the run
    rescaled_errors: dict[str, Array]
    # the equation of hard disks at their own density; None where there is none
    dense: Solution | None = None
    dense_slope: float | None = None  # its limit of d<r^2>/d ln t, in d^2

    @property
    def runs(self) -> tuple[ParticleRun, ParticleRun]:
        """Both simulations, Boltzmann-Grad first."""
        return self.free, self.hard

    @property
    def dimension(self) -> int:
        """2 for disks, 3 for spheres."""
        return self.law.dimension

    @property
    def scaling_state(self) -> tuple[ScalingSolution, ScaledVDF]:
        """The scaling state in closed form and as solved; the law must not be elastic."""
        assert self.exact is not None
        assert self.scaled is not None
        return self.exact, self.scaled

    @property
    def late_msd_slope(self) -> float:
        """The exact limit of d<r^2>/d ln t, in d^2; the law must not be elastic."""
        return self.scaling_state[0].diffusion_slope * self.late.scene.mean_free_path**2


@dataclass(frozen=True)
class DensityScan:
    """Hard disks of one restitution at several densities, at the same d rho0 t.

    By observable: `ratios` of the particles to the kinetic equation, shape (n_densities,); `fits`,
    weighted polynomials in the density (coefficients, lowest power first); and `limits`, their
    values at density 0, shape (): 1 if the kinetic equation is the dilute limit.
    """

    restitution: float
    densities: Array
    samples: int
    degree: int
    ratios: dict[str, Measured]
    fits: dict[str, Array]
    limits: dict[str, Measured]


@dataclass(frozen=True)
class TrapScan:
    """Share of hard-disk tracers caught in corners by `time`, for each density and restitution.

    `share` has shape (n_densities, n_restitutions) and a jackknife error over configurations.
    """

    time: float
    restitutions: Array
    densities: Array
    samples: int
    share: Measured


@dataclass(frozen=True)
class Scans:
    """Simulations in which one parameter of the system is varied."""

    density: DensityScan
    traps: TrapScan

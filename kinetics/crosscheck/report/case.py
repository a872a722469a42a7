"""What the methods give for one restitution, as plain arrays, before anything is compared."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kinetics import ScaledVDF, ScalingSolution, Solution

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: Array
    error: Array

    def __truediv__(self, scale: float) -> "Measured":
        return Measured(self.value / scale, self.error / scale)

    def __mul__(self, factor: float) -> "Measured":
        return Measured(factor * self.value, factor * self.error)

    def __getitem__(self, where: Any) -> "Measured":
        return Measured(np.asarray(self.value[where]), np.asarray(self.error[where]))


@dataclass(frozen=True)
class ParticleRun:
    """What one simulation gives, times first; lengths in d, speeds in U, times in d/U.

    Attributes
    ----------
    name : "Boltzmann-Grad" or "hard disks"
    samples : number of tracers; groups : number of independent groups behind the errors
    thermal_speed, a2, msd, kurtosis : shape (n_times,); kurtosis is <r^4>/<r^2>^2
    cooling_rate : h from 1/v0 at two of the times, shape ()
    msd_slope : d<r^2>/d ln t between the same two times, in d^2, shape ()
    free_path : path travelled over collisions, shape ()
    vdf : F(c) averaged over the bins `speed_edges` of c = v/v0, shape (n_bins,), at the last time,
        v0 being the run's own; a density in the plane
    position : G(R) averaged over `position_edges` of R = r/sqrt(<r^2>), shape (n_bins,), at the
        last time; a density over R
    tail_exponent : local exponent of G(R)/(2 pi R) between bands of R, at the last time, shape
        as of `histograms.band_middles`
    mean_collisions, most_collisions : per tracer, until the last time
    above_cap : fraction of tracers with more collisions than the paper's cap
    statuses : how many tracers ended in each way
    """

    name: str
    samples: int
    groups: int
    thermal_speed: Measured
    a2: Measured
    msd: Measured
    kurtosis: Measured
    cooling_rate: Measured
    msd_slope: Measured
    free_path: Measured
    vdf: Measured
    position: Measured
    tail_exponent: Measured
    mean_collisions: float
    most_collisions: int
    above_cap: float
    statuses: dict[str, int]


@dataclass(frozen=True)
class Case:
    """What every method gives for one restitution.

    Attributes
    ----------
    times : output times of particles and equation, in d/U; early : index of the time from which on
        slopes are measured, a tenth of the last
    speed_edges, position_edges : bins of c and of R, see `ParticleRun`
    exact, scaled : closed form and solver's scaling state; None at e = 1, where there is none
    kinetic : the kinetic equation with l = 1/(2 d rho0)
    rescaled : the same with the mean free path that the hard-disk run measured
    late : the same as `kinetic`, to times that no simulation reaches, without densities
    position : the displacement density at the last time, as accurate as a figure needs
    free, disks : the Boltzmann-Grad particles, and hard disks
    rescaled_errors : standard errors of hard disks minus `rescaled`, both of which change with the
        run: by observable, of the shape of the observable in `disks`
    """

    restitution: float
    times: Array
    early: int
    speed_edges: Array
    position_edges: Array
    exact: "ScalingSolution | None"
    scaled: "ScaledVDF | None"
    kinetic: "Solution"
    rescaled: "Solution"
    late: "Solution"
    position: "Solution"
    free: ParticleRun
    disks: ParticleRun
    rescaled_errors: dict[str, Array]

    @property
    def runs(self) -> tuple[ParticleRun, ParticleRun]:
        """Both simulations, Boltzmann-Grad first."""
        return self.free, self.disks

    @property
    def scaling_state(self) -> "tuple[ScalingSolution, ScaledVDF]":
        """The scaling state in closed form and as solved; e must be below 1."""
        assert self.exact is not None
        assert self.scaled is not None
        return self.exact, self.scaled

    @property
    def late_msd_slope(self) -> float:
        """The exact limit of d<r^2>/d ln t, in d^2; e must be below 1."""
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

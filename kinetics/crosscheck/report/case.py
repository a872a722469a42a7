"""What the witnesses say about one restitution, as plain arrays: no judgement yet."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kinetics import ScaledVDF, ScalingSolution, Solution

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """An estimate with its standard error, of the same shape; NaN where nothing was measured."""

    value: Array
    error: Array


@dataclass(frozen=True)
class ParticleEvidence:
    """What one particle run says, times first; lengths in d, speeds in U, times in d/U.

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
    """Every witness on one restitution.

    `kinetic` is the time-dependent solution with l = 1/(2 d rho0); `rescaled` the same with the
    free path that the hard-disk run measured. Of that comparison, `rescaled_errors` holds the
    standard errors of data minus theory, both of which move with the run: by observable, of the
    shape of `disks`'. `late` goes on to times that no simulation reaches, without densities;
    `position` has the displacement density at the last time, to the accuracy that a figure needs.
    `exact` and `scaled` are None at e = 1, where there is no scaling state.
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
    free: ParticleEvidence
    disks: ParticleEvidence
    rescaled_errors: dict[str, Array]


@dataclass(frozen=True)
class DensityScan:
    """Hard disks of one restitution at several densities, at the same d rho0 t, over the equation.

    `ratios` holds, by observable, data over the dilute theory, shape (n_densities,), and `limits`
    the value at rho0 d^2 = 0 of the weighted polynomials `fits` (coefficients, lowest first), shape
    (): 1 if the theory is the dilute limit.
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
    """What particles say where a parameter of the system is varied."""

    density: DensityScan
    traps: TrapScan

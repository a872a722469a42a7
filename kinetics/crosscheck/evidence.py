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
    thermal_speed, a2, msd : shape (n_times,)
    cooling_rate : h from 1/v0 at two of the times, shape ()
    free_path : path travelled over collisions, shape ()
    vdf : F(c) averaged over the bins `speed_edges` of c = v/v0, shape (n_bins,), at the last time,
        v0 being the run's own; a density in the plane
    position : G(R) averaged over `position_edges` of R = r/sqrt(<r^2>), shape (n_bins,), at the
        last time; a density over R
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
    cooling_rate: Measured
    free_path: Measured
    vdf: Measured
    position: Measured
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
    shape of `disks`'. `exact` and `scaled` are None at e = 1, where there is no scaling state.
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
    free: ParticleEvidence
    disks: ParticleEvidence
    rescaled_errors: dict[str, Array]

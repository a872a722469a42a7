"""The finite density of the scatterers as a hypothesis: where it is known, and its own error.

The theory is that of kinetics/collision/medium.py, in which a tracer meets scatterers again. It is
not exact: simulations deviate from it by OWN_ERROR times the density n, and from large data the
averages are known better than that. So this error is added to the covariance of the data.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinetics.collision.medium import HIGHEST_DENSITY, SETTLED, TESTED_DENSITY
from kinetics.crosscheck.comparison.data_and_theory import DataAndTheory
from kinetics.crosscheck.comparison.fit import SECOND_MOMENTS
from kinetics.crosscheck.comparison.result import said

if TYPE_CHECKING:
    from kinetics import Scene

Array = NDArray[np.float64]

WORDS = {"hard disks": "hard disks that do not overlap", "overlapping": "overlapping disks"}
"""The media that are tried, as in a Scene, and in words."""
OWN_ERROR = {
    "thermal_speed": (0.1, 0.2),
    "a2": (0.3, 0.3),
    "msd": (0.8, 0.2),
    "kurtosis": (0.35, 0.2),
}
"""Standard deviation of simulations from the theory, relative (to 1 + a2 for a2) and divided by
n = rho d^2: before SETTLED, and from then on. Root mean squares over n = .04 and .1, six e from
0.25 to 1 and both media (tests/kinetics/measurements/density_error.py), rounded up. Before SETTLED
<r^2> deviates more the larger e is, from .2 n at e = .25 to 1.2 n at e = 1."""
_REMEMBERED = np.log(10.0)
"""In ln t: errors at two times are correlated by exp(-|ln(t/t')|/ln 10)."""
_LEAST_RESTITUTION = 0.2
"""Below it the theory is of the leading order only, and its error was not measured."""


def density_of(scene: "Scene") -> float:
    """n = rho d^2."""
    return scene.number_density * scene.diameter**2


def is_known(both: DataAndTheory) -> bool:
    """Whether there is a theory at the density of the scatterers.

    Of smooth disks in the plane at a density that is told (not fitted to the same data); not of
    particles that are known to meet no scatterer again.
    """
    scene, law = both.solution.scene, both.sample.law
    if not both.density_told or both.sample.free or scene.scatterers != "dilute":
        return False
    tested = scene.restitution >= _LEAST_RESTITUTION and density_of(scene) <= HIGHEST_DENSITY
    return law.smooth_disks and tested


def covariance(both: DataAndTheory, theory: Array) -> Array:
    """Covariance of the theory's own error, (p, p) for p = n_names n_times flat averages.

    theory (n_names, n_times). Different averages are taken to be independent.
    """
    scene, times, names = both.solution.scene, both.sample.times, both.names
    late = times >= SETTLED * scene.mean_free_path
    share = np.array([np.where(late, OWN_ERROR[name][1], OWN_ERROR[name][0]) for name in names])
    size = np.abs(theory + np.array([name == "a2" for name in names])[:, None])
    error = np.where(times > 0, share * density_of(scene) * size, 0.0).ravel()
    logs = np.log(np.where(times > 0, times, 1.0))
    correlation = np.exp(-np.abs(logs[:, None] - logs) / _REMEMBERED)
    return np.asarray(np.kron(np.eye(len(names)), correlation) * np.outer(error, error))


def described(both: DataAndTheory, scatterers: str, theory: Array) -> str:
    """What the theory is, how much it changes the averages, and for which times it is trusted."""
    scene, times = both.solution.scene, both.sample.times
    settled = SETTLED * scene.mean_free_path
    changes = {
        name: theory[k, -1] / both.theory[k, -1] - 1
        for k, name in enumerate(both.names)
        if name in SECOND_MOMENTS
    }
    return said(
        "finite_density", words=WORDS[scatterers], changes=changes, density=density_of(scene),
        scatterers=scatterers, settled=settled, trusted=SETTLED, own=OWN_ERROR,
        early=int(np.sum((times > 0) & (times < settled))), times=int(np.sum(times > 0)),
        tested=TESTED_DENSITY,
    )  # fmt: skip

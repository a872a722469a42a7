r"""Integrals of the memory of a velocity over the path: J_m(p).

In the clock of the path length the geometry of a path does not depend on the speed, and what
decides on diffusion and cooling is

    J_m(p) = integral over x/l from 0 to X of <(v/v0)^p cos(m (phi - phi0))>,

v0 and phi0 being the speed and the direction at x = 0 and l = 1/(2 rho d). In the Boltzmann-Grad
limit it is (1 - exp(-lambda_m(p) X/l))/lambda_m(p), lambda_m(p) = 1 - E[s^p cos(m chi)]. In space
P_m(cos) takes the place of cos(m .) and l is 1/(pi rho d^2).

This is not an observable of `simulate`, whose tracers end at a time or after a number of
collisions: these averages need tracers that end at a path, or the slow ones would be missing.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from particles.arguments import check_workers, make_plan
from particles.checks import check_whole, real_array, refuse
from particles.configuration import ESCAPE_PATHS, Plan
from particles.estimators import Estimate, jackknife
from particles.media import BoltzmannGrad, ForgetfulPoisson, Medium, dilute_mean_path
from particles.memory import require_memory
from particles.results import Value

HIGHEST_ORDER = 1000
# What launches a tracer, whose number of collisions has no limit here.
_NO_LIMIT = 2**62


@dataclass(frozen=True, eq=False)
class PathIntegrals(Value):
    """Result of `path_integrals`. Paths and integrals are in the dilute mean free path l.

    powers (n_powers, 2): m and p of each integral. paths (n_paths,): where the integrals end.
    sums (media, n_paths, n_powers): of each configuration, integrals from one of the paths to the
    next over all windows. totals (media, 4): windows begun, path in l, collisions, trapped tracers.
    """

    medium: Medium
    restitution: float
    tangential_restitution: float
    powers: np.ndarray
    paths: np.ndarray
    sums: np.ndarray
    totals: np.ndarray

    def __repr__(self) -> str:
        lines = [
            f"PathIntegrals: {len(self.totals)} configurations of {self.medium!r}",
            f"  restitution {self.restitution:g}, {self.windows} windows of {self.paths[-1]:g} l, "
            f"{self.trapped} tracers trapped",
        ]
        values, errors = self.integrals.value[-1], self.integrals.error[-1]
        for (m, p), value, error in zip(self.powers, values, errors, strict=True):
            lines.append(f"  m = {m:g}, p = {p:g}: {value:.6g} +- {error:.2g}")
        return "\n".join(lines)

    @cached_property
    def integrals(self) -> Estimate:
        """J_m(p) from 0 to each of the paths, (n_paths, n_powers)."""
        return self._per_window(np.cumsum(self.sums, axis=1))

    @cached_property
    def last_part(self) -> Estimate:
        """The part of J_m(p) between the last two paths, (n_powers,): the whole with one path.

        What the end of the windows cuts off is not known; it is of this size or smaller where the
        integrand decays and the last two paths are about as far apart as it takes to decay.
        """
        return self._per_window(self.sums[:, -1])

    @cached_property
    def mean_free_path(self) -> Estimate:
        """Path travelled per collision, in l. A scalar."""
        return jackknife(self.totals, lambda t: t[1] / t[2])

    @property
    def windows(self) -> int:
        """Number of windows begun."""
        return int(self.totals[:, 0].sum())

    @property
    def trapped(self) -> int:
        """Tracers caught in a corner. The rest of their window adds 0, for p = 0 too."""
        return int(self.totals[:, 3].sum())

    def _per_window(self, sums: np.ndarray) -> Estimate:
        flat = sums.reshape(len(sums), -1)
        joined = np.column_stack([flat, self.totals[:, 0]])
        found = jackknife(joined, lambda t: t[:-1] / t[-1])
        shape = sums.shape[1:]
        return Estimate(found.value.reshape(shape), found.error.reshape(shape))


def path_integrals(
    medium: Medium,
    restitution: float,
    powers: Sequence[tuple[int, float]],
    paths: Sequence[float] | np.ndarray,
    windows: int = 10,
    settling: float = 10.0,
    media: int = 100,
    tracers: int = 100,
    seed: int = 1,
    workers: int | None = None,
    tangential_restitution: float = 1.0,
) -> PathIntegrals:
    """Measure J_m(p) along the paths of `tracers` tracers in each of `media` configurations.

    medium, restitution, tangential_restitution, media, tracers, seed, workers: as of `simulate`;
        the BoltzmannGrad limit in the plane only. Tracers start in random directions.
    powers: pairs (m, p), a whole number from 0 to 1000 and a real one from 0 on.
    paths (n_paths,): where the integrals end, in l, positive and increasing. A window is as long as
        the last one.
    windows: of each tracer, one after the other. Errors are the spread over configurations, so they
        hold although the windows of a tracer are not independent.
    settling: path in l before the first window. A start at a random place is stationary in elastic
        systems only: where the tracer cools, its later places are not distributed uniformly.

    Raises ValueError for bad input, and where `simulate` does.
    """
    plan = make_plan(
        medium, restitution, "monoenergetic", None, None, tangential_restitution,
        media=media, tracers=tracers, max_collisions=_NO_LIMIT, seed=seed,
    )  # fmt: skip
    if isinstance(medium, BoltzmannGrad) and medium.dimension == 3:
        refuse("medium", medium, "must be a BoltzmannGrad in the plane, or PoissonSpheres")
    asked, ends = _check_powers(powers), _check_paths(paths)
    each = check_whole("windows", windows, 1, 2**31)
    if not (isinstance(settling, (int, float)) and 0.0 <= settling <= ESCAPE_PATHS):
        refuse("settling", settling, f"must be a number from 0 to {ESCAPE_PATHS:g}")
    if settling + each * ends[-1] > ESCAPE_PATHS:
        allowed = f"all windows of a tracer must be no longer than {ESCAPE_PATHS:g} together"
        refuse("windows", windows, allowed)
    workers = check_workers(workers)
    require_memory(plan, workers)
    one = partial(_integrate, plan, asked, ends, float(settling), each)
    with ThreadPoolExecutor(min(workers, media)) as pool:
        found = list(pool.map(one, range(media)))
    return PathIntegrals(
        medium,
        plan.restitution,
        plan.tangential_restitution,
        asked,
        ends,
        np.array([sums for sums, _ in found]),
        np.array([totals for _, totals in found]),
    )


def _check_powers(powers: Sequence[tuple[int, float]]) -> np.ndarray:
    allowed = f"must be pairs (m, p), m a whole number from 0 to {HIGHEST_ORDER}, p from 0 on"
    array = real_array("powers", powers, allowed)
    if array.ndim != 2 or array.shape[1] != 2 or not len(array):
        refuse("powers", powers, allowed)
    m, p = array.T
    good = (m >= 0) & (m <= HIGHEST_ORDER) & (m == np.floor(m)) & (p >= 0) & np.isfinite(p)
    if not good.all():
        refuse("powers", powers, allowed)
    return array


def _check_paths(paths: Sequence[float] | np.ndarray) -> np.ndarray:
    array = real_array("paths", paths, "must be a sequence of numbers")
    if array.ndim != 1 or not array.size or not np.isfinite(array).all():
        refuse("paths", paths, "must be a sequence of at least one finite number")
    if array[0] <= 0.0 or (np.diff(array) <= 0.0).any():
        refuse("paths", paths, "must be positive and increase")
    return array


def _integrate(
    plan: Plan, powers: np.ndarray, paths: np.ndarray, settling: float, each: int,
    configuration: int,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the sums and the totals of one configuration, in l."""
    from particles.grid.build import build
    from particles.kernel import integrate, lane
    from particles.kernel.windows import PATH, TOTALS, Windows

    medium = plan.medium
    mean_path, dimension = dilute_mean_path(medium), medium.dimension
    seed = np.uint64(plan.seed)
    start = lane.Start(
        0, plan.tracers, np.empty((0, dimension)), True, seed, configuration,
        plan.restitution, plan.tangential_restitution, 0,
    )  # fmt: skip
    windows = Windows(
        times=np.empty(0),
        orders=powers[:, 0].astype(np.int64),
        powers=np.ascontiguousarray(powers[:, 1]),
        paths=paths * mean_path,
        settling=settling * mean_path,
        each=each,
        sums=np.zeros((paths.size, len(powers))),
        totals=np.zeros(TOTALS),
    )
    cells = build(medium, seed, configuration)
    if cells is None:
        k = medium.memory if isinstance(medium, ForgetfulPoisson) else 0
        known, lanes = np.empty((k, 4)), np.empty(1, lane.LANE_OF[2])
        integrate.integrate_remembering(start, mean_path, known, lanes, windows)
    else:
        lanes = np.empty(lane.LANES, lane.LANE_OF[dimension])
        integrate.integrate_among(start, cells, ESCAPE_PATHS * mean_path, lanes, windows)
    windows.totals[PATH] /= mean_path
    return windows.sums / mean_path, windows.totals

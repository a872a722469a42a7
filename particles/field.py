"""What an Ensemble has in a uniform field only: drift, dispersion and the averages behind them.

All of it is made from the sums `field_sums` (columns: `particles.kernel.columns`), with errors from
the spread over configurations, as of every estimate.
"""

from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np

from particles.configuration import Plan
from particles.estimators import Estimate, jackknife
from particles.kernel.columns import CAUGHT, SAMPLES
from particles.results import frozen


class FieldEstimates:
    """The estimates of a run in a field; without one, AttributeError. Time is the first axis."""

    plan: Plan
    arrays: Mapping[str, np.ndarray]

    @cached_property
    def drift(self) -> Estimate:
        """<v_x> in U, (n_times,): along the field if that is positive."""
        return self._estimate("drift", lambda m, s: s[:, 0] / m[:, SAMPLES])

    @cached_property
    def drift_of_moving(self) -> Estimate:
        """<v_x> of the tracers that are not trapped, in U, (n_times,); NaN where all are.

        Among disks ever more tracers come to rest, and `drift` goes to 0.
        """
        return self._estimate(
            "drift_of_moving",
            lambda m, s: s[:, 0] / (m[:, SAMPLES] - m[:, CAUGHT]),
        )

    @cached_property
    def trapped_fraction(self) -> Estimate:
        """Share of the tracers that are trapped or captured by each time, (n_times,)."""
        return jackknife(self.arrays["moments"], lambda m: m[:, CAUGHT] / m[:, SAMPLES])

    @cached_property
    def mean_velocity(self) -> Estimate:
        """<v> in U, (n_times, dimension)."""
        d = self.plan.medium.dimension
        return self._estimate("mean_velocity", lambda m, s: s[:, :d] / m[:, SAMPLES, None])

    @cached_property
    def velocity_tensor(self) -> Estimate:
        """<v_i v_j> in U^2, (n_times, dimension, dimension)."""
        return self._estimate("velocity_tensor", lambda m, s: self._averages(m, s, 0)[1])

    @cached_property
    def mean_displacement(self) -> Estimate:
        """<r> in d, (n_times, dimension): the displacement from the start."""
        found = self._estimate("mean_displacement", lambda m, s: self._averages(m, s, 1)[0])
        return found.divided(1.0 / self.plan.medium.diameter)

    @cached_property
    def dispersion(self) -> Estimate:
        """<r_i r_j> - <r_i> <r_j> in d^2, (n_times, dimension, dimension)."""
        found = self._estimate("dispersion", self._covariance)
        return found.divided(self.plan.medium.diameter**-2)

    @cached_property
    def dispersion_parallel(self) -> Estimate:
        """Variance of the displacement along the field in d^2, (n_times,): 2 D_parallel t, late."""
        found = self._estimate("dispersion_parallel", lambda m, s: self._covariance(m, s)[:, 0, 0])
        return found.divided(self.plan.medium.diameter**-2)

    @cached_property
    def dispersion_perpendicular(self) -> Estimate:
        """Variance of the displacement across the field in d^2, (n_times,).

        Of one direction, in space the mean of two: 2 D_perpendicular t at late times.
        """
        d = self.plan.medium.dimension
        found = self._estimate(
            "dispersion_perpendicular",
            lambda m, s: np.trace(self._covariance(m, s)[:, 1:, 1:], axis1=1, axis2=2) / (d - 1),
        )
        return found.divided(self.plan.medium.diameter**-2)

    @property
    def passage_times(self) -> np.ndarray:
        """When each tracer first had x = depth, in d/U, (media * tracers,); inf if it never had."""
        if "raw/passages" not in self.arrays:
            raise AttributeError("passages were not asked for: simulate(field=..., depth=...)")
        return frozen(self.arrays["raw/passages"] * self.plan.medium.diameter)

    @cached_property
    def passed(self) -> Estimate:
        """Share of the tracers that have reached the depth by each time, (n_times,)."""
        passages = self.passage_times.reshape(len(self.plan.configurations), 1, -1)
        counts = (passages <= self.plan.times[:, None]).sum(axis=2)
        sums = np.stack((counts, np.full(counts.shape, self.plan.tracers)))
        return jackknife(np.moveaxis(sums, 0, 1), lambda total: total[0] / total[1])

    @cached_property
    def mean_passage_time(self) -> Estimate:
        """Mean of `passage_times`, a scalar; infinite if one of the tracers never had x = depth."""
        times = self.passage_times.reshape(len(self.plan.configurations), -1)
        sums = np.stack((times.sum(axis=1), np.full(len(times), self.plan.tracers)), axis=1)
        return jackknife(sums, lambda total: total[0] / total[1])

    def _estimate(
        self, name: str, function: Callable[[np.ndarray, np.ndarray], np.ndarray]
    ) -> Estimate:
        """Return a function of the sums of moments and of the sums in the field."""
        if not self.plan.field:
            raise AttributeError(f"{name} is there in a field only: simulate(field=...)")
        moments = self.arrays["moments"]
        sums = np.concatenate([moments, self.arrays["field_sums"]], axis=2)
        n = moments.shape[2]
        return jackknife(sums, lambda total: function(total[:, :n], total[:, n:]))

    def _averages(
        self, moments: np.ndarray, sums: np.ndarray, which: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean of a vector and of its products; which: 0 the velocity, 1 the place."""
        d = self.plan.medium.dimension
        half = sums.shape[1] // 2
        means = sums[:, which * half : (which + 1) * half] / moments[:, SAMPLES, None]
        products = np.empty((len(sums), d, d))
        i, j = np.triu_indices(d)
        products[:, i, j] = products[:, j, i] = means[:, d:]
        return means[:, :d], products

    def _covariance(self, moments: np.ndarray, sums: np.ndarray) -> np.ndarray:
        mean, products = self._averages(moments, sums, 1)
        return products - mean[:, :, None] * mean[:, None, :]

"""The sums of a run as its configurations come in, and how they become an Ensemble."""

import numpy as np

from particles.configuration import RAW, Plan, Tally
from particles.ensemble import Ensemble
from particles.kernel.columns import HISTOGRAMS, MOMENTS, STATUSES, TOTALS, TRAPS


class Totals:
    """Tallies of configurations 0, 1, ... added up in this order."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.configurations = 0
        self._moments = np.zeros((plan.media, plan.times.size, MOMENTS))
        self._path_sums = np.zeros((plan.media, TOTALS))
        self._statuses = np.zeros(STATUSES, np.int64)
        self._traps: list[np.ndarray] = [np.empty((0, 1 + TRAPS))]
        self._histograms: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._raw: dict[str, list[np.ndarray]] = {n: [] for n in RAW if n in plan.observables}

    def add(self, tally: Tally) -> None:
        """Add the next configuration's tally."""
        c = self.configurations
        if tally.configuration != c:
            raise RuntimeError(f"tally of configuration {tally.configuration} came before {c}")
        self._moments[c] = tally.moments
        self._path_sums[c] = tally.totals
        self._statuses += tally.statuses
        self._traps.append(np.insert(tally.traps, 0, c, axis=1))
        for name, counts in tally.histograms.items():
            if name not in self._histograms:
                shape = counts.shape
                self._histograms[name] = (
                    np.zeros((3, *shape), np.int64),
                    np.zeros((2, shape[0]), np.int64),
                )
            sums, samples = self._histograms[name]
            m = counts.sum(axis=1)
            sums += np.stack((counts, counts * counts, counts * m[:, None]))
            samples += np.stack((m, m * m))
        for name, pieces in self._raw.items():
            pieces.append(tally.raw[name])
        self.configurations += 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Return everything added so far, by name; not copies."""
        done = self.configurations
        arrays = {
            "moments": self._moments[:done],
            "path_sums": self._path_sums[:done],
            "statuses": self._statuses,
            "traps": np.concatenate(self._traps),
        }
        for name, (sums, samples) in self._histograms.items():
            arrays[f"histograms/{name}/sums"] = sums
            arrays[f"histograms/{name}/samples"] = samples
        for name, pieces in self._raw.items():
            if pieces:
                arrays[f"raw/{name}"] = np.concatenate(pieces, axis=0 if name == "finals" else 1)
        return arrays

    @classmethod
    def restore(cls, plan: Plan, arrays: dict[str, np.ndarray]) -> "Totals":
        """Return totals as they were when `arrays` were taken of them."""
        totals = cls(plan)
        totals.configurations = done = len(arrays["moments"])
        totals._moments[:done] = arrays["moments"]
        totals._path_sums[:done] = arrays["path_sums"]
        totals._statuses[:] = arrays["statuses"]
        totals._traps = [arrays["traps"]]
        for name in HISTOGRAMS:
            if f"histograms/{name}/sums" in arrays:
                totals._histograms[name] = (
                    arrays[f"histograms/{name}/sums"],
                    arrays[f"histograms/{name}/samples"],
                )
        for name in totals._raw:
            if f"raw/{name}" in arrays:
                totals._raw[name] = [arrays[f"raw/{name}"]]
        return totals

    def ensemble(self) -> Ensemble:
        """Return the result once every configuration has been added."""
        return Ensemble(self.plan, self.arrays())

"""The sums of a run as its configurations come in: what an Ensemble is made of."""

import numpy as np

from particles.configuration import Plan, Tally, trap_columns
from particles.kernel.columns import FIELD_SUMS, MOMENTS, STATUSES, TOTALS

# Whose first axis is that of the tracers; the others begin with the times.
_FIRST = ("traps", "raw/finals", "raw/passages")


class Totals:
    """Tallies of configurations 0, 1, ... added up in this order."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.configurations = 0
        # By their names in a file: one row for each configuration, sums over configurations, and
        # pieces that are joined.
        self._rows = {
            "moments": np.zeros((plan.media, plan.times.size, MOMENTS)),
            "path_sums": np.zeros((plan.media, TOTALS)),
        }
        if plan.field:
            columns = FIELD_SUMS[plan.medium.dimension]
            self._rows["field_sums"] = np.zeros((plan.media, plan.times.size, columns))
        self._sums = {"statuses": np.zeros(STATUSES, np.int64)}
        self._pieces = {"traps": [np.empty((0, 1 + trap_columns(plan.medium)))]}

    def add(self, tally: Tally) -> None:
        """Add the next configuration's tally."""
        c = self.configurations
        if tally.configuration != c:
            raise RuntimeError(f"tally of configuration {tally.configuration} came before {c}")
        self._rows["moments"][c] = tally.moments
        self._rows["path_sums"][c] = tally.totals
        if self.plan.field:
            self._rows["field_sums"][c] = tally.field_sums
        sums = {"statuses": tally.statuses}
        for name, counts in tally.histograms.items():
            m = counts.sum(axis=1)
            products = np.stack((counts, counts * counts, counts * m[:, None]))
            sums[f"histograms/{name}/sums"] = products
            sums[f"histograms/{name}/samples"] = np.stack((m, m * m))
        for name, array in sums.items():
            self._sums[name] = self._sums.get(name, 0) + array
        self._pieces["traps"].append(np.insert(tally.traps, 0, c, axis=1))
        for name, array in tally.raw.items():
            self._pieces.setdefault(f"raw/{name}", []).append(array)
        self.configurations += 1

    def arrays(self) -> dict[str, np.ndarray]:
        """Return everything added so far, by its name in a file; rows and sums are not copied."""
        rows = {name: array[: self.configurations] for name, array in self._rows.items()}
        joined = {
            name: np.concatenate(pieces, axis=0 if name in _FIRST else 1)
            for name, pieces in self._pieces.items()
        }
        return rows | self._sums | joined

    @classmethod
    def restore(cls, plan: Plan, arrays: dict[str, np.ndarray]) -> "Totals":
        """Return totals as they were when `arrays` were taken of them."""
        totals = cls(plan)
        totals.configurations = len(arrays["moments"])
        for name, array in arrays.items():
            if name in totals._rows:
                totals._rows[name][: totals.configurations] = array
            elif name == "traps" or name.startswith("raw/"):
                totals._pieces[name] = [array]
            else:
                totals._sums[name] = array
        return totals

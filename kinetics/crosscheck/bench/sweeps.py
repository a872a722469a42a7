"""Sweeps: one method on one problem for many values of a setting. All are timed in turns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinetics.crosscheck.bench.record import Record, failed, timed
from kinetics.crosscheck.bench.timing import Effort, Timing, measure_together


@dataclass(frozen=True)
class Sweep:
    """What is to be measured.

    Attributes
    ----------
    section, problem, method, setting : as of the rows, see `Record`
    values : of the setting; None where it has none
    work : solves the problem at a value
    error : of what the work gives; None where only the time counts
    seeded : the work is random and takes a seed after the value. Every call gets its own, and the
        error of the row is the root mean square over all of them
    """

    section: str
    problem: str
    method: str
    setting: str
    values: Sequence[float | None]
    work: Callable[..., Any]
    error: Callable[[Any], float] | None = None
    seeded: bool = False


# of random work, for an rms that shows how it falls: 11 calls give it to about a sixth
_SEEDED_LEAST = {True: 5, False: 10}


class _Row:
    """One value of a sweep."""

    def __init__(self, sweep: Sweep, value: float | None) -> None:
        self.sweep = sweep
        self.value = value
        self.calls = 0
        self.errors: list[float] = []
        self.bad = ""

    def work(self) -> Any:
        self.calls += 1
        seed = (self.calls,) if self.sweep.seeded else ()
        return self.sweep.work(self.value, *seed)

    def keep(self, result: Any) -> None:
        """The error of a result; work that is not random has the same one in every call."""
        if self.sweep.error is None or (self.errors and not self.sweep.seeded):
            return
        error = self.sweep.error(result)
        self.errors.append(error)
        if not math.isfinite(error) and not self.bad:
            found = np.concatenate([np.ravel(x) for x in np.atleast_1d(result)])
            count = int(np.sum(~np.isfinite(found)))
            self.bad = f"{count} of {found.size} values are no finite number"

    def record(self, timing: Timing | Exception) -> Record:
        sweep = self.sweep
        row = (sweep.section, sweep.problem, sweep.method)
        value = None if self.value is None else float(self.value)
        where: dict[str, Any] = {"setting": sweep.setting, "value": value}
        if sweep.setting == "rtol":
            where["asked"] = value
        if isinstance(timing, Exception):  # whatever it is, it is a row and not the end of the run
            return failed(*row, timing, **where)
        if self.bad:
            return failed(*row, self.bad, seconds=timing.cpu[1], **where)
        if self.errors:
            where["error"] = math.sqrt(sum(x * x for x in self.errors) / len(self.errors))
        if sweep.seeded:
            where["extra"] = {"seeds": len(self.errors)}
        return timed(*row, timing, **where)


def run_sweeps(sweeps: Iterable[Sweep], effort: Effort) -> list[Record]:
    """A row per value of each sweep, in their order; what fails is a row too."""
    rows = [_Row(sweep, value) for sweep in sweeps for value in sweep.values]
    timings = measure_together(
        {k: row.work for k, row in enumerate(rows)},
        effort,
        lambda k, result: rows[k].keep(result),
        {k: _SEEDED_LEAST[effort.quick] for k, row in enumerate(rows) if row.sweep.seeded},
    )
    return [row.record(timings[k]) for k, row in enumerate(rows)]

"""One benchmark against an earlier one: ratios, and what got slower by more than the spread."""

from __future__ import annotations

import statistics
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinetics.crosscheck.bench.record import MEASURED, Record
from kinetics.errors import InputError

if TYPE_CHECKING:
    from kinetics.crosscheck.bench.report import BenchReport

SLOWER, FASTER, SAME = "slower", "faster", ""
WORSE, FIXED, BROKEN, GONE, NEW = "less accurate", "works now", "fails now", "gone", "new"
_ERROR_GREW = 10.0  # below it the error of a random method may change by itself
_ERROR_FLOOR = 1e-13  # rounding
# From run to run more changes than among the repeats of one. Measured: three quick runs of the same
# code while three processes wanted each core; of 2166 pairs of times 0.9 % were marked slower, and
# 80 % of them where a factor 1.5 was put in. With less scatter more is seen: see the tests.
_BETWEEN_RUNS = 1.25
_FEW = 3  # repeats below which there is no spread to speak of,
_UNKNOWN_SPREAD = 0.25  # and this is taken for it, relative
_BUSY = 1.15  # wall-clock over processor time of one thread, when others want the processor
_LONG_ENOUGH = 0.01  # s, for others to get at it


@dataclass(frozen=True)
class Change:
    """One row in both runs.

    Attributes
    ----------
    row : of the new run; of the old one if it is gone
    ratio : new time over old, in units of the yardstick of each where both have one; None where
        one of them has no time
    mark : what happened, empty if nothing beyond the spread
    """

    row: Record
    ratio: float | None
    mark: str


@dataclass(frozen=True)
class Comparison:
    """All rows of two runs; `markdown` gives those that are marked first.

    Attributes
    ----------
    changes : one for each row
    same_machine : processor and versions are the same
    yardstick : the new time of the yardstick over the old, None where not measured
    busy : others wanted the processor in one of the runs: wall-clock times are not judged
    """

    changes: tuple[Change, ...]
    same_machine: bool
    yardstick: float | None = None
    busy: bool = False

    def marked(self, *marks: str) -> list[Change]:
        """The rows with one of these marks; with any mark if none is named."""
        wanted = set(marks)
        return [c for c in self.changes if (wanted & set(c.mark.split(", ")) if marks else c.mark)]

    def markdown(self) -> str:
        """A table of the marked rows, and the median ratio of each section."""
        lines = ["## Compared with the earlier run", ""]
        if not self.same_machine:
            lines += ["The earlier run was made on another machine or with other versions.", ""]
        if self.yardstick is not None:
            lines += [
                f"The yardstick took {self.yardstick:.2f} times as long as in the earlier run; "
                "ratios are of times in units of it.",
                "",
            ]
        if self.busy:
            lines += [
                "Others wanted the processor: what is measured by the wall clock is not marked.",
                "",
            ]
        lines += ["| section | rows | median new/old |", "|---|---|---|"]
        for section in dict.fromkeys(c.row.section for c in self.changes):
            ratios = [c.ratio for c in self.changes if c.row.section == section and c.ratio]
            middle = f"{statistics.median(ratios):.2f}" if ratios else "-"
            lines.append(f"| {section} | {len(ratios)} | {middle} |")
        marked = self.marked()
        lines += ["", f"{len(marked)} of {len(self.changes)} rows are marked.", ""]
        if marked:
            lines += ["| problem | method | setting | new/old | mark |", "|---|---|---|---|---|"]
        for change in marked:
            row = change.row
            value = "" if row.value is None else f" = {row.value:g}"
            ratio = "-" if change.ratio is None else f"{change.ratio:.2f}"
            threads = "" if row.threads == 1 else f", {row.threads} threads"
            lines.append(
                f"| {row.problem} | {row.method}{threads} | {row.setting}{value} | {ratio} "
                f"| {change.mark} |"
            )
        return "\n".join([*lines, ""])


def check_comparable(quick: bool, old: BenchReport) -> None:
    """InputError unless a run that is quick, or not, can be held against the old one."""
    if quick != old.quick:
        kinds = {True: "a quick run", False: "a full run"}
        raise InputError(
            f"compare: the earlier run is {kinds[old.quick]}, this one is {kinds[quick]}; "
            "their work is not the same"
        )


def compare_bench(new: BenchReport, old: BenchReport) -> Comparison:
    """Every row of either run; slower means that the quartiles of the two do not overlap, and that
    both the medians and the shortest times differ by a factor 1.25 at least.

    Raises InputError if one run is quick and the other is not: their work is not the same.
    """
    check_comparable(new.quick, old)
    before = {r.key: r for r in old.records}
    after = {r.key: r for r in new.records}
    busy = _busy(new) or _busy(old)
    changes = [_change(row, before.get(key), busy) for key, row in after.items()]
    if old.cases == new.cases:
        changes += [Change(row, None, GONE) for key, row in before.items() if key not in after]
    kept = ("processor", "python", "numpy", "scipy", "numba")
    same = all(new.machine.get(k) == old.machine.get(k) for k in kept)
    pairs = [(after[key], before[key]) for key in after if key in before]
    units = [a.yardstick / b.yardstick for a, b in pairs if a.yardstick and b.yardstick]
    return Comparison(tuple(changes), same, statistics.median(units) if units else None, busy)


def _wall_clock(row: Record) -> bool:
    return row.seconds is not None and row.seconds == row.wall


def _busy(report: BenchReport) -> bool:
    shares = [
        r.wall / r.seconds
        for r in report.records
        if r.wall and r.seconds and r.seconds > _LONG_ENOUGH and not _wall_clock(r)
    ]
    return bool(shares) and statistics.median(shares) > _BUSY


def _change(new: Record, old: Record | None, busy: bool) -> Change:
    if old is None:
        return Change(new, None, NEW)
    unit = new.yardstick / old.yardstick if new.yardstick and old.yardstick else 1.0
    ratio = new.seconds / old.seconds / unit if new.seconds and old.seconds else None
    if (new.status == MEASURED) != (old.status == MEASURED):
        return Change(new, ratio, FIXED if new.status == MEASURED else BROKEN)
    grew = (
        new.error is not None
        and old.error is not None
        and new.error > _ERROR_GREW * max(old.error, _ERROR_FLOOR)
        and (new.asked is None or new.error > new.asked)
    )
    marks = [WORSE] if grew else []
    if ratio is not None and not (busy and _wall_clock(new)):
        (new_low, new_high), (old_low, old_high) = _quartiles(new), _quartiles(old)
        # what others on the machine disturb least
        shortest = new.least / old.least / unit if new.least and old.least else ratio
        if new_low > old_high * unit and min(ratio, shortest) > _BETWEEN_RUNS:
            marks.append(SLOWER)
        elif new_high < old_low * unit and max(ratio, shortest) < 1.0 / _BETWEEN_RUNS:
            marks.append(FASTER)
    return Change(new, ratio, ", ".join(marks))


def _quartiles(row: Record) -> tuple[float, float]:
    seconds = row.seconds or 0.0
    if row.low is None or row.high is None or row.repeats < _FEW:
        return seconds * (1.0 - _UNKNOWN_SPREAD), seconds * (1.0 + _UNKNOWN_SPREAD)
    return row.low, row.high

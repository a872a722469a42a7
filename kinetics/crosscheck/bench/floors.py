"""The slowest pieces of work: what their time is spent on, and the least that it could be.

The least is a count of what cannot be left out, each at the rate at which this machine does nothing
but that, measured in the same run: the floor. How far the run time is above it is what is left for
housekeeping, for Python and for caches.
"""

from __future__ import annotations

import cProfile
import pstats
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.bench import floor_counts
from kinetics.crosscheck.bench.floor_counts import Counts
from kinetics.crosscheck.bench.markdown import digits, seconds_text, table
from kinetics.crosscheck.bench.rates import RATES
from kinetics.crosscheck.bench.record import MEASURED, Record, failed, timed
from kinetics.crosscheck.bench.timing import Effort, measure

SECTION = "floors"
_SHOWN = 0.05  # share of the time from which a function is named
_NAMED = 4


@dataclass(frozen=True)
class Piece:
    """One piece of work.

    Attributes
    ----------
    name : of the problem
    method : who does it
    work : does it, and returns what `counts` needs
    counts : (what, how many, name of a rate) of all that cannot be left out
    compiled : a profile of Python functions would show nothing
    """

    name: str
    method: str
    work: Callable[[], Any]
    counts: Callable[[Any], Counts]
    compiled: bool = False


def floors(effort: Effort) -> list[Record]:
    """A row for each piece of work, with its floor, their ratio and its profile in `extra`."""
    rows = []
    for piece in pieces(effort):
        try:
            rows.append(_row(piece, effort))
        except Exception as met:  # whatever it is, it is a row
            why = f"{type(met).__name__}: {met}"
            rows.append(failed(SECTION, piece.name, piece.method, why))
    return rows


def _row(piece: Piece, effort: Effort) -> Record:
    result, timing = measure(piece.work, effort)
    counted: list[dict[str, Any]] = []
    for what, number, rate in piece.counts(result):
        seconds = number / RATES.per_second(rate)
        counted.append({"what": what, "number": number, "rate": rate, "seconds": seconds})
    floor = float(sum(part["seconds"] for part in counted))
    extra = {
        "floor": floor,
        "ratio": timing.cpu.median / floor,
        "counted": counted,
        "profile": [] if piece.compiled else profile(piece.work),
    }
    return timed(SECTION, piece.name, piece.method, timing, extra=extra)


def profile(work: Callable[[], Any]) -> list[tuple[str, float]]:
    """The functions that most of the time is spent in, themselves, and their shares of it."""
    recorder = cProfile.Profile()
    recorder.runcall(work)
    # entries: (file, line, name) -> (calls, primitive calls, own time, with callees, callers)
    entries = pstats.Stats(recorder).stats.items()  # type: ignore[attr-defined]
    own: dict[str, float] = {}
    for (file, _, name), (_, _, seconds, _, _) in entries:
        label = name.strip("<>") if file == "~" else f"{Path(file).stem}.{name}"
        own[label] = own.get(label, 0.0) + seconds
    whole = sum(own.values())
    most = sorted(own.items(), key=lambda item: -item[1])[:_NAMED]
    return [(label, t / whole) for label, t in most if t >= _SHOWN * whole]


def pieces(effort: Effort) -> Iterator[Piece]:
    """The five slowest kinds of work, each at a size where it is slow."""
    from kinetics import Gaussian, Scene, solve
    from kinetics.crosscheck.bench.methods import NUMBER_DENSITY, SPECTRAL

    def scene(e: float, times: Any, *outputs: str, **others: Any) -> Any:
        return Scene(e, NUMBER_DENSITY, times=times, outputs=outputs, **others)

    many = np.geomspace(0.1, 1e8, 10_000)
    averages = scene(0.7, many, "msd", "kurtosis")
    yield Piece(
        "⟨r²⟩ and kurtosis at 10 000 times, e = 0.7",
        SPECTRAL,
        lambda: solve(averages),
        lambda solution: floor_counts.averages(solution, many),
    )
    if effort.quick:
        return
    for t, late in ((300.0, "t = 300"), (1.0, "t = 1, before most collide")):
        distribution = scene(0.6, [t], "position_density")
        yield Piece(
            f"G(R), e = 0.6, {late}",
            SPECTRAL,
            lambda distribution=distribution: solve(distribution, 1e-5),  # type: ignore[misc]
            floor_counts.waves,
        )
    harmonics = scene(0.7, [10.0, 100.0], "velocity_density", initial=Gaussian(2.0, 1.0),
                      harmonics=32)  # fmt: skip
    yield Piece(
        "velocity density, 17 harmonics, e = 0.7",
        SPECTRAL,
        lambda: solve(harmonics, 1e-8),
        floor_counts.densities,
    )
    density = scene(0.99, np.geomspace(1.0, 1e4, 256), "speed_density")
    yield Piece(
        "speed density at 256 times, e = 0.99",
        SPECTRAL,
        lambda: solve(density, 1e-8),
        lambda solution: floor_counts.densities(solution, turned=True),
    )
    yield Piece(
        "2 million collisions among 10 000 hard disks",
        "particles",
        floor_counts.fly,
        floor_counts.flights,
        compiled=True,
    )


def lines(records: Iterable[Record]) -> Iterator[str]:
    """The table of these rows, in Markdown."""
    rows = []
    for row in records:
        if row.section != SECTION or row.status != MEASURED:
            continue
        spent = ", ".join(f"{name} {share:.0%}" for name, share in row.extra["profile"])
        kinds: dict[tuple[str, str], tuple[float, float]] = {}
        for part in row.extra["counted"]:
            kind = part["what"], part["rate"].partition(" of ")[0]
            number, seconds = kinds.get(kind, (0.0, 0.0))
            kinds[kind] = number + part["number"], seconds + part["seconds"]
        counted = "; ".join(
            f"{number:.2g} {rate} ({what}): {seconds_text(seconds)}"
            for (what, rate), (number, seconds) in kinds.items()
        )
        rows.append(
            [
                row.problem,
                seconds_text(row.seconds),
                spent or "one compiled loop",
                counted,
                seconds_text(row.extra["floor"]),
                digits(row.extra["ratio"]),
            ]
        )
    if rows:
        yield "## The slowest pieces of work and their floors"
        yield ""
        yield (
            "Counted is what cannot be left out, each at the rate at which this machine does "
            "nothing but that; their sum is the floor. Functions are named with the share of the "
            "time that is spent in themselves."
        )
        yield ""
        yield from table(["work", "run time", "spent on", "counted", "floor", "ratio"], rows)

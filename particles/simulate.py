"""simulate(): from a medium and a start to an Ensemble."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from particles.configuration import OBSERVABLES, Plan, Tally, forget, run_configurations
from particles.ensemble import Ensemble
from particles.media import Medium, Positions
from particles.totals import Totals

if TYPE_CHECKING:
    from particles.storage.saving import Saver

LARGEST_TIME = 1e300  # in d/U; the largest double is 1.8e308
SMALLEST_SPEED = 1e-150  # in U; the square of it, and of its inverse, is a number


def simulate(
    medium: Medium,
    restitution: float,
    initial: Literal["gaussian", "monoenergetic"] | np.ndarray = "gaussian",
    times: Sequence[float] | np.ndarray | None = None,
    media: int = 100,
    tracers: int = 100,
    max_collisions: int | None = None,
    seed: int = 1,
    workers: int | None = None,
    executor: Executor | None = None,
    observables: Iterable[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
    output: str | PathLike[str] | None = None,
    resume: bool = False,
) -> Ensemble:
    """Follow `tracers` tracers in each of `media` configurations of a medium.

    medium: HardDisks, Poisson, BoltzmannGrad or Positions. restitution in [0, 1].
    initial: "gaussian" (each component of standard deviation U), "monoenergetic" (speed U) or an
        array (tracers, 2) or (media, tracers, 2) of velocities in U.
    times (n_times,): output times in d/U, not negative, increasing, at most 1e300. A tracer ends at
        the last one, or after max_collisions collisions if that comes first. Without times,
        max_collisions is needed.
    seed: a whole number from 0 to 2**64 - 1. The result depends on it alone, bit for bit, and not
        on workers or executor.
    workers: threads; all processors if None. executor: any concurrent.futures.Executor to run on
        instead (a process pool, a Dask client's get_executor()).
    observables: names out of `particles.OBSERVABLES`; the scalar ones if None.
    progress: called as progress(done, total), in configurations, from the calling thread.

    output: file that the run is saved to (layout: storage.file). Each configuration is saved
        when it is done, whole or not at all, in `<output>.journal` (storage.journal) until the
        file itself is written again, beside it and renamed; the run may be killed at any moment.
        The file must not exist unless resume is True; then the run goes on from it, to the same
        bits as one that was never stopped.

    Raises ValueError for bad input, where the disks cannot be placed, and for an output that
    exists (without resume), is damaged, in use, or holds another run; it is left as it was.
    """
    whole = dict(media=media, tracers=tracers, max_collisions=max_collisions, seed=seed)
    plan = make_plan(medium, restitution, initial, times, observables, **whole)
    workers = check_workers(workers)
    if output is None:
        if resume:
            raise ValueError("resume = True: needs output, the file to go on from")
        return _complete(Totals(plan), None, workers, executor, progress).ensemble()
    from particles.storage.saving import Saver

    saver = Saver(output, plan)
    totals = saver.begin(resume)
    try:
        _complete(totals, saver, workers, executor, progress)
    except BaseException:
        saver.stop()
        raise
    saver.finish(totals)
    return totals.ensemble()


def _complete(
    totals: Totals, saver: "Saver | None", workers: int, executor: Executor | None,
    progress: Callable[[int, int], None] | None,
) -> Totals:  # fmt: skip
    """Run the configurations that the totals lack; add, save and report each one."""
    plan = totals.plan
    if progress is not None:
        progress(totals.configurations, plan.media)
    for tally in run(plan, range(totals.configurations, plan.media), workers, executor):
        totals.add(tally)
        if saver is not None:
            saver.add(tally, totals)
        if progress is not None:
            progress(totals.configurations, plan.media)
    return totals


def check_workers(workers: int | None) -> int:
    """Return the number of threads to use."""
    if workers is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    if isinstance(workers, bool) or not isinstance(workers, (int, np.integer)) or workers < 1:
        raise ValueError(f"workers = {workers!r}: must be a positive whole number")
    return int(workers)


def make_plan(
    medium: Medium, restitution: float, initial: Any, times: Any,
    observables: Iterable[str] | None, **whole: int | None,
) -> Plan:  # fmt: skip
    """Check every argument of `simulate` and return what is to be run.

    whole: media, tracers, max_collisions and seed. Raises ValueError for what is not allowed.
    """
    if not isinstance(medium, Medium):
        raise ValueError(
            f"medium = {medium!r}: must be HardDisks, Poisson, BoltzmannGrad or Positions"
        )
    if not (isinstance(restitution, (int, float)) and 0.0 <= restitution <= 1.0):
        raise ValueError(f"restitution = {restitution!r}: must be a number from 0 to 1")
    media, tracers = (_check_whole(name, whole[name], 1, 2**31) for name in ("media", "tracers"))
    if isinstance(medium, Positions) and medium.sets not in (None, media):
        raise ValueError(f"media = {media}: must be {medium.sets}, the sets of positions given")
    seed = _check_whole("seed", whole["seed"], 0, 2**64 - 1)
    most = whole["max_collisions"]
    if most is None and times is None:
        raise ValueError("times = None: give output times, or max_collisions, or both")
    return Plan(
        medium=medium,
        restitution=float(restitution),
        monoenergetic=isinstance(initial, str) and initial == "monoenergetic",
        velocities=_check_initial(initial, media, tracers),
        times=_check_times(times),
        media=media,
        tracers=tracers,
        max_collisions=None if most is None else _check_whole("max_collisions", most, 1, 2**62),
        seed=seed,
        observables=_check_observables(observables),
    )


def _check_whole(name: str, value: Any, low: int, high: int) -> int:
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or not low <= value <= high:
        raise ValueError(f"{name} = {value!r}: must be a whole number from {low} to {high}")
    return int(value)


def _check_times(times: Any) -> np.ndarray:
    if times is None:
        return np.empty(0)
    try:
        array = np.array(times, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"times = {times!r}: must be a sequence of numbers") from None
    if array.ndim != 1 or array.size == 0:
        raise ValueError(f"times = {times!r}: must be a sequence of at least one time")
    if not (np.isfinite(array).all() and array[0] >= 0 and array[-1] <= LARGEST_TIME):
        raise ValueError(
            f"times = {times!r}: must be finite, not negative, at most {LARGEST_TIME:g}"
        )
    if (np.diff(array) <= 0).any():
        raise ValueError(f"times = {times!r}: must increase")
    return array


def _check_initial(initial: Any, media: int, tracers: int) -> np.ndarray | None:
    if isinstance(initial, str):
        if initial not in ("gaussian", "monoenergetic"):
            raise ValueError(
                f"initial = {initial!r}: must be 'gaussian', 'monoenergetic' or velocities"
            )
        return None
    try:
        velocities = np.array(initial, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError("initial: must be a name or an array of velocities") from None
    if velocities.shape not in ((tracers, 2), (media, tracers, 2)):
        raise ValueError(
            f"initial of shape {velocities.shape}: velocities must be of shape (tracers, 2) = "
            f"({tracers}, 2) or (media, tracers, 2) = ({media}, {tracers}, 2)"
        )
    speeds = np.hypot(velocities[..., 0], velocities[..., 1])
    good = (speeds >= SMALLEST_SPEED) & (speeds <= 1.0 / SMALLEST_SPEED)
    if not good.all():
        raise ValueError(
            f"initial holds the velocity {velocities[~good][0]}: its size must be from "
            f"{SMALLEST_SPEED:g} to {1.0 / SMALLEST_SPEED:g}"
        )
    return velocities


def _check_observables(observables: Iterable[str] | None) -> frozenset[str]:
    if observables is None:
        return frozenset()
    names = frozenset([observables] if isinstance(observables, str) else observables)
    for name in sorted(names - set(OBSERVABLES), key=str):
        raise ValueError(f"observables: no {name!r}; there are {', '.join(OBSERVABLES)}")
    return names


def run(plan: Plan, which: range, workers: int, executor: Executor | None) -> Iterator[Tally]:
    """Yield the tallies of these configurations in order, whatever order they are done in."""
    if executor is None and (workers == 1 or len(which) == 1):
        try:
            for c in which:
                yield from run_configurations(plan, c, c + 1)
        finally:
            forget()
        return
    if executor is not None:
        # Few and large tasks: each costs a message. 64 is many for any pool of a few dozen.
        size = max(1, len(which) // 64)
        yield from _in_order(executor, plan, which, size, 256)
        return
    with ThreadPoolExecutor(workers) as pool:
        yield from _in_order(pool, plan, which, 1, 4 * workers)


def _in_order(pool: Executor, plan: Plan, which: range, size: int, ahead: int) -> Iterator[Tally]:
    """Submit blocks of `size` configurations, at most `ahead` at a time; yield them in order."""
    pending: deque[Future[list[Tally]]] = deque()
    starts = iter(range(which.start, which.stop, size))
    try:
        while True:
            while len(pending) < ahead and (start := next(starts, None)) is not None:
                stop = min(start + size, which.stop)
                pending.append(pool.submit(run_configurations, plan, start, stop))
            if not pending:
                return
            yield from pending.popleft().result()
    finally:
        for future in pending:
            future.cancel()

"""simulate(): from a medium and a start to an Ensemble."""

from _thread import start_new_thread
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from itertools import islice
from math import inf
from os import PathLike
from queue import SimpleQueue
from typing import Any, Literal

import numpy as np

from particles.arguments import check_workers, make_plan, require_memory
from particles.configuration import Arrays, Plan, Totals, run_configuration
from particles.ensemble import Ensemble
from particles.media import Medium
from particles.values import check_path, refuse

BLOCKS = 64  # of configurations: each costs a message, and this is many for a pool of a few dozen


def simulate(
    medium: Medium,
    restitution: float | Callable[..., Any] | tuple[Any, Any],
    initial: Literal["gaussian", "monoenergetic", "rest"] | np.ndarray = "gaussian",
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
    tangential_restitution: float = 1.0,
    field: float = 0.0,
    depth: float | None = None,
    mass_ratio: float = inf,
    bath_speed: float = 0.0,
    heating: float = 0.0,
    drag: float = 0.0,
    capture_speed: float = 0.0,
    part: tuple[int, int] | None = None,
) -> Ensemble:
    """Follow `tracers` tracers in each of `media` configurations of a medium.

    medium: HardDisks, Poisson, Positions or BoltzmannGrad in the plane, HardSpheres, PoissonSpheres
        or BoltzmannGrad(dimension=3) in space.
    restitution, tangential_restitution: at a collision the component of the velocity along the
        normal is multiplied by -restitution, the one across it by tangential_restitution. Each in
        [0, 1], not both 0. A restitution that depends on the impact speed (in U, of the normal
        component): `Viscoelastic(b)`, a function of an array of speeds, asked from 9e-13 to 1e6, or
        (speeds, values), straight between the speeds and constant outside. In a field it is there
        for BoltzmannGrad only.
    initial: "gaussian" (each component of standard deviation U), "monoenergetic" (speed U, any
        direction) or an array (tracers, dimension) or (media, tracers, dimension) of velocities in
        U; the dimension is that of the medium. In a field, a bath or heated also "rest": among
        disks the first tracer of a configuration then starts at the centre, where all that move do,
        and every other one at a random free place of the box (but see `Positions`).
    times (n_times,): output times in d/U, not negative, increasing, at most 1e300. A tracer ends at
        the last one, or after max_collisions collisions if that comes first. Without times,
        max_collisions is needed.
    seed: from 0 to 2**64 - 1. The result depends on it alone, bit for bit, and not on workers
        (threads; all processors if None) or executor (any concurrent.futures.Executor to run on
        instead: a process pool, a Dask client's get_executor()).
    observables: names out of `particles.OBSERVABLES`; the scalar ones if None.
    progress: called as progress(done, total), in configurations, from the calling thread.
    field: uniform acceleration along +x in U^2/d, for BoltzmannGrad and among disks. U is any unit
        of speed where tracers start at rest. BoltzmannGrad: a free path is an exponential length
        along the parabola. Among disks, where the field holds tracers on a disk in ever smaller
        bounces they slide along it without friction until it curves away, or until the next disk,
        and they may come to rest in a corner of two disks: they are then trapped. With a tangential
        restitution below 1 they are trapped where they would begin to slide.
    depth: in a field, record when each tracer first has x = depth, in d (Ensemble.passage_times).
    mass_ratio: mass of a scatterer over that of the tracer, 1e-6 or more; inf: they are fixed. A
        finite one, for BoltzmannGrad and tangential_restitution 1, is of scatterers at rest that
        are met once each, unless they have a bath_speed: the restitution is that of the relative
        velocity.
    bath_speed: standard deviation of each component of a scatterer's velocity in U. heating: D in
        U^3/d of white noise, <dv_i dv_j> = 2 D delta_ij dt. drag: gamma in U/d, of dv = -gamma v
        dt. For BoltzmannGrad; there they and a field may act together. All is exact but noise and
        drag, whose steps leave errors below 1e-4 of averages.
    capture_speed: in U; a tracer that strikes a fixed scatterer with a smaller normal velocity
        sticks: it stays there at rest, and in the averages (Statuses.captured).
    part: (k, n), 1 <= k <= n <= media: only the k-th of n parts of the configurations, on one of n
        machines; every configuration is the one of the whole run. `Ensemble.merge` joins the parts.
    output: file that the run is saved to, whole or not at all, again and again; the run may be
        killed at any moment. The file must not exist unless resume is True; then the run goes on
        from it, to the same bits as one that was never stopped.

    Raises ValueError for bad input, for a run that needs more memory than the machine has, where
    the scatterers cannot be placed, and for an output that cannot be used; that is left as it was.
    """
    whole = dict(media=media, tracers=tracers, max_collisions=max_collisions, seed=seed)
    plan = make_plan(
        medium, restitution, initial, times, observables, tangential_restitution, field, depth,
        mass_ratio, bath_speed, heating, drag, capture_speed, part, **whole,
    )  # fmt: skip
    workers = check_workers(workers)
    if executor is not None and not callable(getattr(executor, "submit", None)):
        refuse("executor", executor, "it must be a concurrent.futures.Executor")
    if progress is not None and not callable(progress):
        refuse("progress", progress, "it must be a function of (done, total)")
    if not isinstance(resume, (bool, np.bool_)):
        refuse("resume", resume, "it must be True or False")
    require_memory(plan, workers)
    if output is None and resume:
        raise ValueError("resume = True: needs output, the file to go on from")
    saver, totals = None, Totals(plan)
    if output is not None:
        from particles.files import Saver

        saver = Saver(check_path("output", output), plan)
        totals = saver.begin(bool(resume))
    which = plan.configurations[totals.configurations :]
    count = len(plan.configurations)
    if executor is None:
        found = _in_threads(plan, which, min(workers, len(which)))
    else:
        found = _in_executor(executor, plan, which)
    try:
        if progress is not None:
            progress(totals.configurations, count)
        for arrays in found:
            totals.add(arrays)
            if saver is not None:
                saver.write(totals, at_once=False)
            if progress is not None:
                progress(totals.configurations, count)
    finally:
        if saver is not None:
            saver.write(totals)
    return Ensemble(plan, totals.arrays())


def _in_threads(plan: Plan, which: range, workers: int) -> Iterator[Arrays]:
    """Run the configurations in so many threads, at most 4 for each thread ahead of their turn.

    Also with one thread: while compiled code runs in the main thread, Python sees no Ctrl-C. After
    an exception nobody waits for the threads, as a pool of concurrent.futures would. Queues written
    in C are all that is shared: an exception that a signal raises inside a lock of `threading` may
    leave it locked for ever.
    """
    asked: SimpleQueue[int | None] = SimpleQueue()
    done: SimpleQueue[tuple[int, Any]] = SimpleQueue()
    ended: list[bool] = []

    def work() -> None:
        while (c := asked.get()) is not None and not ended:
            try:
                done.put((c, run_configuration(plan, c)))
            except BaseException as error:  # it is raised again in the main thread
                done.put((c, error))
        done.put((-1, None))

    results: dict[int, Any] = {}
    coming = iter(which)
    try:
        for _ in range(workers):
            start_new_thread(work, ())
        for c in islice(coming, 4 * workers):
            asked.put(c)
        for c in which:
            while c not in results:
                results.update((done.get(),))
            result = results.pop(c)
            if isinstance(result, BaseException):
                raise result
            for following in islice(coming, 1):
                asked.put(following)
            yield result
    except BaseException:
        ended.append(True)
        raise
    finally:
        for _ in range(workers):
            asked.put(None)
    for _ in range(workers):
        done.get()


def _in_executor(pool: Executor, plan: Plan, which: range) -> Iterator[Arrays]:
    """Submit all configurations in BLOCKS or so; yield their results in order."""
    size = max(1, len(which) // BLOCKS)
    blocks = (which[k : k + size] for k in range(0, len(which), size))
    pending = deque(pool.submit(_run_block, plan, block) for block in blocks)
    try:
        while pending:
            yield from pending.popleft().result()
    finally:
        for future in pending:
            future.cancel()


def _run_block(plan: Plan, block: range) -> list[Arrays]:
    return [run_configuration(plan, c) for c in block]

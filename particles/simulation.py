"""simulate(): from a medium and a start to an Ensemble.

Its arguments become three values: what is simulated, what drives it, and what is recorded
(`particles.plan`).
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from math import inf
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from particles.arguments import (
    check_drive,
    check_experiment,
    check_medium,
    check_recording,
    check_workers,
    require_memory,
)
from particles.configuration import Arrays, Totals
from particles.ensemble import Ensemble
from particles.executors import run_in_executor, run_in_threads
from particles.media import Medium
from particles.plan import Plan
from particles.progress import show_progress
from particles.values import check_path, refuse

if TYPE_CHECKING:
    from particles.files import Saver


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
    progress: Callable[[int, int], None] | bool | None = None,
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

    Parameters
    ----------
    medium : HardDisks, Poisson, Positions or BoltzmannGrad in the plane, HardSpheres,
        PoissonSpheres or BoltzmannGrad(dimension=3) in space
    restitution, tangential_restitution : at a collision the component of the velocity along the
        normal is multiplied by -restitution, the one across it by tangential_restitution. Each in
        [0, 1], not both 0. A restitution that depends on the impact speed (in U, of the normal
        component): `Viscoelastic(b)`, a function of an array of speeds, called with speeds from
        9e-13 to 1e6, or (speeds, values), straight between the speeds and constant outside. In a
        field it is possible for BoltzmannGrad only
    initial : "gaussian" (each component of standard deviation U), "monoenergetic" (speed U, any
        direction) or an array (tracers, dimension) or (media, tracers, dimension) of velocities in
        U; the dimension is that of the medium. In a field, a bath or heated also "rest": among
        disks the first tracer of a configuration then starts at the centre, where all that move do,
        and every other one at a random free place of the box (but see `Positions`)
    times : output times in d/U, not negative, increasing, at most 1e300, shape (n_times,). A tracer
        ends at the last one, or after max_collisions collisions if that comes first. Without times,
        max_collisions is needed
    media, tracers : number of configurations, and of tracers in each
    max_collisions : number of collisions after which a tracer ends
    seed : from 0 to 2**64 - 1. The result depends on it alone, bit for bit, and not on workers or
        executor
    workers : threads; all processors if None
    executor : any concurrent.futures.Executor to run on instead: a process pool, a Dask client's
        get_executor()
    observables : names out of `particles.OBSERVABLES`; the scalar ones if None
    progress : True for a bar, in a terminal or a notebook; or a function that is called as
        progress(done, total), in configurations, from the calling thread
    output : file that the run is saved to, whole or not at all, again and again; the run may be
        killed at any moment. The file must not exist unless resume is True
    resume : whether the run goes on from the file `output`, to the same bits as one that was never
        stopped
    field : uniform acceleration along +x in U^2/d, for BoltzmannGrad and among disks. U is any unit
        of speed where tracers start at rest. BoltzmannGrad: a free path is an exponential length
        along the parabola. Among disks, where the field holds tracers on a disk in ever smaller
        bounces they slide along it without friction until it curves away, or until the next disk,
        and they may come to rest in a corner of two disks: they are then trapped. With a tangential
        restitution below 1 they are trapped where they would begin to slide
    depth : in a field, record when each tracer first has x = depth, in d (Ensemble.passage_times)
    mass_ratio : mass of a scatterer over that of the tracer, 1e-6 or more; inf: they are fixed. A
        finite one, for BoltzmannGrad and tangential_restitution 1, is of scatterers at rest that
        are met once each, unless they have a bath_speed: the restitution is that of the relative
        velocity
    bath_speed : standard deviation of each component of a scatterer's velocity in U
    heating : D in U^3/d of white noise, <dv_i dv_j> = 2 D delta_ij dt
    drag : gamma in U/d, of dv = -gamma v dt. bath_speed, heating and drag are for BoltzmannGrad;
        there they and a field may act together. All is exact but noise and drag, whose steps leave
        errors below 1e-4 of averages
    capture_speed : in U; a tracer that strikes a fixed scatterer with a smaller normal velocity
        sticks: it stays there at rest, and in the averages (Statuses.captured)
    part : (k, n), 1 <= k <= n <= media: only the k-th of n parts of the configurations, on one of n
        machines; every configuration is the one of the whole run. `Ensemble.merge` joins the parts

    Returns
    -------
    Ensemble : averages, histograms and raw data, with standard errors

    Raises
    ------
    ValueError : for bad input, for a run that needs more memory than the machine has, where the
        scatterers cannot be placed, and for an output that cannot be used; that is left as it was
    """
    medium = check_medium(medium)
    drive = check_drive(
        medium,
        restitution,
        tangential_restitution,
        field,
        mass_ratio,
        bath_speed=bath_speed,
        heating=heating,
        drag=drag,
        capture_speed=capture_speed,
    )
    experiment = check_experiment(
        medium, initial, media, tracers, seed, part, may_rest=drive.gives_energy
    )
    recording = check_recording(times, max_collisions, observables, depth, drive)
    plan = Plan(experiment, drive, recording)
    workers = check_workers(workers)
    report_progress = _check_running(executor, progress, output, resume)
    require_memory(plan, workers)
    saver = None
    totals = Totals(plan)
    if output is not None:
        from particles.files import Saver

        saver = Saver(check_path("output", output), plan)
        totals = saver.begin(bool(resume))
    remaining = plan.configurations[totals.configurations :]
    if executor is None:
        results = run_in_threads(plan, remaining, min(workers, len(remaining)))
    else:
        results = run_in_executor(executor, plan, remaining)
    _collect(results, totals, saver, report_progress)
    return Ensemble(plan, totals.arrays())


def _check_running(
    executor: object,
    progress: Callable[[int, int], None] | bool | None,
    output: object,
    resume: object,
) -> Callable[[int, int], None] | None:
    """Return what shows the progress; ValueError for arguments that cannot be used to run."""
    if executor is not None and not callable(getattr(executor, "submit", None)):
        refuse("executor", executor, "it must be a concurrent.futures.Executor")
    if not isinstance(resume, (bool, np.bool_)):
        refuse("resume", resume, "it must be True or False")
    if output is None and resume:
        raise ValueError("resume = True: needs output, the file to go on from")
    if progress is None or progress is False:
        return None
    if progress is True:
        return show_progress()
    if not callable(progress):
        refuse("progress", progress, "it must be True or a function of (done, total)")
    return progress


def _collect(
    results: Iterable[Arrays],
    totals: Totals,
    saver: "Saver | None",
    progress: Callable[[int, int], None] | None,
) -> None:
    """Add the results of configurations to the totals as they come; save and report them."""
    count = len(totals.plan.configurations)
    try:
        if progress is not None:
            progress(totals.configurations, count)
        for arrays in results:
            totals.add(arrays)
            if saver is not None:
                saver.write(totals, at_once=False)
            if progress is not None:
                progress(totals.configurations, count)
    finally:
        if saver is not None:
            saver.write(totals)

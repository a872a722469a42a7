"""The memory that a run needs, estimated before it is asked for."""

import os
from contextlib import suppress
from math import inf
from pathlib import Path

from particles.cells import box_bytes
from particles.checks import refuse
from particles.configuration import Plan
from particles.kernel.columns import FIELD_SUMS, FINALS, HISTOGRAMS, MOMENTS, TOTALS
from particles.media import BoltzmannGrad

_NUMBER = 8  # bytes
# Copies of the results at the end of a run: their pieces, what these are joined to, and with a file
# the contents of that file.
_COPIES = 3


def require_memory(plan: Plan, workers: int) -> None:
    """Raise ValueError, with the estimate, for a run that needs more memory than there is."""
    available, needed = machine_memory(), estimate(plan, workers)
    total = sum(needed.values())
    if total > available:
        name = max(needed, key=lambda name: needed[name])
        value = getattr(plan.medium if name == "count" else plan, name)
        what = f"the run needs about {total / 1e9:.2g} GB of memory, this machine has "
        what += f"{available / 1e9:.2g} GB"
        refuse(name, sorted(value) if name == "observables" else value, what)


def estimate(plan: Plan, workers: int) -> dict[str, int]:
    """Return the bytes that a run needs at least, by the argument that they depend on most."""
    medium, times, bins = plan.medium, plan.times.size, plan.grids()[:, 2].astype(int)
    counts = sum(
        int(bins[k]) * (1 if name == "free_path_histogram" else times)
        for k, name in enumerate(HISTOGRAMS)
        if name in plan.observables
    )
    dimension = medium.dimension
    each = times * dimension * len(plan.observables & {"positions", "velocities"})
    each += FINALS[dimension] * ("finals" in plan.observables) + (plan.depth is not None)
    columns = MOMENTS + (FIELD_SUMS[dimension] if plan.field else 0)
    threads = min(workers, plan.media)
    box = 0
    if not isinstance(medium, BoltzmannGrad):
        box = box_bytes(medium.box_side / medium.diameter, medium.count, dimension)
    return {
        "count": threads * box,
        "media": _NUMBER * plan.media * (times * columns + TOTALS),
        "times": _NUMBER * counts * (threads + 2 * _COPIES),
        "observables": _NUMBER * plan.media * plan.tracers * each * _COPIES,
    }


def machine_memory() -> float:
    """Return the bytes of memory that this process may have, infinite where that is not known."""
    found = [inf]
    with suppress(AttributeError, OSError, ValueError):
        found.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    with suppress(OSError, ValueError):  # of a container
        found.append(int(Path("/sys/fs/cgroup/memory.max").read_text()))
    with suppress(ImportError):
        import resource

        found.append(resource.getrlimit(resource.RLIMIT_AS)[0])  # -1 stands for no limit
    return min(n for n in found if n > 0)

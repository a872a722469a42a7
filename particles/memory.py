"""The memory that a run needs, estimated before it is asked for."""

import os
from collections.abc import Callable
from pathlib import Path

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
    available = machine_memory()
    needed = estimate(plan, workers)
    total = sum(needed.values())
    if available is not None and total > available:
        name = max(needed, key=lambda name: needed[name])
        value = getattr(plan.medium if name == "count" else plan, name)
        refuse(
            name,
            sorted(value) if name == "observables" else value,
            f"the run needs about {total / 1e9:.2g} GB of memory, this machine has "
            f"{available / 1e9:.2g} GB",
        )


def estimate(plan: Plan, workers: int) -> dict[str, int]:
    """Return the bytes that a run needs at least, by the argument that they depend on most."""
    times, bins = plan.times.size, plan.grids()[:, 2].astype(int)
    counts = sum(
        int(bins[k]) * (1 if name == "free_path_histogram" else times)
        for k, name in enumerate(HISTOGRAMS)
        if name in plan.observables
    )
    dimension = plan.medium.dimension
    each = times * dimension * len(plan.observables & {"positions", "velocities"})
    each += FINALS[dimension] * ("finals" in plan.observables) + (plan.depth is not None)
    columns = MOMENTS + (FIELD_SUMS[dimension] if plan.field else 0)
    threads = min(workers, plan.media)
    return {
        "count": threads * _scatterers(plan),
        "media": _NUMBER * plan.media * (times * columns + TOTALS),
        "times": _NUMBER * counts * (threads + 2 * _COPIES),
        "observables": _NUMBER * plan.media * plan.tracers * each * _COPIES,
    }


def _scatterers(plan: Plan) -> int:
    """Return the bytes of one configuration's scatterers in a periodic box."""
    from particles.cells import box_bytes

    medium = plan.medium
    if isinstance(medium, BoltzmannGrad):
        return 0
    return box_bytes(medium.box_side / medium.diameter, medium.count, medium.dimension)


def machine_memory() -> int | None:
    """Return the bytes of memory that this process may have, None where that is not known."""
    ways: tuple[Callable[[], int], ...] = (
        lambda: os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"),
        lambda: int(Path("/sys/fs/cgroup/memory.max").read_text()),  # of a container
        _address_space,
    )
    found = []
    for way in ways:
        try:
            found.append(way())
        except (AttributeError, ImportError, OSError, ValueError):
            continue  # another system, or no limit
    return min((n for n in found if n > 0), default=None)


def _address_space() -> int:
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)[0]  # -1 stands for no limit

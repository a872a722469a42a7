"""The arguments of `simulate`, checked, as a Plan; and the memory that it needs."""

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from math import inf, prod
from pathlib import Path
from typing import Any

import numpy as np

from particles.cells import box_bytes
from particles.configuration import Plan, layout, speeds
from particles.events import NEVER
from particles.impact import check_restitution, compiled
from particles.media import MEDIA, BoltzmannGrad, Medium, Positions, Random, dilute_mean_path
from particles.outputs import DRIVES, OBSERVABLES
from particles.values import check_number, check_whole, is_whole, real_array, refuse, short

# With a field: of field times mean free path, in U^2, so that the fourth power of the speed is a
# number; and of field times diameter, in U^2. The last also of a depth, in d.
FIELDS = (1e-100, 1e100)
STRONGEST = 1e30  # of what drives tracers, in its unit: fourth powers of speeds are numbers
LEAST_MASS_RATIO = 1e-6  # a collision with a lighter scatterer hardly changes the velocity
UNLESS_SMOOTH, AMONG = "unless tangential_restitution is 1", "among scatterers in a field"
SMALLEST_SPEED = 1e-150  # in U; the square of it, and of its inverse, is a number
# Copies of the results at the end of a run: their pieces, what these are joined to, and with a file
# the contents of that file.
COPIES = 3


def make_plan(
    medium: Medium, restitution: Any, initial: Any, times: Any,
    observables: Iterable[str] | None, tangential_restitution: float = 1.0, field: float = 0.0,
    depth: float | None = None, mass_ratio: float = inf, bath_speed: float = 0.0,
    heating: float = 0.0, drag: float = 0.0, capture_speed: float = 0.0,
    part: tuple[int, int] | None = None, **whole: int | None,
) -> Plan:  # fmt: skip
    """Check every argument of `simulate` and return what is to be run.

    whole: media, tracers, max_collisions and seed. Raises ValueError for what is not allowed.
    """
    if not isinstance(medium, Medium):
        names = [kind.__name__ for kind in MEDIA]
        refuse("medium", medium, f"it must be {', '.join(names[:-1])} or {names[-1]}")
    restitution = check_restitution(restitution)
    allowed = "it must be a number from 0 to 1"
    tangential = check_number("tangential_restitution", tangential_restitution, 0.0, 1.0, allowed)
    if max(compiled(restitution)[1].min(), tangential) < SMALLEST_SPEED:
        allowed = "the first collision stops a tracer; this or restitution must be larger than 0"
        refuse("tangential_restitution", tangential_restitution, allowed)
    media, tracers = (check_whole(name, whole[name], 1, 2**31) for name in ("media", "tracers"))
    if isinstance(medium, Positions) and medium.sets not in (None, media):
        refuse("media", media, f"it must be {medium.sets}, the sets of positions given")
    field = _check_field(field, medium)
    allowed = f"it must be a number, {LEAST_MASS_RATIO:g} or more, or inf (fixed scatterers)"
    mass_ratio = check_number("mass_ratio", mass_ratio, LEAST_MASS_RATIO, inf, allowed)
    drives = zip(DRIVES, (bath_speed, heating, drag, capture_speed), strict=True)
    allowed = f"it must be a number from 0 to {STRONGEST:g}"
    driven = {name: check_number(name, value, 0.0, STRONGEST, allowed) for name, value in drives}
    kind, dilute = type(medium).__name__, isinstance(medium, BoltzmannGrad)
    rough, moved, among = tangential != 1.0, mass_ratio < inf, field and not dilute
    for name, value, forbidden, allowed in (
        ("mass_ratio", mass_ratio, moved and not dilute, f"it must be inf for {kind}"),
        ("mass_ratio", mass_ratio, moved and rough, f"it must be inf {UNLESS_SMOOTH}"),
        *((name, driven[name], driven[name] and not dilute, f"it must be 0 for {kind}")
          for name in ("bath_speed", "heating", "drag")),
        ("bath_speed", bath_speed, bath_speed and rough, f"it must be 0 {UNLESS_SMOOTH}"),
        ("capture_speed", capture_speed, capture_speed and (bath_speed or moved),
         "it must be 0 unless scatterers are fixed"),
        ("capture_speed", capture_speed, capture_speed and among, f"it must be 0 {AMONG}"),
        ("restitution", restitution, among and not isinstance(restitution, float),
         f"it must be a number {AMONG}"),
        ("times", times, drag and times is None and not (field or bath_speed or heating),
         "drag alone stops a tracer; give output times"),
    ):  # fmt: skip
        if forbidden:
            refuse(name, value, allowed)
    seed, most = check_whole("seed", whole["seed"], 0, 2**64 - 1), whole["max_collisions"]
    may_rest = max(abs(field), bath_speed, heating) > 0.0
    if most is None and times is None:
        refuse("times", times, "give output times, or max_collisions, or both")
    return Plan(
        medium=medium,
        restitution=restitution,
        tangential_restitution=tangential,
        monoenergetic=isinstance(initial, str) and initial == "monoenergetic",
        velocities=_check_initial(initial, (media, tracers, medium.dimension), may_rest),
        times=_check_times(times),
        media=media,
        tracers=tracers,
        max_collisions=None if most is None else check_whole("max_collisions", most, 1),
        seed=seed,
        observables=_check_observables(observables, field),
        field=field,
        rest=isinstance(initial, str) and initial == "rest",
        depth=_check_depth(depth, field),
        mass_ratio=mass_ratio,
        part=_check_part(part, media),
        **driven,
    )


def _check_part(part: Any, media: int) -> tuple[int, int] | None:
    """Return (k, n), 1 <= k <= n <= media, or None for the whole run."""
    if part is None:
        return None
    allowed = f"it must be two whole numbers (k, n), the k-th of n parts, 1 <= k <= n <= {media}"
    if not isinstance(part, (tuple, list)) or len(part) != 2:
        refuse("part", part, allowed)
    k, n = (x if is_whole(x) else 0 for x in part)
    if not 1 <= k <= n <= media:
        refuse("part", part, allowed)
    return (int(k), int(n)) if n > 1 else None


def check_workers(workers: int | None, most: int = 10_000) -> int:
    """Return the number of threads to use."""
    if workers is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    return check_whole("workers", workers, 1, most)


def _check_times(times: Any) -> np.ndarray:
    if times is None:
        return np.empty(0)
    array = real_array("times", times, "it must be a sequence of numbers")
    if array.ndim != 1 or array.size == 0:
        refuse("times", times, "it must be a sequence of at least one time")
    if not (np.isfinite(array).all() and array.min() >= 0 and array.max() <= NEVER):
        refuse("times", times, f"it must be finite, not negative, at most {NEVER:g}")
    if (np.diff(array) <= 0).any():
        refuse("times", times, "must increase")
    return array


def _check_field(field: Any, medium: Medium) -> float:
    """Return the field as a float; it must give speeds whose powers are numbers."""
    largest = sys.float_info.max
    value = check_number("field", field, -largest, largest, "it must be a finite number")
    if value == 0.0:
        return 0.0
    d = medium.diameter
    squares = abs(value) * d, abs(value) * d * dilute_mean_path(medium)
    if not all(FIELDS[0] <= square <= FIELDS[1] for square in squares):
        allowed = f"times the mean free path, and times d, must be 0 or {FIELDS[0]:g} to "
        refuse("field", field, f"{allowed}{FIELDS[1]:g} U^2 in size")
    if isinstance(medium, Random) and medium.dimension == 3:
        refuse("field", field, f"it must be 0 for {type(medium).__name__}; disks may be in a field")
    return value


def _check_depth(depth: Any, field: float) -> float | None:
    if depth is None:
        return None
    allowed = f"it must be a number with the sign of the field, {FIELDS[1]:g} d at most, or None"
    number = check_number("depth", depth, -FIELDS[1], FIELDS[1], allowed)
    if not number * field > 0.0:
        refuse("depth", depth, allowed)
    return number


def _check_initial(
    initial: Any, shape: tuple[int, int, int], may_rest: bool
) -> np.ndarray | None:  # fmt: skip
    """Return velocities that are given, or None; shape: media, tracers, dimension."""
    if isinstance(initial, str):
        if initial not in ("gaussian", "monoenergetic") and not (initial == "rest" and may_rest):
            names = "'gaussian', 'monoenergetic', 'rest' (in a field, a bath or heated)"
            refuse("initial", initial, f"it must be {names} or velocities")
        return None
    velocities = real_array("initial", initial, "it must be a name or an array of real velocities")
    if velocities.shape not in (shape, shape[1:]):
        allowed = f"its shape must be (tracers, dimension) = {shape[1:]}, or with media {shape}"
        refuse("initial", velocities, allowed)
    with np.errstate(over="ignore"):
        sizes = speeds(velocities)
    good = (sizes >= SMALLEST_SPEED) & (sizes <= 1.0 / SMALLEST_SPEED)
    if may_rest:
        good |= sizes == 0.0
    if not good.all():
        allowed = f"its size must be from {SMALLEST_SPEED:g} to {1.0 / SMALLEST_SPEED:g}"
        refuse("initial", velocities[~good][0], allowed)
    return velocities


def _check_observables(observables: Iterable[str] | None, field: float) -> frozenset[str]:
    if observables is None:
        return frozenset()
    allowed = f"it must be names out of {', '.join(OBSERVABLES)}"
    try:
        names = frozenset([observables] if isinstance(observables, str) else observables)
    except TypeError:
        refuse("observables", observables, allowed)
    for name in sorted(names - set(OBSERVABLES), key=short):
        refuse("observables", name, allowed)
    if field and (name := "velocity_component_histogram") in names:
        refuse("observables", name, "it is of |v_x|, without the sign, in a field; use velocities")
    return names


def require_memory(plan: Plan, workers: int) -> None:
    """Raise ValueError, with the estimate, for a run that needs more memory than there is."""
    available, needed = machine_memory() / 1e9, estimate(plan, workers)
    total = sum(needed.values()) / 1e9
    if total > available:
        name = max(needed, key=lambda name: needed[name])
        value = getattr(plan.medium if name == "count" else plan, name)
        what = f"the run needs about {total:.2g} GB of memory, this machine has {available:.2g} GB"
        refuse(name, sorted(value) if name == "observables" else value, what)


def estimate(plan: Plan, workers: int) -> dict[str, int]:
    """Return the bytes that a run needs at least, by the argument that they depend on most."""
    medium, media = plan.medium, len(plan.configurations)
    threads, box = min(workers, media), 0
    if not isinstance(medium, BoltzmannGrad):
        box = box_bytes(medium.box_side / medium.diameter, medium.count, medium.dimension)
    found = {"count": threads * box, "media": 0, "times": 0, "observables": 0}
    for name, (shape, _) in layout(plan, media, media * plan.tracers).items():
        if name.startswith("histograms/"):
            found["times"] += (threads + 2 * COPIES) * 8 * prod(shape)
        elif name.startswith("raw/"):
            found["observables"] += COPIES * 8 * prod(shape)
        elif name != "traps":  # of which there are few
            found["media"] += 8 * prod(shape)
    return found


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

"""The arguments of `simulate`, checked, and the memory that a run needs.

Begin reading with `check_drive`, `check_experiment` and `check_recording`, which make the three
values of a `particles.plan.Plan`.
"""

import os
import sys
from collections.abc import Iterable
from math import inf, prod

import numpy as np

from particles.cells import box_bytes
from particles.configuration import layout
from particles.drive import Drive
from particles.events import NEVER
from particles.impact import check_restitution, tabulate
from particles.media import (
    MEDIA,
    BoltzmannGrad,
    Medium,
    Positions,
    Random,
    dilute_mean_path,
)
from particles.outputs import ALIASES, ESTIMATES, OBSERVABLES
from particles.plan import Experiment, Plan, Recording, speeds
from particles.values import (
    check_number,
    check_whole,
    is_whole,
    machine_memory,
    real_array,
    refuse,
    short,
    suggest,
)

#: Least field times mean free path, and field times d, in U^2. Derived: fourth powers of the speed
#: are numbers.
WEAKEST_FIELD = 1e-100
#: Largest field times mean free path, and field times d, in U^2; also of a depth in d. Derived: as
#: the least one.
STRONGEST_FIELD = 1e100
#: Largest strength of what drives tracers, in its unit. Derived: fourth powers of speeds are
#: numbers.
STRONGEST = 1e30
#: Least mass ratio. Chosen: a collision with a lighter scatterer hardly changes the velocity.
LEAST_MASS_RATIO = 1e-6
#: Least speed in U. Derived: the square of it, and of its inverse, is a number.
SMALLEST_SPEED = 1e-150
#: Copies of the results at the end of a run: their pieces, what these are joined to, and with a
#: file the contents of that file.
COPIES = 3
#: Most media, or tracers in each. Derived: numbers of 32 bits.
LARGEST_NUMBER = 2**31
#: Most threads. Chosen: more than any machine has processors.
MOST_WORKERS = 10_000


def check_medium(medium: object) -> Medium:
    """Return a medium."""
    if not isinstance(medium, Medium):
        names = [kind.__name__ for kind in MEDIA]
        refuse("medium", medium, f"it must be {', '.join(names[:-1])} or {names[-1]}")
    return medium


# -- what drives -----------------------------------------------------------------------------------


def check_drive(
    medium: Medium,
    restitution: object,
    tangential_restitution: object,
    field: object,
    mass_ratio: object,
    **strengths: object,
) -> Drive:
    """Return what drives tracers in a medium. strengths: of `DRIVES`, by name."""
    law = check_restitution(restitution)
    allowed = "it must be a number from 0 to 1"
    tangential = check_number("tangential_restitution", tangential_restitution, 0.0, 1.0, allowed)
    if max(tabulate(law)[1].min(), tangential) < SMALLEST_SPEED:
        allowed = "the first collision stops a tracer; this or restitution must be larger than 0"
        refuse("tangential_restitution", tangential_restitution, allowed)
    acceleration = _check_field(field, medium)
    allowed = f"it must be a number, {LEAST_MASS_RATIO:g} or more, or inf (fixed scatterers)"
    mass_ratio = check_number("mass_ratio", mass_ratio, LEAST_MASS_RATIO, inf, allowed)
    allowed = f"it must be a number from 0 to {STRONGEST:g}"
    checked = {
        name: check_number(name, strength, 0.0, STRONGEST, allowed)
        for name, strength in strengths.items()
    }
    drive = Drive(
        restitution=law,
        tangential_restitution=tangential,
        field=acceleration,
        mass_ratio=mass_ratio,
        **checked,
    )
    _require_compatible(medium, drive)
    return drive


def _require_compatible(medium: Medium, drive: Drive) -> None:
    """Raise ValueError for what cannot act in a medium, or not together."""
    kind = type(medium).__name__
    has_places = not isinstance(medium, BoltzmannGrad)
    is_rough = drive.tangential_restitution != 1.0
    is_movable = drive.mass_ratio < inf
    falls_among = has_places and drive.field != 0.0
    unless_smooth = "unless tangential_restitution is 1"
    among = "among scatterers in a field"
    rules = (
        ("mass_ratio", is_movable and has_places, f"it must be inf for {kind}"),
        ("mass_ratio", is_movable and is_rough, f"it must be inf {unless_smooth}"),
        ("bath_speed", drive.bath_speed and has_places, f"it must be 0 for {kind}"),
        ("heating", drive.heating and has_places, f"it must be 0 for {kind}"),
        ("drag", drive.drag and has_places, f"it must be 0 for {kind}"),
        ("bath_speed", drive.bath_speed and is_rough, f"it must be 0 {unless_smooth}"),
        (
            "capture_speed",
            drive.capture_speed and (drive.bath_speed or is_movable),
            "it must be 0 unless scatterers are fixed",
        ),
        ("capture_speed", drive.capture_speed and falls_among, f"it must be 0 {among}"),
        (
            "restitution",
            falls_among and not isinstance(drive.restitution, float),
            f"it must be a number {among}",
        ),
    )
    for name, is_forbidden, allowed in rules:
        if is_forbidden:
            refuse(name, getattr(drive, name), allowed)


def _check_field(field: object, medium: Medium) -> float:
    """Return the field as a float; it must give speeds whose powers are numbers."""
    largest = sys.float_info.max
    acceleration = check_number("field", field, -largest, largest, "it must be a finite number")
    if acceleration == 0.0:
        return 0.0
    speed2 = abs(acceleration) * medium.diameter
    for square in (speed2, speed2 * dilute_mean_path(medium)):
        if not WEAKEST_FIELD <= square <= STRONGEST_FIELD:
            allowed = "times the mean free path, and times d, must be 0 or "
            allowed += f"{WEAKEST_FIELD:g} to {STRONGEST_FIELD:g} U^2 in size"
            refuse("field", field, allowed)
    if isinstance(medium, Random) and medium.dimension == 3:
        refuse("field", field, f"it must be 0 for {type(medium).__name__}; disks may be in a field")
    return acceleration


# -- what is simulated -----------------------------------------------------------------------------


def check_experiment(
    medium: Medium,
    initial: object,
    media: object,
    tracers: object,
    seed: object,
    part: object,
    may_rest: bool,
) -> Experiment:
    """Return what is simulated. may_rest: whether something moves a tracer that is at rest."""
    media = check_whole("media", media, 1, LARGEST_NUMBER)
    tracers = check_whole("tracers", tracers, 1, LARGEST_NUMBER)
    if isinstance(medium, Positions) and medium.sets not in (None, media):
        refuse("media", media, f"it must be {medium.sets}, the sets of positions given")
    is_named = isinstance(initial, str)
    return Experiment(
        medium=medium,
        monoenergetic=is_named and initial == "monoenergetic",
        rest=is_named and initial == "rest",
        velocities=_check_initial(initial, (media, tracers, medium.dimension), may_rest),
        media=media,
        tracers=tracers,
        seed=check_whole("seed", seed, 0, 2**64 - 1),
        part=_check_part(part, media),
    )


def _check_part(part: object, media: int) -> tuple[int, int] | None:
    """Return (k, n), 1 <= k <= n <= media, or None for the whole run."""
    if part is None:
        return None
    allowed = f"it must be two whole numbers (k, n), the k-th of n parts, 1 <= k <= n <= {media}"
    if not isinstance(part, (tuple, list)) or len(part) != 2:
        refuse("part", part, allowed)
    k, n = part
    if not (is_whole(k) and is_whole(n) and 1 <= k <= n <= media):
        refuse("part", part, allowed)
    return (int(k), int(n)) if n > 1 else None


def _check_initial(
    initial: object, shape: tuple[int, int, int], may_rest: bool
) -> np.ndarray | None:  # fmt: skip
    """Return velocities that are given, or None; shape: media, tracers, dimension."""
    if isinstance(initial, str):
        if initial not in ("gaussian", "monoenergetic") and not (initial == "rest" and may_rest):
            names = "'gaussian', 'monoenergetic', 'rest' (in a field, a bath or heated)"
            near = suggest(initial, ("gaussian", "monoenergetic", "rest"))
            refuse("initial", initial, f"it must be {names} or velocities{near}")
        return None
    velocities = real_array("initial", initial, "it must be a name or an array of real velocities")
    if velocities.shape not in (shape, shape[1:]):
        allowed = f"its shape must be (tracers, dimension) = {shape[1:]}, or with media {shape}"
        refuse("initial", velocities, allowed)
    with np.errstate(over="ignore"):
        sizes = speeds(velocities)
    is_allowed = (sizes >= SMALLEST_SPEED) & (sizes <= 1.0 / SMALLEST_SPEED)
    if may_rest:
        is_allowed |= sizes == 0.0
    if not is_allowed.all():
        allowed = f"its size must be from {SMALLEST_SPEED:g} to {1.0 / SMALLEST_SPEED:g}"
        refuse("initial", velocities[~is_allowed][0], allowed)
    return velocities


# -- what is recorded ------------------------------------------------------------------------------


def check_recording(
    times: object,
    max_collisions: object,
    observables: Iterable[str] | None,
    depth: object,
    drive: Drive,
) -> Recording:
    """Return what is recorded of tracers that are driven in this way."""
    if times is None:
        if drive.drag and not drive.gives_energy:
            refuse("times", times, "drag alone stops a tracer; give output times")
        if max_collisions is None:
            refuse("times", times, "give output times, or max_collisions, or both")
    if max_collisions is not None:
        max_collisions = check_whole("max_collisions", max_collisions, 1)
    return Recording(
        times=_check_times(times),
        max_collisions=max_collisions,
        observables=_check_observables(observables, drive.field),
        depth=_check_depth(depth, drive.field),
    )


def _check_times(times: object) -> np.ndarray:
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


def _check_depth(depth: object, field: float) -> float | None:
    if depth is None:
        return None
    allowed = (
        f"it must be a number with the sign of the field, {STRONGEST_FIELD:g} d at most, or None"
    )
    number = check_number("depth", depth, -STRONGEST_FIELD, STRONGEST_FIELD, allowed)
    if not number * field > 0.0:
        refuse("depth", depth, allowed)
    return number


def _check_observables(observables: Iterable[str] | None, field: float) -> frozenset[str]:
    if observables is None:
        return frozenset()
    allowed = f"it must be names out of {', '.join(OBSERVABLES)}"
    try:
        names = frozenset([observables] if isinstance(observables, str) else observables)
    except TypeError:
        refuse("observables", observables, allowed)
    for name in sorted(names - set(OBSERVABLES), key=short):
        if name in ESTIMATES:
            refuse("observables", name, "it need not be named: every run that can have it has it")
        refuse("observables", name, allowed + suggest(name, OBSERVABLES, ALIASES))
    name = "velocity_component_histogram"
    if field and name in names:
        refuse("observables", name, "it is of |v_x|, without the sign, in a field; use velocities")
    return names


# -- what it takes ---------------------------------------------------------------------------------


def check_workers(workers: int | None) -> int:
    """Return the number of threads to use."""
    if workers is None:
        affinity = getattr(os, "sched_getaffinity", None)
        if affinity:
            return len(affinity(0))
        return os.cpu_count() or 1
    return check_whole("workers", workers, 1, MOST_WORKERS)


def require_memory(plan: Plan, workers: int) -> None:
    """Raise ValueError, with the estimate, for a run that needs more memory than there is."""
    available = machine_memory() / 1e9
    needed = estimate_memory(plan, workers)
    total = sum(needed.values()) / 1e9
    if total <= available:
        return
    name = max(needed, key=lambda argument: needed[argument])
    value = getattr(plan.medium if name == "count" else plan, name)
    if name == "observables":
        value = sorted(value)
    problem = f"the run needs about {total:.2g} GB of memory"
    refuse(name, value, f"{problem}, this machine has {available:.2g} GB")


def estimate_memory(plan: Plan, workers: int) -> dict[str, int]:
    """Return the bytes that a run needs at least, by the argument that they depend on most."""
    medium = plan.medium
    media = len(plan.configurations)
    threads = min(workers, media)
    box = 0
    if not isinstance(medium, BoltzmannGrad):
        box = box_bytes(medium.box_side / medium.diameter, medium.count, medium.dimension)
    if isinstance(medium, Random) and medium.spacing not in (0.0, medium.diameter):
        # Cells of their own, in which the scatterers are placed.
        box += box_bytes(medium.box_side / medium.spacing, medium.count, medium.dimension)
    needed = {"count": threads * box, "media": 0, "times": 0, "observables": 0}
    for name, (shape, _initial) in layout(plan, media, media * plan.tracers).items():
        array = 8 * prod(shape)
        if name.startswith("histograms/"):
            needed["times"] += (threads + 2 * COPIES) * array
        elif name.startswith("raw/"):
            needed["observables"] += COPIES * array
        elif name != "traps":  # of which there are few
            needed["media"] += array
    return needed

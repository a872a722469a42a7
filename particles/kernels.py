"""Loops over tracers and their events. Floats and arrays only, in units of d."""

from math import floor, log, log2, sqrt

import numpy as np
from numba import njit

from particles.cells import SLOTS
from particles.events import NEVER, contact, scatter, touch
from particles.streams import FLIGHTS, START, open_stream, uniform

# How a tracer ended. The numbers are indices into Tally.statuses and are stored in files.
FINISHED, COLLISION_CAP, TRAPPED, ESCAPED = range(4)

# A tracer is trapped when TRAP_FLIGHTS successive flights were each shorter than TRAP_LENGTH d:
# the cascade of a corner, whose flights and speed shrink geometrically (see Ensemble.statuses).
TRAP_LENGTH = 1e-9
TRAP_FLIGHTS = 16

# A flight longer than this, in d, is an escape: there is nothing in its way.
ESCAPE_LENGTH = 1e9

# Inverse speed and time are kept times 2**-64k; k grows as the tracer slows, so neither overflows.
SHIFT = 2.0**64

# Columns of the moments, each a sum over tracers at one output time.
SAMPLES, SPEED2, SPEED4, R2, R4, COLLISIONS, CORRELATION, CAUGHT = range(8)
MOMENTS = 8

# Rows of the histogram grids: log2 of the lowest edge, bins per octave.
SPEED, COMPONENT, DISTANCE, PATH = range(4)


@njit(inline="always", error_model="numpy")
def _count(histogram, row, log2_value, low, per_octave):  # type: ignore[no-untyped-def]
    """Add one to the bin of a value; the first and last bins hold what is below and above."""
    last = histogram.shape[1] - 1
    place = floor((log2_value - low) * per_octave) + 1.0
    if not place > 0.0:  # below the first edge, and log2(0)
        histogram[row, 0] += 1
    elif place >= last:
        histogram[row, last] += 1
    else:
        histogram[row, int(place)] += 1


@njit(inline="always", error_model="numpy")
def _log2(value):  # type: ignore[no-untyped-def]
    return log2(value) if value > 0.0 else -NEVER


@njit(error_model="numpy")
def _record(  # type: ignore[no-untyped-def]
    k, tracer, x, y, vx, vy, scale, ox, oy, collisions, caught, moments, grids, speeds, components,
    distances, positions, velocities,
):  # fmt: skip
    """Enter one tracer at output time k. Velocities come times `scale`, a power of 2."""
    r2 = x * x + y * y
    v2 = vx * vx + vy * vy
    row = moments[k]
    row[SAMPLES] += 1.0
    row[SPEED2] += v2
    row[SPEED4] += v2 * v2
    row[R2] += r2
    row[R4] += r2 * r2
    row[COLLISIONS] += collisions
    row[CORRELATION] += vx * ox + vy * oy
    row[CAUGHT] += caught
    shift = log2(scale)
    if speeds.size:
        _count(speeds, k, 0.5 * _log2(v2) - shift, grids[SPEED, 0], grids[SPEED, 1])
    if components.size:
        _count(components, k, _log2(abs(vx)) - shift, grids[COMPONENT, 0], grids[COMPONENT, 1])
    if distances.size:
        _count(distances, k, 0.5 * _log2(r2), grids[DISTANCE, 0], grids[DISTANCE, 1])
    if positions.size:
        positions[k, tracer, 0] = x
        positions[k, tracer, 1] = y
    if velocities.size:
        velocities[k, tracer, 0] = vx / scale
        velocities[k, tracer, 1] = vy / scale


@njit(error_model="numpy")
def _fly(  # type: ignore[no-untyped-def]
    k, tracer, path, time, slowness, unit, x, y, ux, uy, ox, oy, collisions, times, scales,
    moments, grids, speeds, components, distances, positions, velocities,
):  # fmt: skip
    """Enter the output times that fall in a flight of this path; return the next output's index.

    (x, y) is the displacement at its beginning; time and slowness (1/speed) come times `unit`.
    """
    end = time + path * slowness
    while k < times.size and times[k] * unit <= end:
        # Not negative but for outputs that `unit` has rounded to 0: passed within 1e-8 d.
        done = max((times[k] * unit - time) / slowness, 0.0)
        speed = scales[k] * unit / slowness
        _record(
            k, tracer, x + done * ux, y + done * uy, speed * ux, speed * uy, scales[k], ox, oy,
            collisions, 0, moments, grids, speeds, components, distances, positions, velocities,
        )  # fmt: skip
        k += 1
    return k


@njit(error_model="numpy")
def _rest(  # type: ignore[no-untyped-def]
    k, tracer, x, y, ox, oy, collisions, times, scales,
    moments, grids, speeds, components, distances, positions, velocities,
):  # fmt: skip
    """Enter a trapped tracer, at rest in its corner, at every output time that is left."""
    while k < times.size:
        _record(
            k, tracer, x, y, 0.0, 0.0, scales[k], ox, oy,
            collisions, 1, moments, grids, speeds, components, distances, positions, velocities,
        )  # fmt: skip
        k += 1


@njit(inline="always", error_model="numpy")
def _start(seed, configuration, tracer, monoenergetic):  # type: ignore[no-untyped-def]
    """Return the initial velocity in U: Gaussian, or of speed 1."""
    state, gamma = open_stream(seed, START, configuration, tracer)
    angle = 2.0 * np.pi * uniform(state, gamma, 0)
    speed = 1.0 if monoenergetic else sqrt(-2.0 * log(uniform(state, gamma, 1)))
    return speed * np.cos(angle), speed * np.sin(angle)


@njit(inline="always", error_model="numpy")
def _nearest(cell, x, y, ux, uy, slots, fill, head, links, nodes):  # type: ignore[no-untyped-def]
    """Return (path, impact parameter, centre) of the first scatterer of a cell that is struck."""
    path, impact, cx, cy = NEVER, 0.0, 0.0, 0.0
    for slot in range(min(fill[cell], SLOTS)):
        px, py = slots[cell, slot], slots[cell, SLOTS + slot]
        s, b = contact(px - x, py - y, ux, uy)
        if s < path:
            path, impact, cx, cy = s, b, px, py
    node = head[cell]
    while node >= 0:
        px, py = nodes[node, 0], nodes[node, 1]
        s, b = contact(px - x, py - y, ux, uy)
        if s < path:
            path, impact, cx, cy = s, b, px, py
        node = links[node]
    return path, impact, cx, cy


@njit(cache=True, nogil=True, error_model="numpy")
def follow(  # type: ignore[no-untyped-def]
    first, given, monoenergetic, seed, configuration, restitution, most, limit, times, scales,
    side, slots, fill, head, links, nodes,
    moments, totals, statuses, traps, grids, speeds, components, distances, paths,
    positions, velocities, finals,
):  # fmt: skip
    """Follow tracers first, first + 1, ... through one configuration, adding to the sums.

    given (n, 2): initial velocities, of size n in any case; NaN to draw them here. most: collision
    cap. limit: longest flight before a tracer counts as escaped. moments (n_times, MOMENTS),
    totals (2,) path and collisions, statuses (4,), traps (n, 4) tracer, time, x, y, grids (4, 2),
    histograms (n_times or 1, bins + 2) or empty, positions and velocities (n_times, n, 2) or
    empty, finals (n, 5) ln speed, ln time, x, y, collisions, or empty. Returns the number of traps.
    """
    n = round(sqrt(fill.size))
    middle = n // 2
    half = 0.5 * side
    last = times.size - 1
    caught = 0
    for tracer in range(given.shape[0]):
        ox, oy = given[tracer, 0], given[tracer, 1]
        if ox != ox:
            ox, oy = _start(seed, configuration, first + tracer, monoenergetic)
        speed = sqrt(ox * ox + oy * oy)
        ux, uy = ox / speed, oy / speed
        slowness, time, unit, shifts = 1.0 / speed, 0.0, 1.0, 0
        # i, j: cell as if the plane were not wrapped; wi, wj: as stored. x, y from its centre.
        i, j, wi, wj, x, y = 0, 0, middle, middle, 0.0, 0.0
        collisions, short, k = 0, 0, 0
        travelled = 0.0
        while True:
            # March through the cells. x, y stay at the beginning of the flight, seen from the
            # cell that the march has reached; next_x, next_y: path to the next wall of each kind.
            step_x, step_y = 1 if ux > 0.0 else -1, 1 if uy > 0.0 else -1
            pace_x = 1.0 / max(abs(ux), 1e-300)
            pace_y = 1.0 / max(abs(uy), 1e-300)
            next_x = max((half - step_x * x) * pace_x, 0.0)
            next_y = max((half - step_y * y) * pace_y, 0.0)
            left = max((times[last] * unit - time) / slowness, 0.0) if last >= 0 else NEVER
            longest = min(left, limit)
            while True:
                path, impact, cx, cy = _nearest(
                    wi * n + wj, x, y, ux, uy, slots, fill, head, links, nodes
                )
                wall = min(next_x, next_y)
                if path <= wall or wall > longest:
                    break
                if next_x <= next_y:
                    i += step_x
                    wi += step_x
                    wi = n - 1 if wi < 0 else 0 if wi == n else wi
                    x -= step_x * side
                    next_x += side * pace_x
                else:
                    j += step_y
                    wj += step_y
                    wj = n - 1 if wj < 0 else 0 if wj == n else wj
                    y -= step_y * side
                    next_y += side * pace_y
            path = max(path, 0.0) if path <= wall else NEVER
            flown = min(path, longest)
            k = _fly(
                k, tracer, NEVER if flown == left else flown, time, slowness,
                unit, i * side + x, j * side + y, ux, uy, ox, oy, collisions, times, scales,
                moments, grids, speeds, components, distances, positions, velocities,
            )  # fmt: skip
            travelled += flown
            if k > last >= 0 or path > longest:
                status = FINISHED if k > last >= 0 else ESCAPED
                x, y = x + flown * ux, y + flown * uy
                time += flown * slowness
                break
            time += path * slowness
            x, y = touch(cx, cy, ux, uy, impact)
            ux, uy, ratio = scatter(ux, uy, impact, restitution)
            collisions += 1
            if paths.size:
                _count(paths, 0, _log2(path), grids[PATH, 0], grids[PATH, 1])
            short = short + 1 if path < TRAP_LENGTH else 0
            if short == TRAP_FLIGHTS or ratio == 0.0:
                status = TRAPPED
                _rest(
                    k, tracer, i * side + x, j * side + y, ox, oy, collisions, times, scales,
                    moments, grids, speeds, components, distances, positions, velocities,
                )  # fmt: skip
                traps[caught, 0] = first + tracer
                traps[caught, 1] = time / unit
                traps[caught, 2] = i * side + x
                traps[caught, 3] = j * side + y
                caught += 1
                break
            slowness /= ratio
            if slowness > SHIFT:
                slowness /= SHIFT
                time /= SHIFT
                unit /= SHIFT
                shifts += 1
            if collisions == most:
                status = COLLISION_CAP
                break
        totals[0] += travelled
        totals[1] += collisions
        statuses[status] += 1
        if finals.size:
            finals[tracer, 0] = -log(slowness) - shifts * log(SHIFT)
            finals[tracer, 1] = (log(time) if time > 0.0 else -NEVER) + shifts * log(SHIFT)
            finals[tracer, 2] = i * side + x
            finals[tracer, 3] = j * side + y
            finals[tracer, 4] = collisions
    return caught


@njit(cache=True, nogil=True, error_model="numpy")
def follow_free_paths(  # type: ignore[no-untyped-def]
    first, given, monoenergetic, seed, configuration, restitution, most, mean_path, times, scales,
    moments, totals, statuses, grids, speeds, components, distances, paths,
    positions, velocities, finals,
):  # fmt: skip
    """Follow tracers without scatterers: exponential free paths, uniform impact parameters.

    Arguments as of `follow`; mean_path in d.
    """
    last = times.size - 1
    for tracer in range(given.shape[0]):
        ox, oy = given[tracer, 0], given[tracer, 1]
        if ox != ox:
            ox, oy = _start(seed, configuration, first + tracer, monoenergetic)
        state, gamma = open_stream(seed, FLIGHTS, configuration, first + tracer)
        speed = sqrt(ox * ox + oy * oy)
        ux, uy = ox / speed, oy / speed
        slowness, time, unit, shifts = 1.0 / speed, 0.0, 1.0, 0
        x, y = 0.0, 0.0
        collisions, k = 0, 0
        travelled = 0.0
        while True:
            path = -mean_path * log(uniform(state, gamma, 2 * collisions))
            k = _fly(
                k, tracer, path, time, slowness,
                unit, x, y, ux, uy, ox, oy, collisions, times, scales,
                moments, grids, speeds, components, distances, positions, velocities,
            )  # fmt: skip
            finished = k > last >= 0
            if finished:
                path = max((times[last] * unit - time) / slowness, 0.0)
            travelled += path
            time += path * slowness
            x += path * ux
            y += path * uy
            if finished:
                status = FINISHED
                break
            impact = 2.0 * uniform(state, gamma, 2 * collisions + 1) - 1.0
            ux, uy, ratio = scatter(ux, uy, impact, restitution)
            collisions += 1
            if paths.size:
                _count(paths, 0, _log2(path), grids[PATH, 0], grids[PATH, 1])
            slowness /= ratio
            if slowness > SHIFT:
                slowness /= SHIFT
                time /= SHIFT
                unit /= SHIFT
                shifts += 1
            if collisions == most:
                status = COLLISION_CAP
                break
        totals[0] += travelled
        totals[1] += collisions
        statuses[status] += 1
        if finals.size:
            finals[tracer, 0] = -log(slowness) - shifts * log(SHIFT)
            finals[tracer, 1] = (log(time) if time > 0.0 else -NEVER) + shifts * log(SHIFT)
            finals[tracer, 2] = x
            finals[tracer, 3] = y
            finals[tracer, 4] = collisions
    return 0

"""The density of tracers that have collided once, for starts of sharp velocities: a closed form.

Seen by a falling observer, a tracer that starts with v0 stays there until its first collision, and
stays where that takes it: the change of its velocity is

    r = v - t - v0 = -(1 + e) (v1.n) n,   v1 = v0 + tau    (t, tau along the field)

with the normal n along r. So r alone gives the time of the collision,
tau = -(r^2/(1 + e) + v0.r)/r_z, and the density of those that have collided once is

    exp(-way before - way after)/(2 (1 + e)^2 |n_z|)                 (disks)
    exp(-way before - way after)/(pi (1 + e)^2 |n_z| |r|)            (spheres)

where 0 < tau < t, and 0 elsewhere. It jumps there, and grows without limit where r vanishes.
"""

from __future__ import annotations

import math

import numpy as np

from kinetics.field.first_collision import Rays, free_way
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import gauss_legendre

_POINTS = 12  # Gauss points between two angles at which the density jumps


def once_collided(
    rays: Rays, e: float, dimension: int, time: float, along: FloatArray, across: FloatArray
) -> FloatArray:
    """The density at velocities (n,), in units of sqrt(g l).

    e : restitution. In space it is averaged over the turns about the field.
    """
    out = np.zeros(along.shape)
    x, w = gauss_legendre(_POINTS)
    for a, q, weight in zip(rays.along, rays.across, rays.weight, strict=True):
        cosine, share = np.ones((1, 1)), np.ones((1, 1))
        if dimension == 3 and q:
            ends = _turns(a, abs(q), e, time, along, np.abs(across))
            width = np.diff(ends, axis=1)[:, :, None]
            cosine = np.cos((ends[:, :-1, None] + width * x).reshape(along.size, -1))
            share = (width * w).reshape(along.size, -1) / math.pi
        elif rays.symmetric and q:
            cosine, share = np.array([[1.0, -1.0]]), np.full((1, 2), 0.5)
        found = _of_one((a, q * cosine, q * q), e, dimension, time, along, across)
        out += weight * np.sum(share * found, axis=1)
    return out


def once_collided_isotropic(
    speed: float, e: float, time: float, along: FloatArray, across: FloatArray
) -> FloatArray:
    """The same in the plane for a start of one speed and all directions alike."""
    x, w = gauss_legendre(_POINTS)
    ends = _directions(speed, e, time, along, across)
    width = np.diff(ends, axis=1)[:, :, None]
    angle = (ends[:, :-1, None] + width * x).reshape(along.size, -1)
    share = (width * w).reshape(along.size, -1) / (2.0 * math.pi)
    start = speed * np.cos(angle), speed * np.sin(angle), (speed * np.sin(angle)) ** 2
    return np.asarray(np.sum(share * _of_one(start, e, 2, time, along, across), axis=1))


def _of_one(
    start: tuple[FloatArray | float, FloatArray, FloatArray | float],
    e: float,
    dimension: int,
    time: float,
    along: FloatArray,
    across: FloatArray,
) -> FloatArray:
    """The formula of the module, (n, k), for k directions across of one start, or k starts.

    start : its components along the field and in the direction of ``across``, and the square of
        the whole component across
    """
    a, q, q_square = np.broadcast_arrays(*start)
    z, y = along[:, None], across[:, None]
    x = z - time - a
    square = x * x + y * y - 2.0 * y * q + q_square
    with np.errstate(divide="ignore", invalid="ignore"):
        tau = -(square / (1.0 + e) + a * x + q * y - q_square) / x
    there = (tau > 0.0) & (tau < time) & (square > 0.0)
    out = np.zeros(there.shape)
    shape = there.shape
    a, q_square, z, y = (np.broadcast_to(part, shape)[there] for part in (a, q_square, z, y))
    x, square, tau = x[there], square[there], tau[there]
    left = time - tau
    way = free_way(a, np.sqrt(q_square), tau) + free_way(z - left, y, left)
    if dimension == 2:
        cosine = np.abs(x) / np.sqrt(square)
        out[there] = np.exp(-way) / (2.0 * (1.0 + e) ** 2 * cosine)
    else:
        out[there] = np.exp(-way) / (math.pi * (1.0 + e) ** 2 * np.abs(x))
    return out


def _turns(
    a: float, q: float, e: float, time: float, along: FloatArray, across: FloatArray
) -> FloatArray:
    """Turns about the field, from 0 to pi, between which the density is smooth, (n, 4)."""
    x = along - time - a
    known = x * x + across**2 + q * q + (1.0 + e) * (a * x - q * q)
    ends = [np.zeros(x.shape), np.full(x.shape, math.pi)]
    with np.errstate(divide="ignore", invalid="ignore"):
        for fallen in (0.0, time):
            cosine = (known + (1.0 + e) * fallen * x) / (across * q * (1.0 - e))
            ends.append(_angle(cosine))
    return np.sort(np.stack(ends, axis=1), axis=1)


def _directions(
    speed: float, e: float, time: float, along: FloatArray, across: FloatArray
) -> FloatArray:
    """Directions of the start, from -pi to pi, between which the density is smooth, (n, 9)."""
    x = along - time
    known = x * x + across**2 - e * speed**2
    toward = np.arctan2(across, x)
    ends = [np.full(x.shape, -math.pi), np.full(x.shape, math.pi), toward]
    with np.errstate(divide="ignore", invalid="ignore"):
        ends += [_angle(x / speed), -_angle(x / speed)]
        for fallen in (0.0, time):
            b = (1.0 - e) * x + (1.0 + e) * fallen, (1.0 - e) * across
            cosine = (known + (1.0 + e) * fallen * x) / (speed * np.hypot(*b))
            for sign in (1.0, -1.0):
                angle = np.arctan2(b[1], b[0]) + sign * _angle(cosine)
                ends.append(np.arctan2(np.sin(angle), np.cos(angle)))
    return np.sort(np.stack(ends, axis=1), axis=1)


def _angle(cosine: FloatArray) -> FloatArray:
    """The angle from 0 to pi; 0 or pi where there is none."""
    return np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), -1.0, 1.0))


def once_collided_by_speed(
    rays: Rays, e: float, dimension: int, time: float, v: FloatArray
) -> FloatArray:
    """Integral of the density over all directions, times v^(d-1), at speeds (n,)."""
    out = np.zeros(v.shape)
    x, w = gauss_legendre(_POINTS)
    for k in range(rays.along.size):
        one = Rays(rays.along[k : k + 1], rays.across[k : k + 1], rays.weight[k : k + 1], False)
        ends = _jumps(float(one.along[0]), float(one.across[0]), e, time, v)
        width = np.diff(ends, axis=1)[:, :, None]
        angle = (ends[:, :-1, None] + width * x).reshape(v.size, -1)
        share = (width * w).reshape(v.size, -1)
        if dimension == 3:
            share = share * math.pi * np.abs(np.sin(angle))
        speed = np.broadcast_to(v[:, None], angle.shape)
        velocity = (speed * np.cos(angle)).ravel(), (speed * np.sin(angle)).ravel()
        found = once_collided(one, e, dimension, time, *velocity)
        out += np.sum(found.reshape(angle.shape) * share, axis=1)
    return out * v ** (dimension - 1)


def _jumps(a: float, q: float, e: float, time: float, v: FloatArray) -> FloatArray:
    """Angles from -pi to pi between which the density is smooth, rising, (n, n_angles)."""
    ends = [np.full(v.shape, -math.pi), np.full(v.shape, math.pi)]
    ends.append(np.full(v.shape, math.atan2(q, a + time)))
    with np.errstate(divide="ignore", invalid="ignore"):
        side = np.arccos(np.clip((a + time) / v, -1.0, 1.0))
        ends += [side, -side]
        # tracers that have collided at once, and those that do now, are on circles
        for fallen in (0.0, time):
            size = 0.5 * (1.0 + e) * math.hypot(a + fallen, q)
            middle = a + time - 0.5 * (1.0 + e) * (a + fallen), q - 0.5 * (1.0 + e) * q
            far = math.hypot(*middle)
            cosine = (v * v + far * far - size * size) / (2.0 * v * max(far, 1e-300))
            turn = _angle(cosine)
            for sign in (1.0, -1.0):
                angle = math.atan2(middle[1], middle[0]) + sign * turn
                ends.append(np.arctan2(np.sin(angle), np.cos(angle)))
    return np.sort(np.stack(ends, axis=1), axis=1)

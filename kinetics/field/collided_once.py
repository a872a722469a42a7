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
    rays: Rays,
    restitution: float,
    dimension: int,
    time: float,
    along: FloatArray,
    across: FloatArray,
) -> FloatArray:
    """The density at velocities (n,), in units of sqrt(g l); in space rays are along the field."""
    out = np.zeros(along.shape)
    for a, q, weight in zip(rays.along, rays.across, rays.weight, strict=True):
        signs = (1.0, -1.0) if rays.symmetric and q else (1.0,)
        for sign in signs:
            one = _of_one(float(a), sign * float(q), restitution, dimension, time, along, across)
            out += weight / len(signs) * one
    return out


def _of_one(
    a: float, q: float, e: float, dimension: int, time: float, along: FloatArray, across: FloatArray
) -> FloatArray:
    x, y = along - time - a, across - q
    square = x * x + y * y
    with np.errstate(divide="ignore", invalid="ignore"):
        tau = -(square / (1.0 + e) + a * x + q * y) / x
    there = (tau > 0.0) & (tau < time) & (square > 0.0)
    out = np.zeros(along.shape)
    x, square, tau, u, w = x[there], square[there], tau[there], along[there], across[there]
    left = time - tau
    way = free_way(np.full(tau.shape, a), np.full(tau.shape, q), tau)
    way = way + free_way(u - left, w, left)
    cosine = np.abs(x) / np.sqrt(square)
    if dimension == 2:
        out[there] = np.exp(-way) / (2.0 * (1.0 + e) ** 2 * cosine)
    else:
        out[there] = np.exp(-way) / (math.pi * (1.0 + e) ** 2 * np.abs(x))
    return out


def once_collided_by_speed(
    rays: Rays, restitution: float, dimension: int, time: float, v: FloatArray
) -> FloatArray:
    """Integral of the density over all directions, times v^(d-1), at speeds (n,)."""
    out = np.zeros(v.shape)
    x, w = gauss_legendre(_POINTS)
    for k in range(rays.along.size):
        one = Rays(rays.along[k : k + 1], rays.across[k : k + 1], rays.weight[k : k + 1], False)
        ends = _jumps(float(one.along[0]), float(one.across[0]), restitution, time, v)
        width = np.diff(ends, axis=1)[:, :, None]
        angle = (ends[:, :-1, None] + width * x).reshape(v.size, -1)
        share = (width * w).reshape(v.size, -1)
        if dimension == 3:
            share = share * math.pi * np.abs(np.sin(angle))
        speed = np.broadcast_to(v[:, None], angle.shape)
        velocity = (speed * np.cos(angle)).ravel(), (speed * np.sin(angle)).ravel()
        found = once_collided(one, restitution, dimension, time, *velocity)
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
            turn = np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), -1.0, 1.0))
            for sign in (1.0, -1.0):
                angle = math.atan2(middle[1], middle[0]) + sign * turn
                ends.append(np.arctan2(np.sin(angle), np.cos(angle)))
    return np.sort(np.stack(ends, axis=1), axis=1)

"""A slow, obvious simulator in a field: one tracer, all disks and images, sliding by an ODE solver.

It shares nothing with the package: contacts are the roots of a quartic from the eigenvalues of its
companion matrix, a slide is two coordinates and their velocities held on a circle by a force, and
everything is looked at for all disks.
"""

import numpy as np
from scipy.integrate import solve_ivp

SMALL = 1e-12


def follow(
    disks: np.ndarray, box: float, velocity: np.ndarray, law: tuple[float, float],
    times: np.ndarray,
) -> list[np.ndarray]:  # fmt: skip
    """Return the places (2,) of a tracer from the origin at these times, as long as it moves.

    law: restitution and field. The list ends, too, where it nearly rests in a corner.
    """
    e, g = law
    shifts = box * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), axis=-1).reshape(-1, 1, 2)
    every = (disks + shifts).reshape(-1, 2)
    r, v, t = np.zeros(2), np.array(velocity, float), 0.0
    down = np.array([g, 0.0])
    places: list[np.ndarray] = []
    on = -1
    while True:
        assert np.all(abs(r) < box), "the tracer has left the images"
        next_time, next_disk = first_contact(every, r, v, g, on)
        while len(places) < len(times) and times[len(places)] <= t + next_time:
            s = times[len(places)] - t
            places.append(r + v * s + down * s * s / 2)
        if len(places) == len(times):
            return places
        r, v, t = r + v * next_time + down * next_time**2 / 2, v + down * next_time, t + next_time
        on = next_disk
        n = (r - every[on]) / np.linalg.norm(r - every[on])
        v = v - (1 + e) * min(v @ n, 0.0) * n
        while is_pressed(n, v, g):
            r, v, t, met = slide(every, on, r, v - (v @ n) * n, t, g, times, places)
            if len(places) == len(times):
                return places
            if met < 0:
                break
            on, n, v = in_corner((r - every[on], on), (r - every[met], met), v, law)
            if v @ v < 1e-8 * abs(g):
                return places


def first_contact(every: np.ndarray, r: np.ndarray, v: np.ndarray, g: float, on: int) -> tuple:
    best, disk = np.inf, -1
    for k, centre in enumerate(every):
        x, y = r - centre
        terms = [g * g / 4, g * v[0], v @ v + g * x, 2 * (x * v[0] + y * v[1]), x * x + y * y - 1]
        roots = np.roots(terms[:4] if k == on else terms)
        for t in np.sort(roots.real[(abs(roots.imag) < 1e-7) & (roots.real > 1e-9)]):
            slope = np.polyval(np.polyder(terms), t)
            if t < best and slope < 0:
                for _ in range(3):
                    t -= np.polyval(terms, t) / np.polyval(np.polyder(terms), t)
                best, disk = t, k
                break
    return best, disk


def is_pressed(n: np.ndarray, v: np.ndarray, g: float) -> bool:
    normal = v @ n
    pressing = -g * n[0] - (v @ v - normal**2)
    return pressing > 0 and normal**2 / (2 * pressing) < SMALL


def slide(
    every: np.ndarray, on: int, r: np.ndarray, v: np.ndarray, t: float, g: float,
    times: np.ndarray, places: list[np.ndarray],
) -> tuple:  # fmt: skip
    """Return place, velocity, time at the end of a slide, and the disk met there or -1."""
    others = [k for k in range(len(every)) if 0 < np.linalg.norm(every[k] - every[on]) < 2]

    def rate(_t: float, state: np.ndarray) -> np.ndarray:
        n = state[:2] - every[on]
        force = (g * n[0] + state[2:] @ state[2:]) / (n @ n)
        return np.array([*state[2:], g - force * n[0], -force * n[1]])

    def pressing(_t: float, state: np.ndarray) -> float:
        return -g * (state[0] - every[on][0]) - state[2:] @ state[2:]

    def gap(k: int):
        def at(_t: float, state: np.ndarray) -> float:
            d = state[:2] - every[k]
            # Only on the way towards the disk.
            return 1.0 if d @ state[2:] > 0 else d @ d - 1

        return at

    events = [pressing] + [gap(k) for k in others]
    for event in events:
        event.terminal, event.direction = True, -1
    state = np.concatenate([r, v])
    blocked = [k for k in others if gap(k)(0.0, state) < 1e-12]
    if blocked:
        return r, v, t, blocked[0]
    found = solve_ivp(
        rate, (t, times[-1]), state, "DOP853", events=events, rtol=1e-13, atol=1e-13,
        dense_output=True, max_step=0.05 / np.sqrt(abs(g)),
    )  # fmt: skip
    while len(places) < len(times) and times[len(places)] <= found.t[-1]:
        places.append(found.sol(times[len(places)])[:2])
    met = [k for k, when in enumerate(found.t_events) if len(when)]
    state = found.y[:, -1]
    which = -1 if not met or met[0] == 0 else others[met[0] - 1]
    return state[:2], state[2:], found.t[-1], which


def in_corner(one: tuple, other: tuple, v: np.ndarray, law: tuple[float, float]) -> tuple:
    """Return disk, normal and velocity after the bounces of no duration between two disks."""
    e, _ = law
    walls = [(n / np.linalg.norm(n), k) for n, k in (other, one)]
    begun = np.linalg.norm(v)
    for turn in range(2000):
        n, k = walls[turn % 2]
        if v @ n > -1e-14 * np.linalg.norm(v) and turn:
            return walls[(turn - 1) % 2][1], walls[(turn - 1) % 2][0], v
        v = v - (1 + e) * (v @ n) * n
        if np.linalg.norm(v) < 1e-12 * begun:
            return k, n, 0 * v
    raise AssertionError("bounces that do not end")

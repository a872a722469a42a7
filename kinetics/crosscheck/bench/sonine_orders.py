"""The Sonine expansion to any order, as a method among others: a miss is a ValueError."""

from __future__ import annotations

from kinetics.sonine.series import FloatArray, SeriesStatus, SonineState, cooling, scaled_state


def solve_scaled(restitution: float, order: int) -> SonineState:
    """The scaled equation at this order; ValueError where it has no real solution."""
    state = scaled_state(restitution, order)
    if state.status is not SeriesStatus.REAL:
        raise ValueError(f"order = {order}: no real solution at restitution {restitution:g}")
    return state


def solve_cooling(
    restitution: float,
    mean_free_path: float,
    initial: str,
    times: FloatArray,
    order: int,
    rtol: float,
) -> tuple[FloatArray, FloatArray]:
    """v0(t) in U and a2(t), from a "gaussian" or a "monoenergetic" start; ValueError on failure."""
    found = cooling(restitution, times, order, mean_free_path, initial, rtol)
    if found.status is not SeriesStatus.REAL:
        raise ValueError(f"order = {order}: {found.status.value}")
    return found.thermal_speed, found.a2

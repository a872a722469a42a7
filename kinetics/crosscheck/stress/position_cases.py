"""Cases of the position: extreme restitutions, times, starts and scales."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome, named
from kinetics.crosscheck.stress.solver_cases import FEWER, RESTITUTIONS, TIMES, label_of, starts

_PATH = 12.5  # l at the default density, in d


def position_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    for e in FEWER if quick else RESTITUTIONS:
        for label in ("gaussian", "beam") if quick else starts():
            for rtol in (1e-9,) if quick else (1e-3, 1e-9, 1e-12):
                name = f"{label_of(e)}, {label}, t to 1e300, rtol {rtol:.0e}"
                yield named("moments of position", name, _moments, e, label, rtol)
        for scale in (1e-100, 1e100):
            name = f"{label_of(e)}, gaussian, speeds times {scale:g}"
            yield named("moments of position", name, _scaled, e, scale)
    few = (0.2, 0.7, 1.0 - 1e-6, 1.0)
    for e in few if quick else (0.0, 0.01, *few, 1.0 - 1e-10):
        for label in ("gaussian",) if quick else ("gaussian", "monoenergetic", "two delta peaks"):
            for t in (1e3, 1e30) if quick else (1e2, 1e3, 1e8, 1e30):
                name = f"{label_of(e)}, {label}, t = {t:g}"
                yield named("position density", name, _density, e, label, t, 1e-3)


def _slope(e: float) -> float:
    """d<r^2>/d ln t of late times in l^2, in high precision: 2/(kappa (1 - <cos chi>))."""
    import mpmath as mp

    with mp.workdps(60):
        e_ = mp.mpf(e)
        b = mp.sqrt(1 - e_**2)
        kappa = 1 - e_ * mp.acos(e_) / b
        turn = e_ * mp.atanh(b) / b if e else mp.mpf(0)
        cosine = -turn + (1 - e_ * turn) / (2 * (1 - e_))
        return float(2 / (kappa * (1 - cosine)))


def _moments(e: float, label: str, rtol: float) -> Outcome:
    """The late slope, and bounds that any motion keeps."""
    from kinetics import Scene, solve

    outputs: tuple[str, ...] = ("msd", "velocity_autocorrelation", "diffusion_coefficient")
    if label != "tail v^-6":  # it has no fourth moment
        outputs = (*outputs, "kurtosis", "mean_displacement")
    times = TIMES[TIMES < 1e200] if e == 1.0 else TIMES
    found = solve(Scene(e, initial=starts()[label], times=times, outputs=outputs), rtol)
    reached = math.nan
    if e < 1.0 and label in ("gaussian", "beam", "monoenergetic"):
        reached = abs(found.msd_slope[-1] / _PATH**2 / _slope(e) - 1.0)
    if not all(np.all(np.isfinite(value)) for value in found.values.values()):
        reached = math.inf
    start = float(found.velocity_autocorrelation[0])  # <v(0)^2>
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        ballistic = np.nan_to_num(found.msd / (start * times * times), nan=0.0, posinf=0.0)
        fall = -np.diff(found.msd) / np.maximum(found.msd[1:], 1e-300)
        drift = np.nan_to_num(np.abs(found.velocity_autocorrelation) / start - 1.0)
    slack = 10.0 * rtol + 1e-12
    invariants = {
        "<r^2> <= <v^2> t^2": (max(0.0, float(ballistic[times > 1e-100].max() - 1.0)), slack),
        "<r^2> grows": (max(0.0, float(fall.max())), slack),
        "|<v(0).v>| <= <v^2>": (max(0.0, float(drift.max())), slack),
        "D not negative": (max(0.0, -float(found.diffusion_coefficient.min())), 0.0),
    }
    if "kurtosis" in outputs:
        invariants["kurtosis >= 1"] = (max(0.0, 1.0 - float(found.kurtosis.min())), slack)
    return Outcome(
        asked=rtol + 1e-13,
        reached=reached,
        converged=found.status.name == "CONVERGED",
        invariants=invariants,
    )


def _scaled(e: float, scale: float) -> Outcome:
    """Speeds times a scale are times divided by it."""
    from kinetics import Gaussian, Scene, solve

    outputs = ("msd", "kurtosis")
    times = np.geomspace(1e-3, 1e8, 12)
    one = solve(Scene(e, times=times, outputs=outputs), 1e-10)
    start = Gaussian(scale, scale)
    other = solve(Scene(e, initial=start, times=times / scale, outputs=outputs), 1e-10)
    apart = [np.abs(getattr(other, name) / getattr(one, name) - 1.0).max() for name in outputs]
    return Outcome(asked=1e-10, reached=float(max(apart)))


def _density(e: float, label: str, t: float, rtol: float) -> Outcome:
    """Norm and second moment of G(R), and its sign."""
    from kinetics import Scene, solve

    scene = Scene(e, initial=starts()[label], times=[t], outputs=("msd", "position_density"))
    found = solve(scene, rtol)
    edges = np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)])
    x, w = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(edges)[:, None]
    r, weight = (edges[:-1, None] + half * (1.0 + x)).ravel(), (half * w).ravel()
    g = found.scaled_position_density(r)[0]
    front, share = found.ballistic_front
    peaks: Any = np.sum(share), np.sum(share * (front / math.sqrt(found.msd[0])) ** 2)
    norm, second = (float(g @ (weight * r**p)) + q for p, q in zip((0, 2), peaks, strict=True))
    claimed = max(rtol, found.error_estimate)
    return Outcome(
        asked=rtol,
        reached=abs(norm - 1.0) if np.all(np.isfinite(g)) else math.inf,
        converged=found.status.name == "CONVERGED",
        invariants={
            "<R^2> = 1": (abs(second - 1.0), 100.0 * claimed),
            "G not negative": (max(0.0, -float(g.min())), claimed),
        },
    )

"""Cases of the position: extreme restitutions, times, starts and scales."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from kinetics.crosscheck.stress.case import Case, Outcome
from kinetics.crosscheck.stress.limits import (
    FEWER,
    REFERENCE_SHARE,
    RESTITUTIONS,
    TIMES,
    FloatArray,
    Law,
    above,
    as_law,
    below,
    finite,
    forgets,
    label_of,
    other_laws,
    scaling,
)
from kinetics.crosscheck.stress.starts import solve_start, starts
from kinetics.numerics.gauss import panels_between


def position_cases(quick: bool) -> Iterator[Case]:
    """All of them, in groups."""
    labels = ("gaussian", "beam") if quick else starts()
    for e in FEWER if quick else RESTITUTIONS:
        for label in labels:
            for rtol in (1e-9,) if quick else (1e-3, 1e-9, 1e-12):
                name = f"{label_of(e)}, {label}, t to 1e300, rtol {rtol:.0e}"
                yield Case("moments of position", name, _moments, (e, label, rtol))
    for law in other_laws(quick):
        for label in ("gaussian", "beam"):
            name = f"{label_of(law)}, {label}, t to 1e300, rtol 1e-09"
            yield Case("moments of position", name, _moments, (law, label, 1e-9))
            for t in (1.0,) if quick else (1e-300, 1.0, 1e3):
                name = f"{label_of(law)}, {label}, t = {t:g}"
                yield Case("scattering function", name, _scattering, (law, label, t))
        for t in (1e3,) if quick else (1e-300, 1e2, 1e3, 1e8):
            for label in ("gaussian",) if quick else ("gaussian", "monoenergetic"):
                name = f"{label_of(law)}, {label}, t = {t:g}"
                yield Case("position density", name, _density, (law, label, t, 1e-3))
    few = (0.2, 0.7, 1.0 - 1e-10, 1.0)
    for e in few if quick else (0.0, 1e-10, 0.01, *few, 1.0 - 1e-6):
        for label in ("gaussian",) if quick else ("gaussian", "monoenergetic", "two delta peaks"):
            for t in (1e-300, 1e3, 1e300) if quick else (1e-300, 1e-10, 1e2, 1e3, 1e8, 1e30, 1e300):
                name = f"{label_of(e)}, {label}, t = {t:g}"
                yield Case("position density", name, _density, (e, label, t, 1e-3))
    for e in few if quick else (0.0, 1e-10, *few, 1.0 - 1e-6):
        for label in ("gaussian", "beam"):
            for t in (0.0, 1e-300, 1.0, 1e3, 1e300):
                name = f"{label_of(e)}, {label}, t = {t:g}"
                yield Case("scattering function", name, _scattering, (e, label, t))


def _moments(e: Law, label: str, rtol: float) -> Outcome:
    """The late slope, and bounds that any motion keeps."""
    outputs: tuple[str, ...] = ("msd", "velocity_autocorrelation", "diffusion_coefficient")
    if label != "tail v^-6":  # it has no fourth moment
        outputs = (*outputs, "kurtosis", "mean_displacement", "mean_velocity", "velocity_tensor")
    elastic = as_law(e).is_elastic
    times = TIMES[TIMES < 1e200] if elastic else TIMES
    found = solve_start(e, label, times, outputs, rtol)
    reached = math.nan
    if not elastic and forgets(found.scene.law):
        reached = abs(found.msd_slope[-1] / found.scene.mean_free_path**2 / scaling(e)[3] - 1.0)
    if not finite(*found.values.values()):
        reached = math.inf
    start = float(found.velocity_autocorrelation[0])  # <v(0)^2>
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        ballistic = np.nan_to_num(found.msd / (start * times * times), nan=0.0, posinf=0.0)
        fall = -np.diff(found.msd) / np.maximum(found.msd[1:], 1e-300)
        drift = np.nan_to_num(np.abs(found.velocity_autocorrelation) / start)
    slack = 10.0 * rtol + 1e-12
    invariants = {
        "<r^2> <= <v^2> t^2": (above(ballistic[times > 1e-100]), slack),
        "<r^2> grows": (above(fall, 0.0), slack),
        "|<v(0).v>| <= <v^2>": (above(drift), slack),
    }
    law = found.scene.law
    # bounces that throw tracers back and nearly stop them make D negative
    if law.tangential_restitution == 1.0 or law.mean_cosine >= 0.0:
        invariants["D not negative"] = (below(found.diffusion_coefficient), 0.0)
    if "kurtosis" in outputs:
        invariants["kurtosis >= 1"] = (below(found.kurtosis, 1.0), slack)
        invariants |= _directed(found, times, slack)
    return Outcome(
        asked=rtol + 1e-13,
        reached=reached,
        converged=found.status.name == "CONVERGED",
        invariants=invariants,
    )


def _directed(found: Any, times: Any, slack: float) -> dict[str, tuple[float, float]]:
    """What mean velocity, mean displacement and tensor must keep, of any start."""
    tensor, mean, place = found.velocity_tensor, found.mean_velocity, found.mean_displacement
    trace = np.trace(tensor, axis1=1, axis2=2)
    seen = trace > 1e-290  # rounded numbers below
    with np.errstate(all="ignore"):
        scaled = tensor[seen] / trace[seen, None, None]
        speed = (mean[seen] ** 2).sum(axis=1) / trace[seen]
        far = (place**2).sum(axis=1) / found.msd
    far = np.nan_to_num(far, nan=0.0, posinf=0.0)[times > 1e-100]
    return {
        "<v v> positive": (below(np.linalg.eigvalsh(scaled)), slack),
        "<v>^2 <= <v^2>": (above(speed), slack),
        "<r>^2 <= <r^2>": (above(far), slack),
    }


def _density(e: Law, label: str, t: float, rtol: float) -> Outcome:
    """G(R) against a tighter one; its norm, second moment, sign and ends.

    Where the tighter one is not known well enough, the norm alone remains.
    """
    found = solve_start(e, label, [t], ("msd", "position_density"), rtol)
    front, share = found.ballistic_front
    front, share = front[share > 0.0], share[share > 0.0]
    if found.msd[0] > 1e-290:
        front = front / math.sqrt(found.msd[0])
    else:  # all fly freely
        gaussian = float(as_law(e).dimension)
        second = {"two delta peaks": 0.5 * (1.0 + 1e-4), "monoenergetic": 1.0}.get(label, gaussian)
        front = front / t / math.sqrt(second)
    r, weight = _nodes_towards(front, as_law(e).restitution or 0.0)
    g = found.scaled_position_density(r)[0]
    peaks: Any = np.sum(share), np.sum(share * front**2)
    norm, second = (float(g @ (weight * r**p)) + q for p, q in zip((0, 2), peaks, strict=True))
    ends = found.scaled_position_density([0.0, 1e300])[0]
    fraction = found.position_fraction([0.0, 1e300])[0, 0] if not as_law(e).is_elastic else 1.0
    claimed = max(rtol, found.error_estimate)
    finer = solve_start(e, label, [t], ("msd", "position_density"), 0.01 * rtol)
    known = finer.error_estimate <= REFERENCE_SHARE * rtol
    # at the same r, in units of the same length; and not as near to the fronts, where G(R) of
    # sharp speeds may be infinite
    apart, _ = _nodes_towards(front[:0], 0.0)
    unit = math.sqrt(found.msd[0] / finer.msd[0]) if found.msd[0] > 1e-290 else 1.0
    tight = unit * finer.scaled_position_density(unit * apart)[0]
    difference = np.max(np.abs(found.scaled_position_density(apart)[0] - tight)) if known else 0.0
    return Outcome(
        asked=rtol,
        reached=max(abs(norm - 1.0), float(difference)) if finite(g) else math.inf,
        converged=found.status.name == "CONVERGED",
        in_part=not known,
        invariants={
            "<R^2> = 1": (abs(second - 1.0), 100.0 * claimed),
            "G not negative": (below(g), claimed),
            "G(0) = G(infinity) = 0": (float(np.max(np.abs(ends))), claimed),
            "all are somewhere": (abs(fraction - 1.0), 10.0 * claimed),
        },
        note=f"estimate {found.error_estimate:.0e}",
    )


def _nodes_towards(front: FloatArray, ratio: float) -> tuple[FloatArray, FloatArray]:
    """Gauss points R (n,) and weights, dense where G(R) of sharp speeds is singular.

    That is at the fronts, and at those of head-on collisions, ``ratio`` times as far.
    """
    edges = np.concatenate([[0.0], np.geomspace(1e-2, 30.0, 60)])
    near = 2.0 ** -np.arange(1.0, 40.0)
    for place in (*front, *(ratio * front)):
        edges = np.union1d(edges, place * np.concatenate([1.0 - near, [1.0], 1.0 + near]))
    return panels_between(edges, 12)


def _scattering(e: Law, label: str, t: float) -> Outcome:
    """F at k = 0, for small k and in free flight, and that it is no larger than 1."""
    from scipy.special import j0

    from kinetics import ToleranceWarning

    rtol = 1e-9
    law = as_law(e)
    msd = "msd" if not law.is_elastic or t < 1e200 else "thermal_speed"
    found = solve_start(e, label, [t], ("intermediate_scattering", msd), rtol)
    width = math.sqrt(found.msd[0]) if msd == "msd" else math.inf
    # F = 1 - k^2 <r^2>/(2 d) + ..., whose next term is of order (k^2 <r^2>)^2
    small = 1e-4 / max(1.0, width)
    k = np.array([0.0, 1e-300, 1e-150, small, 1e-3, 0.1, 2.0])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("error")
        warnings.simplefilter("always", ToleranceWarning)
        F = found.intermediate_scattering(k)[0]
        along = found.intermediate_scattering(k, direction=0.3)[0]
    expected = [1.0, 1.0] + ([1.0] if width < 1e100 else [])
    if math.isfinite(width):
        expected += [1.0 - (small * width) ** 2 / (2.0 * law.dimension)]
    reached = max(abs(F[i] - value) for i, value in enumerate(expected))
    if t <= 1e-12 / found.scene.mean_free_path:
        wave = j0(k * t) if law.dimension == 2 else np.sinc(k * t / math.pi)
        free = np.exp(-0.5 * (k * t) ** 2) if label == "gaussian" else wave
        reached = max(reached, float(np.max(np.abs(F - free))))
    return Outcome(
        asked=10.0 * rtol,
        reached=float(reached) if finite(F, along) else math.inf,
        converged=found.status.name == "CONVERGED" and not said,
        in_part=True,  # nothing is known of k l of order 1
        invariants={"|F| <= 1": (above(np.abs([F, along])), 10.0 * rtol)},
    )

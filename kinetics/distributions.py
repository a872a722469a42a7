"""The densities of a scene that its outputs need: of the velocity, and of the displacement.

`kinetics.solver` begins here, and so does a Solution that does not have them, as after loading.
"""

from __future__ import annotations

import numpy as np

from kinetics.averaging import in_range
from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.moments.displacement import root_mean_square
from kinetics.moments.velocity import Averages
from kinetics.outputs import DENSITIES, OUTPUTS, POSITION
from kinetics.position.density import Displacement
from kinetics.position.sweep import solve_displacement
from kinetics.scene import Scene
from kinetics.validation import refuse

BEST_DENSITY = 1e-8  # of G(R): more takes wave numbers that cost minutes
_DISPLACEMENT_SHARE = 0.4  # of the tolerance of G(R) that its transform may use


def displacement_of(averages: Averages, outputs: tuple[str, ...]) -> Displacement | None:
    """The distribution of the displacement, if an output needs it."""
    if not any(OUTPUTS[name].step == POSITION for name in outputs):
        return None
    root = in_range("msd", root_mean_square(averages))
    rtol = _DISPLACEMENT_SHARE * max(averages.rtol, BEST_DENSITY)
    path = averages.mean_free_path
    return solve_displacement(averages.law, path, averages.state, averages.times, root, rtol)


def profiles_of(
    scene: Scene, rtol: float, method: str | None, nodes: int | None
) -> dict[int, Profile]:
    """The harmonics of the velocity distribution that the outputs need."""
    if not any(OUTPUTS[name].step == DENSITIES for name in scene.outputs):
        return {}
    highest = 0
    if "velocity_density" in scene.outputs:
        there = scene.state.highest_harmonic
        highest = scene.harmonics if there is None else min(there, scene.harmonics)
    found = {m: _profile(scene, m, rtol, method, nodes) for m in range(highest + 1)}
    return {m: profile for m, profile in found.items() if profile is not None}


def _profile(
    scene: Scene, m: int, rtol: float, method: str | None, nodes: int | None
) -> Profile | None:
    """Harmonic m by the method asked for, or the best one; None where the start makes it zero."""
    law, state = scene.law, scene.state
    asked = HarmonicProblem(
        law, scene.mean_free_path, state, m, np.asarray(scene.times), rtol, nodes
    )
    if state.harmonic(m, rtol) is None:
        return None
    if law.is_elastic:
        from kinetics.densities.harmonic import elastic_profile

        return elastic_profile(asked)
    if method != "conservative" and (state.smooth or method == "spectral"):
        from kinetics.densities.spectral import solve_spectral

        profile = solve_spectral(asked)
        if profile is not None:
            return profile
        if method == "spectral":
            allowed = "this initial state is too rough for it, use method='conservative'"
            refuse("method", method, allowed)
    from kinetics.densities.conservative import solve_conservative

    return solve_conservative(asked)

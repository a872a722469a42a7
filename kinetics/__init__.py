"""The inelastic Lorentz equation on a discretised velocity space.

Units: lengths in scatterer diameters d, speeds in U, times in d/U. Names are loaded at first use,
so that `lorentz --help` costs neither numpy nor scipy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.collision import CollisionLaw
    from kinetics.errors import InputError, ToleranceWarning
    from kinetics.scaling.closed_form import ScalingSolution
    from kinetics.scaling.scaled_vdf import ScaledVDF, SolverStatus, solve_scaled
    from kinetics.scene import Scene
    from kinetics.solution import Solution
    from kinetics.solver import solve
    from kinetics.states.directed import AngularHarmonics, Beam, PolarGrid, VelocitySamples
    from kinetics.states.isotropic import (
        Gaussian,
        Monoenergetic,
        SpeedDensity,
        SpeedSamples,
        SpeedTable,
    )

_HOMES = {
    "collision": ("CollisionLaw",),
    "errors": ("InputError", "ToleranceWarning"),
    "scaling.closed_form": ("ScalingSolution",),
    "scaling.scaled_vdf": ("ScaledVDF", "SolverStatus", "solve_scaled"),
    "scene": ("Scene",),
    "solution": ("Solution",),
    "solver": ("solve",),
    "states.directed": ("AngularHarmonics", "Beam", "PolarGrid", "VelocitySamples"),
    "states.isotropic": (
        "Gaussian",
        "Monoenergetic",
        "SpeedDensity",
        "SpeedSamples",
        "SpeedTable",
    ),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "AngularHarmonics",
    "Beam",
    "CollisionLaw",
    "Gaussian",
    "InputError",
    "Monoenergetic",
    "PolarGrid",
    "ScaledVDF",
    "ScalingSolution",
    "Scene",
    "Solution",
    "SolverStatus",
    "SpeedDensity",
    "SpeedSamples",
    "SpeedTable",
    "ToleranceWarning",
    "VelocitySamples",
    "solve",
    "solve_scaled",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"kinetics.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)

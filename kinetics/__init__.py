"""The inelastic Lorentz equation on a discretised velocity space.

Units: lengths in scatterer diameters d, speeds in U, times in d/U. Names are loaded at first use,
so that `lorentz --help` costs neither numpy nor scipy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics.collision import CollisionLaw
    from kinetics.directed import AngularHarmonics, Beam, PolarGrid, VelocitySamples
    from kinetics.errors import InputError, ToleranceWarning
    from kinetics.exact import ScalingSolution
    from kinetics.initial import Gaussian, Monoenergetic, SpeedDensity, SpeedSamples, SpeedTable
    from kinetics.scaled import ScaledVDF, SolverStatus, solve_scaled
    from kinetics.scene import Scene
    from kinetics.solution import Solution
    from kinetics.solver import solve

_HOMES = {
    "AngularHarmonics": "directed",
    "Beam": "directed",
    "CollisionLaw": "collision",
    "Gaussian": "initial",
    "InputError": "errors",
    "Monoenergetic": "initial",
    "PolarGrid": "directed",
    "ScaledVDF": "scaled",
    "ScalingSolution": "exact",
    "Scene": "scene",
    "Solution": "solution",
    "SolverStatus": "scaled",
    "SpeedDensity": "initial",
    "SpeedSamples": "initial",
    "SpeedTable": "initial",
    "ToleranceWarning": "errors",
    "VelocitySamples": "directed",
    "solve": "solver",
    "solve_scaled": "scaled",
}

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
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"kinetics.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)

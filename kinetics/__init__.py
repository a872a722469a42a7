"""The inelastic Lorentz equation on a discretised velocity space.

Units: lengths in scatterer diameters d, speeds in U, times in d/U. Names are loaded at first use,
so that `lorentz --help` costs neither numpy nor scipy.

Rooms, each of which imports only those before it: `numerics` (no physics), `collision` (the law of
one bounce), `states` (initial states) and `scaling` (the scaled distribution), `moments`
(averages), `densities` (of the velocity), `position` (of the displacement) and `field` (the
equation in a uniform field). Then the modules of
this folder: `outputs` and `scene` say what can be asked, `solver` solves it, `solution` is the
answer. `results` (values, datasets, plots and files), `status`, `errors` and `validation` serve all
of them. `paper` (also `sonine`) holds the paper's approximations; `crosscheck` compares with
particles and algebra. Begin reading with `solver.solve`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetics import paper as sonine
    from kinetics.collision import CollisionLaw
    from kinetics.errors import InputError, ToleranceWarning
    from kinetics.field.solution import FieldState, solve_field
    from kinetics.results import load
    from kinetics.scaling.closed_form import ScalingSolution
    from kinetics.scaling.scaled_vdf import ScaledVDF, solve_scaled
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
    from kinetics.status import SolverStatus

_HOMES = {
    "collision": ("CollisionLaw",),
    "collision.bounce": ("SampledBounce",),
    "crosscheck": ("Comparison",),
    "errors": ("InputError", "ToleranceWarning"),
    "field.solution": ("FieldState", "FieldUnits", "solve_field"),
    "moments.by_collision": ("ByCollision",),
    "results": ("load",),
    "scaling.closed_form": ("ScalingSolution",),
    "scaling.scaled_vdf": ("ScaledVDF", "solve_scaled"),
    "scene": ("Scene",),
    "solution": ("Solution",),
    "solver": ("solve",),
    "states.directed": ("AngularHarmonics", "Beam", "PolarGrid", "VelocitySamples"),
    "states.isotropic": (
        "Gaussian",
        "Maxwell",
        "Monoenergetic",
        "Rest",
        "SpeedDensity",
        "SpeedSamples",
        "SpeedTable",
    ),
    "status": ("PlanStep", "SolverStatus"),
}
# Every public class is here, also those that are not shown: a file may hold any of them.
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "AngularHarmonics",
    "Beam",
    "CollisionLaw",
    "FieldState",
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
    "__version__",
    "compare",
    "fit",
    "load",
    "solve",
    "solve_field",
    "solve_scaled",
    "sonine",
]


def __getattr__(name: str) -> Any:
    value: Any
    if name == "__version__":
        value = import_module("kinetics.version").package_version()
    elif name == "sonine":
        value = import_module("kinetics.paper")
    elif name in ("compare", "fit"):
        value = getattr(import_module("kinetics.crosscheck"), f"{name}_data")
    elif name in _HOME_OF:
        value = getattr(import_module(f"kinetics.{_HOME_OF[name]}"), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)

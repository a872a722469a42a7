"""The inelastic Lorentz equation on a discretised velocity space.

Units: lengths in scatterer diameters d, speeds in U, times in d/U. Names are loaded at first use,
so that `lorentz --help` costs neither numpy nor scipy.

Rooms, each of which imports only those before it: `numerics` (no physics), `collision` (the law of
one bounce), `states` (initial states) and `scaling` (the scaled distribution), `moments`
(averages), `densities` (of the velocity), `position` (of the displacement) and `driven` (fields,
baths, noise, drag, a restitution that depends on the speed). Then the modules of this folder:
`drive` says what drives a tracer, `outputs` and `scene` what can be asked; `solving` has `solve`,
`answer` chooses the solver of a scene, and `solution` is what is returned: begin reading with
`solving`. `results` (values, datasets, plots and files), `errors` and `validation` serve all of
them. `paper` (also `sonine`) holds the paper's approximations; `crosscheck` compares with particles
and algebra.
"""

from typing import TYPE_CHECKING, Any

from kinetics.names import IMPORTING, PUBLIC_NAMES, import_named

if TYPE_CHECKING:
    from kinetics import paper as sonine  # noqa: F401
    from kinetics.collision import CollisionLaw as CollisionLaw
    from kinetics.collision.impact import Viscoelastic as Viscoelastic
    from kinetics.crosscheck.compare import compare_data as compare  # noqa: F401
    from kinetics.crosscheck.compare import fit_data as fit  # noqa: F401
    from kinetics.driven.driven_state import DrivenState as DrivenState
    from kinetics.driven.driven_state import solve_steady as solve_steady
    from kinetics.driven.field_state import FieldState as FieldState
    from kinetics.driven.field_state import solve_field as solve_field
    from kinetics.errors import InputError as InputError
    from kinetics.errors import ModelWarning as ModelWarning
    from kinetics.errors import SolverStatus as SolverStatus
    from kinetics.errors import ToleranceWarning as ToleranceWarning
    from kinetics.loading import load as load
    from kinetics.scaling.closed_form import ScalingSolution as ScalingSolution
    from kinetics.scaling.scaled_vdf import ScaledVDF as ScaledVDF
    from kinetics.scaling.scaled_vdf import solve_scaled as solve_scaled
    from kinetics.scene import Scene as Scene
    from kinetics.solution import Solution as Solution
    from kinetics.solving import solve as solve
    from kinetics.solving import sweep as sweep
    from kinetics.states.kinds import AngularHarmonics as AngularHarmonics
    from kinetics.states.kinds import Beam as Beam
    from kinetics.states.kinds import Gaussian as Gaussian
    from kinetics.states.kinds import Monoenergetic as Monoenergetic
    from kinetics.states.kinds import PolarGrid as PolarGrid
    from kinetics.states.kinds import SpeedDensity as SpeedDensity
    from kinetics.states.kinds import SpeedSamples as SpeedSamples
    from kinetics.states.kinds import SpeedTable as SpeedTable
    from kinetics.states.kinds import VelocitySamples as VelocitySamples

__all__ = sorted([*PUBLIC_NAMES, "__version__", "sonine"])


def __getattr__(name: str) -> Any:
    value: Any
    if name == "__version__":
        from kinetics.version import package_version

        value = package_version()
    elif name == "sonine":
        from importlib import import_module

        with IMPORTING:
            import_module("numpy")
            value = import_module("kinetics.paper")
    elif name in PUBLIC_NAMES:
        value = import_named(name)
    else:
        from kinetics.errors import suggestion

        near = "" if name.startswith("_") else suggestion(name, __all__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{near}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__

"""Where the public names of `kinetics`, and the classes that files hold, are defined.

Modules are imported at first use, so that `import kinetics` and `lorentz --help` load neither NumPy
nor SciPy.
"""

from importlib import import_module
from threading import RLock

#: Public name -> the module of `kinetics` that defines it, and its name there if that is another.
PUBLIC_NAMES = {
    "AngularHarmonics": "states.kinds",
    "Beam": "states.kinds",
    "CollisionLaw": "collision",
    "DrivenState": "driven.driven_state",
    "FieldState": "driven.field_state",
    "Gaussian": "states.kinds",
    "InputError": "errors",
    "ModelWarning": "errors",
    "Monoenergetic": "states.kinds",
    "PolarGrid": "states.kinds",
    "ScaledVDF": "scaling.scaled_vdf",
    "ScalingSolution": "scaling.closed_form",
    "Scene": "scene",
    "Solution": "solution",
    "SolverStatus": "errors",
    "SpeedDensity": "states.kinds",
    "SpeedSamples": "states.kinds",
    "SpeedTable": "states.kinds",
    "ToleranceWarning": "errors",
    "VelocitySamples": "states.kinds",
    "Viscoelastic": "collision.impact",
    "compare": "crosscheck:compare_data",
    "fit": "crosscheck:fit_data",
    "load": "loading",
    "solve": "solving",
    "solve_field": "driven.field_state",
    "solve_scaled": "scaling.scaled_vdf",
    "solve_steady": "driven.driven_state",
    "sweep": "solving",
}
#: The same for other classes that a file may hold.
STORED_CLASSES = {
    "ByCollision": "moments.by_collision",
    "Comparison": "crosscheck",
    "DiskBounce": "collision.bounce",
    "FieldUnits": "driven.field_state",
    "PlanStep": "errors",
    "Rest": "states.kinds",
    "RestitutionFunction": "collision.impact",
    "SampledBounce": "collision.bounce",
    "TabulatedRestitution": "collision.impact",
}

#: Held while a public name is imported: of two threads that import modules in another order, each
#: would see half of what the other one imports.
IMPORTING = RLock()


def import_named(name: str) -> object:
    """Import the module that defines a public name or stored class; return what has the name.

    None for a name that neither table has.
    """
    home = (PUBLIC_NAMES | STORED_CLASSES).get(name)
    if home is None:
        return None
    module, _, name_there = home.partition(":")
    with IMPORTING:
        import_module("numpy")  # waits for a thread of another package that is importing it
        value: object = getattr(import_module(f"kinetics.{module}"), name_there or name)
    return value

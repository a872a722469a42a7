"""Event-driven simulation: tracers among fixed scatterers, followed from collision to collision.

Imports nothing else of the project. Begin reading with `simulate`. Files, each of which imports
only those before it: `outputs`, `values`, `results` (estimates), `media`, `impact` (a restitution
of the impact speed), `drive` and `plan` (what is run), `datasets` and `plots`, `compiled`, `events`
(one collision; the collision law stands there alone), `streams` (random numbers), `cells`,
`slot_search` and `placement` (where the scatterers stand), `kernel` (the event loops),
`configuration` (one configuration and its tracers), `arguments` (what is refused), `ensemble` (the
result), `files`, `paths` (a picture), `executors` (threads), `simulation` (`simulate`).
"""

from importlib import import_module
from threading import RLock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from particles.ensemble import Ensemble, load
    from particles.impact import Viscoelastic
    from particles.media import (
        BoltzmannGrad,
        HardDisks,
        HardSpheres,
        Medium,
        Poisson,
        PoissonSpheres,
        Positions,
    )
    from particles.outputs import OBSERVABLES
    from particles.results import Estimate, Histogram, Statuses
    from particles.simulation import simulate

__all__ = [
    "OBSERVABLES",
    "BoltzmannGrad",
    "Ensemble",
    "Estimate",
    "HardDisks",
    "HardSpheres",
    "Histogram",
    "Medium",
    "Poisson",
    "PoissonSpheres",
    "Positions",
    "Statuses",
    "Viscoelastic",
    "load",
    "simulate",
]

#: Held while a public name is imported: of two threads that import modules in another order, each
#: would see half of what the other one imports.
_IMPORTING = RLock()


def __getattr__(name: str) -> Any:
    # Loaded at first use: `import particles` costs neither numpy nor numba.
    if name == "__version__":
        return import_module("particles.values").package_version()
    if name in __all__:
        with _IMPORTING:
            import_module("numpy")  # waits for a thread of another package that is importing it
            for file in ("outputs", "media", "impact", "results", "ensemble", "simulation"):
                module = import_module(f"particles.{file}")
                if hasattr(module, name):
                    globals()[name] = value = getattr(module, name)
                    return value
    near = ""
    if not name.startswith("_"):
        near = import_module("particles.values").suggest(name, __all__)
    raise AttributeError(f"module 'particles' has no attribute {name!r}{near}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

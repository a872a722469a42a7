"""The paper's approximations as numbers: Sonine, Chapman-Enskog, random walk and G(R).

Kim and Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Each printed formula is a
function whose docstring gives its LaTeX label. The solvers use nothing of this: reports compare
these curves with the kinetic equation. Also known as `kinetics.sonine`.

Lengths are in scatterer diameters d, speeds in U, times in d/U, number densities in d^-2. Arguments
are numbers or arrays that broadcast. They are not checked: outside its range a formula is NaN.

- `printed`: the printed formulas
- `series`: the Sonine expansion at any order
"""

from importlib import import_module
from typing import Any

_MODULES = ("printed", "series")


def __getattr__(name: str) -> Any:
    # every public name of both modules
    for module in _MODULES:
        found = vars(import_module(f"kinetics.paper.{module}"))
        if name in found and not name.startswith("_"):
            return found[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

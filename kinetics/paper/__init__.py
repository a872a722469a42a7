"""The paper's approximations as numbers: Sonine, Chapman-Enskog, random walk and G(R).

Kim and Hayakawa, "Statistical Properties of Inelastic Lorentz Gas". Each printed formula is a
function whose docstring gives its LaTeX label. Where a formula has an error, ``as_printed=False``
or a function with ``corrected`` in its name gives the right one. The solvers use nothing of this:
reports compare these curves with the kinetic equation. Also known as `kinetics.sonine`.

Lengths are in scatterer diameters d, speeds in U, times in d/U, number densities in d^-2. Arguments
are numbers or arrays that broadcast. They are not checked: outside its range a formula is NaN.

- `first_order`: a2, M2, M4, h(e), H(e), the VDF, v0(t)
- `transport`: the random walk and its <r^2>, Chapman-Enskog, the coefficient at one speed
- `position`: G(R), and fits of its two constants
- `series`: the Sonine expansion at any order
"""

from importlib import import_module
from typing import Any

_MODULES = ("first_order", "transport", "position", "series")


def __getattr__(name: str) -> Any:
    # every public name of the four modules
    for module in _MODULES:
        found = vars(import_module(f"kinetics.paper.{module}"))
        if name in found and not name.startswith("_"):
            return found[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

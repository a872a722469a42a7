"""The inelastic Lorentz equation on a discretised velocity space.

Units: lengths in scatterer diameters d, speeds in U, times in d/U.
"""

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.exact import ScalingSolution
from kinetics.scaled import ScaledVDF, SolverStatus, solve_scaled

__all__ = [
    "CollisionLaw",
    "InputError",
    "ScaledVDF",
    "ScalingSolution",
    "SolverStatus",
    "solve_scaled",
]

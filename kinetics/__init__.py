"""The inelastic Lorentz equation on a discretised velocity space.

Units: lengths in scatterer diameters d, speeds in U, times in d/U.
"""

from kinetics.collision import CollisionLaw
from kinetics.directed import AngularHarmonics, Beam, PolarGrid, VelocitySamples
from kinetics.errors import InputError
from kinetics.exact import ScalingSolution
from kinetics.initial import Gaussian, Monoenergetic, SpeedDensity, SpeedSamples, SpeedTable
from kinetics.scaled import ScaledVDF, SolverStatus, solve_scaled
from kinetics.scene import Scene
from kinetics.solution import Solution
from kinetics.solve import solve

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
    "VelocitySamples",
    "solve",
    "solve_scaled",
]

"""One collision: the only room that knows the restitutions, the dimension and how they enter.

May import `kinetics.numerics` and the checks. Begin with `law.py`, the averages that the kinetic
equation needs; `impact.py` is the bounce off a disk or a sphere, `samples.py` a bounce that is
given by weighted samples, and `quadrature.py` what both of them hand to the law. `medium.py` is the
law among scatterers at a finite density, `arguments.py` which law the arguments of a scene mean,
and `memory.py` finds the laws under which the speeds go on oscillating.
"""

from kinetics.collision.arguments import law_in_medium, law_of
from kinetics.collision.impact import DiskBounce
from kinetics.collision.law import CollisionLaw
from kinetics.collision.medium import MediumLaw
from kinetics.collision.quadrature import ImpactQuadrature, Survival

__all__ = [
    "CollisionLaw",
    "DiskBounce",
    "ImpactQuadrature",
    "MediumLaw",
    "Survival",
    "law_in_medium",
    "law_of",
]

"""One collision: the only room that knows the restitutions, the dimension and how they enter.

May import `kinetics.numerics` and the checks. Begin with `law.py`, the averages that the kinetic
equation needs, and the law that the arguments of a scene mean; `bounce.py` is the bounce off a disk
or a sphere, or one given by weighted samples, and the weighted sums made of it. `medium.py` is the
theory of a finite density.
"""

from kinetics.collision.bounce import ImpactQuadrature
from kinetics.collision.law import CollisionLaw, law_in_medium, law_of

__all__ = ["CollisionLaw", "ImpactQuadrature", "law_in_medium", "law_of"]

"""One collision: the only room that knows the restitutions, the dimension and how they enter.

- `law`: CollisionLaw, the averages that the kinetic equation needs, and the law that the arguments
  of a scene mean
- `weighted_bounces`: the averages of one collision, a weighted sum of bounces
- `bounce`: the bounce off a disk or a sphere, or one given by weighted samples
- `quadrature`: the weighted sums made of it
- `medium`: the theory of a finite density, with its constants in `return_constants`

May import `kinetics.numerics` and the checks. Begin with `law.py`.
"""

from kinetics.collision.law import CollisionLaw, law_in_medium, law_of
from kinetics.collision.quadrature import ImpactQuadrature

__all__ = ["CollisionLaw", "ImpactQuadrature", "law_in_medium", "law_of"]

"""What follows from the premises: a derivation for each label, registered when this is imported.

One file for a section of the paper; for what the paper does not have ``scaling_state`` (its
collision law), ``any_law`` (tangential restitution, space, a mass), ``any_dimension`` (moments
and displacement), ``finite_density``, ``uniform_field`` and ``driven``. ``record`` holds what a
derivation leaves.

May import: ``symbols``, ``formal``, ``premises``; never ``printed``, so that nothing printed can
be taken for derived. Begin reading with ``record``, then ``sonine``.
"""

from . import (  # noqa: F401  (they register their derivations)
    any_dimension,
    any_law,
    cooling,
    diffusion,
    driven,
    finite_density,
    kinetic_equation,
    position,
    random_walk,
    scaling_state,
    sonine,
    statements,
    steepest_descent,
    transport,
    uniform_field,
)
from .record import REGISTRY

__all__ = ["REGISTRY"]

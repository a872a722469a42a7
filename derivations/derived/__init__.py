"""What follows from the premises: one function per label, registered by ``@derives(label)``.

One file per part of the paper, and for what the paper does not have ``closed_forms`` and
``scaling_state`` (the paper's collision law), ``any_law`` (tangential restitution, space) and
``any_dimension`` (moments and displacement), ``finite_density`` (scatterers that are met again);
``record`` holds what a derivation leaves.

May import: ``symbols``, ``formal``, ``typesetting``, ``premises``; never ``printed``, so that
nothing printed can be taken for derived. Begin reading with ``record``, then ``sonine``.
"""

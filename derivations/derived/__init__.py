"""What follows from the premises: one function per label, registered by ``@derives(label)``.

One file per part of the paper, and ``scaling_state`` and ``closed_forms`` for what the paper does
not have; ``record`` holds what a derivation leaves. May import: ``symbols``, ``formal``,
``typesetting``, ``premises``; never ``printed``, so that nothing printed can be taken for derived.
Begin reading with ``record``, then ``sonine``.
"""

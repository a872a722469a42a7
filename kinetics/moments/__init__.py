"""Averages of the velocity and of the displacement, by the backward equation.

Each average is one smooth function of v t, averaged over the initial state. May import
`kinetics.states`, `kinetics.collision` and `kinetics.numerics`. Begin with `backward.py`, the
equation; `averages.py` averages over a state, and has the outputs that are made of that;
`by_collision.py` has the closed forms after N collisions.
"""

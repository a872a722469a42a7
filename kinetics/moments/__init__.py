"""Averages of the velocity and of the displacement, by the backward equation.

Each average is one smooth function of v t, averaged over the initial state. May import
`kinetics.states`, `kinetics.collision` and `kinetics.numerics`. Begin with `backward.py`, the
equation; `resolution.py` says how many nodes it needs, `velocity.py` averages over a state, and
`displacement.py` has the outputs that are made of the displacement.
"""

"""Initial states: the contract of a State, isotropic and directed ones, and their quadrature.

A state gives weighted points on the axis of ln v for each angular harmonic. May import
`kinetics.numerics` and the checks. Begin with `isotropic.py`, the class State.
"""

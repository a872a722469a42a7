"""Densities of the velocity in time: f(v, t) and its angular harmonics.

May import `kinetics.scaling`, `kinetics.moments`, `kinetics.states`, `kinetics.collision` and
`kinetics.numerics`. Begin with `harmonic.py`, what a solved density is, then `spectral.py`.
"""

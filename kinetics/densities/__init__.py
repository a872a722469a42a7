"""Densities of the velocity in time: f(v, t) and its angular harmonics.

May import `kinetics.scaling`, `kinetics.moments`, `kinetics.states`, `kinetics.collision`,
`kinetics.numerics` and `kinetics.values`. Begin with `harmonic.py`: what every solver here is
asked, and what it gives. `spectral.py` solves smooth states, with `gain.py`, `intertwining.py` and
`stepping.py`; `conservative.py` rough ones; `elastic.py` e = 1. `marginal.py` integrates one
component out.
"""

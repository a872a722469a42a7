"""Densities of the velocity in time: f(v, t) and its angular harmonics, for any collision law.

Begin with `harmonic.py`: what every solver here is asked, and what it gives. `spectral.py` solves
smooth states, with `intertwining.py`; `conservative.py` rough ones. Below it are
`kinetics.scaling`, `kinetics.moments`, `kinetics.states`, `kinetics.collision`,
`kinetics.numerics` and `kinetics.results`.
"""

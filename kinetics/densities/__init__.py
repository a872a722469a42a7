"""Densities of the velocity in time: f(v, t) and its angular harmonics, for any collision law.

Begin with `harmonic.py`: what every solver here is asked, and what it gives. `spectral.py` solves
smooth states, with `gain.py` and `intertwining.py`; `conservative.py` rough ones. `marginal.py`
integrates the other components out. Below it are `kinetics.scaling`, `kinetics.moments`,
`kinetics.states`, `kinetics.collision`, `kinetics.numerics` and `kinetics.results`.
"""

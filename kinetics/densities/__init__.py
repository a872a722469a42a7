"""Densities of the velocity in time: f(v, t) and its angular harmonics.

May import `kinetics.scaling`, `kinetics.moments`, `kinetics.states`, `kinetics.collision`,
`kinetics.numerics` and `kinetics.results`. Begin with `harmonic.py`: what every solver here is
asked, and what it gives. `spectral.py` solves smooth states, with `gain.py`, `intertwining.py` and
`stepping.py`; `conservative.py` rough ones, with `node_masses.py` and `conservative_errors.py`;
`elastic.py` laws that keep the speed. `marginal.py` integrates the other components out.

All of it is for any collision law. A harmonic f_m is a density of the speed in the plane and in
space alike; the dimension enters where f(v, phi) is made of them (`harmonic.angular_function`, and
the volume element in `kinetics.solution`) and in `marginal.py`.
"""

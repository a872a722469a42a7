"""The equation in a uniform field, in the limit of low density.

A tracer falls freely between its collisions, with the acceleration g, so speeds and times have
scales of their own: sqrt(g l) and sqrt(l/g), l the mean free path. In these units the equation has
no parameter but the collision law,

    d_t f + d_z f = v (gain - f),        d_z the derivative by the velocity along the field.

Angular harmonics about the field turn it into a chain in which each harmonic meets its two
neighbours only. `panels` discretises the speed, `collisions` the gain on it, `ladder` eliminates
the chain. Then `steady` solves for the steady state and the dispersion about it, with the panels
and harmonics of `resolution`, `steady_density` makes the density at one velocity of it, and
`solution` holds the answer of `solve_field`. Over time,
`backward` takes averages from step to step by the rule of `radau`, and `evolution` averages them
over an initial state (`starts`), one of few directions through `first_collision`;
`kinetics.in_field` makes the outputs of a scene of them. `forward` takes a density from step to
step, `last_flight` makes the density at one velocity of it, `collided_once` is a closed form for
starts of sharp velocities, and `densities` joins these to the densities of a scene.

May import `kinetics.numerics`, `kinetics.collision`, `kinetics.states` and the modules that serve
all rooms. Begin with `steady.py`,
over time with `evolution.py` and `densities.py`.
"""

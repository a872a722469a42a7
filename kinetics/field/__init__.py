"""The equation in a uniform field, in the limit of low density.

A tracer falls freely between its collisions, with the acceleration g, so speeds and times have
scales of their own: sqrt(g l) and sqrt(l/g), l the mean free path. In these units the equation has
no parameter but the collision law,

    d_t f + d_z f = v (gain - f),        d_z the derivative by the velocity along the field.

`system` says what drives a tracer, and how fast it may be; `restitution` has laws of the impact
speed. `harmonics` about the field turn the equation into a chain in which each meets its two
neighbours only, and solve it. `grid` discretises the speed, and gain and loss on it. Over time,
`march` goes from step to step by the rule of `radau`, from one initial state (`starts`); `density`
has densities of the velocity, over time and of the steady state, and `scene` makes the outputs.
Every error is the difference of two solutions, one coarser.

May import `kinetics.numerics`, `kinetics.collision`, `kinetics.states` and the modules that serve
all rooms. Begin with `harmonics.py`.
"""

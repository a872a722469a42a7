"""The equation in a uniform field, in the limit of low density.

A tracer falls freely between its collisions, with the acceleration g, so speeds and times have
scales of their own: sqrt(g l) and sqrt(l/g), l the mean free path. In these units the equation has
no parameter but the collision law,

    d_t f + d_z f = v (gain - f),        d_z the derivative by the velocity along the field.

Angular harmonics about the field turn it into a chain in which each harmonic meets its two
neighbours only. `grid` discretises the speed, and gain and loss on it; `elimination` solves the
chain. `steady` makes the density of the steady state of that; its averages, and `solve_field`, are
in `kinetics.driven`. Over time, `forward` takes a density from step to step by the rule of `radau`,
`evolution` follows one initial state (`starts`), and `scene` makes the outputs of a scene.
`density` has the density at one velocity. Every error is the difference of two solutions, one
coarser.

May import `kinetics.numerics`, `kinetics.collision`, `kinetics.states` and the modules that serve
all rooms. Begin with `evolution.py`.
"""

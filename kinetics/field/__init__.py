"""The equation in a uniform field, in the limit of low density.

A tracer falls freely between its collisions, with the acceleration g, so speeds and times have
scales of their own: sqrt(g l) and sqrt(l/g), l the mean free path. In these units the equation has
no parameter but the collision law,

    d_t f + d_z f = v (gain - f),        d_z the derivative by the velocity along the field.

`harmonics` about the field turn it into a chain in which each meets its two neighbours only. `grid`
discretises the speed, and gain and loss on it; `elimination` solves the chain, `steady` for the
density of the steady state. Over time, `march` goes from step to step by the rule of `radau`,
`forward` follows one initial state (`starts`), `density` has its density at one velocity, and
`scene` makes the outputs. Every error is the difference of two solutions, one coarser.

May import `kinetics.numerics`, `kinetics.collision`, `kinetics.states` and the modules that serve
all rooms. Begin with `march.py`.
"""

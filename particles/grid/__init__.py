"""Where the scatterers stand: cells that list them, placed in a box or drawn where a tracer goes.

May import: `particles.compiled`, `particles.events`, `particles.streams`, `particles.media`.
Begin reading with `cells`, then `build`, which makes the scatterers of one configuration. `space`
and `spheres` are what differs in three dimensions.
"""

"""Where the scatterers stand: square cells that list them, placed in a box or drawn in the plane.

May import: `particles.compiled`, `particles.events`, `particles.streams`, `particles.media`.
Begin reading with `cells`, then `build`, which makes the scatterers of one configuration.
"""

"""The compiled loops that follow tracers, and what they write down.

May import: `particles.grid`, `particles.events`, `particles.streams`; nothing else of the package.
Begin reading with `follow`, then `lane` (the state of one tracer) and `records` (what is kept).
"""

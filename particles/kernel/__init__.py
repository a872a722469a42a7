"""The compiled loops that follow tracers, and what they write down.

Begin reading with `follow`, whose steps are in `steps` (with `pockets`), then `lane` (the state of
one tracer) and `records` (what is kept). In a field: `follow_falling`, with `falling`, `parabola`
and `sliding`. Driven, without scatterers: `driven`. `columns` imports nothing.
"""

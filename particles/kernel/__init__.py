"""The compiled loops that follow tracers, and what they write down.

Begin reading with `follow`: its steps are in `steps` (with `pockets`), in a field in `falling`,
`parabola` and `sliding`; then `lane` (the state of one tracer) and `records` (what is kept).
Driven, without scatterers: `driven`.
"""

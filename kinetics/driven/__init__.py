"""Tracers that are driven, or whose restitution depends on the impact speed: one generator.

What is elsewhere in the package scales with the speed and only cools. Here scatterers may move (a
bath), white noise, drag and a field may act, the restitution may depend on the impact speed, and
slow impacts may stick. What is asked is a `kinetics.field.system.System`; `generator` is the
equation on an `axis` of speeds, and its steady state; `steady`, `field` and `scene` answer
`kinetics.solve_steady`, `solve_field` and `solve`.
"""

"""The compiled loops that follow tracers, and what they write down.

May import: `particles.grid` and what that may import. `columns` imports nothing.
Begin reading with `follow`, whose steps are in `in_plane` and `in_space` (with `pockets`), then
`lane` (the state of one tracer) and `records` (what is kept). In a field: `follow_in_field`, whose
steps are in `in_field` (with `contact_in_field`) and `slide` (with the rules in `sliding`).
"""

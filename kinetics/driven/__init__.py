"""Tracers that are driven, or whose restitution depends on the impact speed.

What is elsewhere in the package scales with the speed and only cools. Here scatterers may move (a
bath), white noise, drag and a field may act, the restitution may depend on the impact speed, and
slow impacts may stick: a `kinetics.drive.Drive`. From the question to the numbers:

- `driven_state`, `field_state` answer `kinetics.solve_steady` and `solve_field`; `steady_state` is
  what they share, `steady_solution` the solution at one resolution
- `field_answer`, `driven_answer` answer scenes over time; `answer_over_time` is what they share,
  `over_time` makes the outputs;
  `field_evolution` and `driven_evolution` the solutions at one resolution, by the steps of `march`
- `averages` : the table of averages over time
- `generator` : the equation of the velocity, harmonic by harmonic (`harmonics`), on an axis of
  speeds: `chebyshev_axis`; in a field alone over time on `panels`, with `panel_collisions`
- `starts`, `free_fall` : initial states; `last_flights`, `velocity_density`, `steady_density` :
  densities in a field; `heated` : a closed form
- `resolution`, `speed_range`, `radau` : how finely, up to which speed, and steps of time

Begin with `generator`, then `steady_solution`.
"""

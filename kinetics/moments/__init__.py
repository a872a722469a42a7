"""Averages of the velocity and of the displacement, by the backward equation.

Each average is one smooth function of v t, averaged over the initial state. May import
`kinetics.states`, `kinetics.collision`, `kinetics.results` and `kinetics.numerics`. From the ground
up:

- `observables`: what is averaged, and what drives it
- `backward`: the equation, solved on panels in ln(v t/l); begin here
- `loops`, `delayed`, `delayed_equation`: the same in a medium, where returns to the scatterer
  before take time
- `start`, `point_average`, `averages`: averages over an initial state
- `outputs`: the outputs of a scene that are made of averages, one row of a table each
- `by_collision`: closed forms after N collisions
"""

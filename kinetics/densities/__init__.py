"""Densities of the velocity in time: f(v, t) and its angular harmonics, for any collision law.

Begin with `harmonic`: what a solver is asked, what it provides, and what it gives.

- `harmonic`: the contract of a harmonic and of its solvers
- `elastic`, `spectral`, `conservative`: the solvers, for e = 1, for smooth starts, for rough ones
- `spectral_grid`, `grid_density`, `intertwining`, `gain`, `turned_axis`: of the spectral one, its
  nodes, the density between them, and how collisions are taken out of the equation
- `node_masses`, `uniformisation`: of the conservative one, its state and how that collides
- `velocity_component`: the density of one Cartesian component
- `speed_shares`, `log_panels`, `sharp_tracers`: the speeds as points, for averages over the tracers
- `flights`: free flights; `fronts`: speeds at which a density is not smooth

Below it are `kinetics.scaling`, `kinetics.moments`, `kinetics.states`, `kinetics.collision`,
`kinetics.numerics` and `kinetics.results`.
"""

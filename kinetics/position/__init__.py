"""The distribution of the displacement: F(k, t), g(r, t) and G(R).

- `scattering`: one system of equations for each wave number; `waves`: what it gives;
  `intermediate_scattering`: F(k, t)
- `directions`: what depends on the dimension
- `returned`: returns to the scatterer before, at a finite density
- `density`: g(r, t) as a result; `solve_density`: the tracers of each of few speeds for
  themselves; `sweep`: which wave numbers they take
- `sampling`: at which of them F is solved for; `tail`, `front_tail`: how F ends in k
- `coupled_harmonics`: the linear systems of `scattering`
- `ballistic_front`, `once_collided`, `twice_collided`: tracers that have not collided, and that
  have collided once, and twice

May import `kinetics.moments`, `kinetics.states`, `kinetics.collision` and `kinetics.numerics`.
Begin with `scattering.py`.
"""

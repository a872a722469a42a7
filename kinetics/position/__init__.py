"""The distribution of the displacement: F(k, t), g(r, t) and G(R).

- `scattering`: one system of equations for each wave number; `waves`: what it gives;
  `intermediate_scattering`: F(k, t)
- `directions`: what depends on the dimension
- `returned`: returns to the scatterer before, at a finite density
- `density`: g(r, t) as a result; `sweep`: which wave numbers it takes; `wave_panel`: F on an
  interval of them; `tail`: how F ends in k
- `coupled_harmonics`: the linear systems of `scattering`
- `ballistic_front`: tracers that have not collided

May import `kinetics.moments`, `kinetics.states`, `kinetics.collision` and `kinetics.numerics`.
Begin with `scattering.py`.
"""

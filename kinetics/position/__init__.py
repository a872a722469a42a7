"""The distribution of the displacement: F(k, t), g(r, t) and G(R).

May import `kinetics.moments`, `kinetics.states`, `kinetics.collision` and `kinetics.numerics`.
Begin with `scattering.py`: one system of equations for each wave number (`directions`).
`intermediate_scattering` is F(k, t), `density` g(r, t) as a result; `sweep` says which wave
numbers it takes, `wave_numbers` holds F on them and how it ends.
"""
